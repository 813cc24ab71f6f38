// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A Blob lies in the browser's memory, one that was fetched from a database in a file. The entries are removed by the next
// page that is opened: Chromium and Firefox keep the file of one that is held until then.

const NAME = "nadir";
const FILES = "files";

let database: Promise<IDBDatabase> | undefined;

/** The same bytes on the disk; where the browser cannot do that, the Blob that was given. */
export async function onDisk(file: Blob): Promise<Blob> {
  try {
    database ??= open();
    const opened = await database;
    const files = () => opened.transaction(FILES, "readwrite").objectStore(FILES);
    const key = await done(files().add(file));
    const stored = await done(files().get(key) as IDBRequest<Blob | undefined>);
    return stored ?? file;
  } catch {
    return file;
  }
}

/** Without what pages before this one have left there. */
async function open(): Promise<IDBDatabase> {
  const request = indexedDB.open(NAME);
  request.addEventListener("upgradeneeded", () => { request.result.createObjectStore(FILES, { autoIncrement: true }); });
  const opened = await done(request);
  await done(opened.transaction(FILES, "readwrite").objectStore(FILES).clear());
  return opened;
}

async function done<Result>(request: IDBRequest<Result>): Promise<Result> {
  return new Promise((resolve, reject) => {
    request.addEventListener("success", () => { resolve(request.result); });
    request.addEventListener("error", () => { reject(request.error ?? new Error("the browser's database failed")); });
  });
}
