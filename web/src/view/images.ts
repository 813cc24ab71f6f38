// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Compressed pictures to pixels, in their turn, colours untouched. All but the live image by threads beside the page's.

const AT_ONCE = 64;
/** Before workers that failed are started again. */
const PAUSE_MS = 2000;

export interface Size {
  width: number;
  height: number;
}

/** A JPEG or PNG, with a mask of its size or none; as RGBA of these sizes, null for its own, and as a bitmap: of its own
 *  size, of another, or none. */
export interface Job {
  id: number;
  picture: Uint8Array<ArrayBuffer> | Blob;
  mask: Uint8Array<ArrayBuffer> | Blob | null;
  sizes: (Size | null)[];
  bitmap: Size | "own" | null;
}

export interface Unpacked extends Size {
  /** First row first; transparent where the mask is black. */
  pixels: Uint8ClampedArray<ArrayBuffer>[];
  /** Colours multiplied by alpha: a graphics card takes it as it is. */
  bitmap: ImageBitmap | null;
}

export type Outcome = { id: number } & (Unpacked | { fault: string });

interface Waiting {
  job: Job;
  /** It was in the hands of a thread that failed. */
  wasLost: boolean;
  resolve(unpacked: Unpacked): void;
  reject(fault: Error): void;
}

const pending = new Map<number, Waiting>();
const queue: Job[] = [];
/** Were in the hands of a thread that failed by one of them: each is tried once more, alone. */
const suspects: Job[] = [];
let isTrying = false;
let failed = false;
let jobs = 0;
let workers: Worker[] = [];

/** Before there is something to unpack: the threads take a while to start. */
export function getReady(): void {
  if (workers.length === 0) workers = startWorkers();
}

/** Pictures that are still to be unpacked. */
export function unpacking(): number {
  return pending.size;
}

/** In its turn. Rejects when it cannot be decoded. */
export async function unpack(
  picture: Uint8Array | Blob,
  mask: Uint8Array | Blob | null,
  sizes: (Size | null)[],
  bitmap: Job["bitmap"] = null,
): Promise<Unpacked> {
  return new Promise((resolve, reject) => {
    const job = { id: ++jobs, picture: own(picture), mask: mask === null ? null : own(mask), sizes, bitmap };
    pending.set(job.id, { job, wasLost: false, resolve, reject });
    queue.push(job);
    handOut();
  });
}

/** A JPEG at once. Rejects when it cannot be decoded. */
export async function decodeNow(jpeg: Uint8Array): Promise<ImageBitmap> {
  return createImageBitmap(new Blob([own(jpeg)], { type: "image/jpeg" }), { colorSpaceConversion: "none", premultiplyAlpha: "none" });
}

function own<Picture extends Blob>(picture: Uint8Array | Picture): Uint8Array<ArrayBuffer> | Picture {
  return picture instanceof Uint8Array ? new Uint8Array(picture) : picture;
}

function handOut(): void {
  if (failed) return;
  getReady();
  for (;;) {
    const inHand = pending.size - queue.length - suspects.length;
    if (inHand >= (suspects.length > 0 || isTrying ? 1 : AT_ONCE)) return;
    isTrying = suspects.length > 0;
    const job = suspects.shift() ?? queue.shift();
    if (job === undefined) return;
    workers[job.id % workers.length]?.postMessage(job);  // a copy: it may be lost there
  }
}

function startWorkers(): Worker[] {
  return Array.from({ length: navigator.hardwareConcurrency > 2 ? 2 : 1 }, () => {
    const worker = new Worker("unpacker.js", { type: "module" });
    worker.addEventListener("message", (event: MessageEvent<Outcome>) => {
      const { data } = event;
      const waiting = pending.get(data.id);
      pending.delete(data.id);
      if ("fault" in data) waiting?.reject(new Error(data.fault));
      else waiting?.resolve(data);
      handOut();
    });
    worker.addEventListener("error", startAgain);
    worker.addEventListener("messageerror", startAgain);
    return worker;
  });
}

/** What was in hand becomes suspect; what was so before was what the thread failed by. */
function startAgain(): void {
  if (failed) return;
  failed = true;
  workers.forEach((worker) => { worker.terminate(); });
  workers = [];
  const waiting = new Set([...suspects, ...queue]);
  const inHand = [...pending.values()].filter(({ job }) => !waiting.has(job));
  for (const lost of inHand.filter(({ wasLost }) => wasLost)) {
    pending.delete(lost.job.id);
    lost.reject(new Error("the thread that unpacks pictures failed"));
  }
  const again = inHand.filter(({ wasLost }) => !wasLost);
  for (const one of again) one.wasLost = true;
  suspects.push(...again.map(({ job }) => job));
  setTimeout(() => {
    failed = false;
    handOut();
  }, PAUSE_MS);
}
