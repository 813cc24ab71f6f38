// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Bytes that are seldom asked for, on the browser's disk: many in one file, since to make a file costs it more than to
// unpack a picture. The newest stay with the page: tiles are superseded soon, and a page that is told a whole dive at once
// has better to do.
import { onDisk } from "./disk_file";

const FILE_BYTES = 8 << 20;
const HELD_BYTES = 32 << 20;

export type Bytes = Uint8Array<ArrayBuffer>;

/** First in memory, then on the disk. */
interface Stored {
  blob: Blob;
}

export class Kept {
  constructor(private held: Bytes | { file: Stored; from: number; to: number }) {}

  get bytes(): Bytes | Blob {
    return this.held instanceof Uint8Array ? this.held : this.held.file.blob.slice(this.held.from, this.held.to);
  }

  moveTo(file: Stored, from: number, to: number): void {
    this.held = { file, from, to };
  }
}

export class Store {
  /** In no file yet, the oldest first. */
  private waiting = new Map<Kept, Bytes>();
  private size = 0;

  keep(bytes: Uint8Array): Kept {
    const own = new Uint8Array(bytes);
    const kept = new Kept(own);
    this.waiting.set(kept, own);
    this.size += own.length;
    if (this.size > HELD_BYTES) this.moveOldest();
    return kept;
  }

  /** It is not wanted any more. */
  drop(kept: Kept | null): void {
    if (kept === null) return;
    this.size -= this.waiting.get(kept)?.length ?? 0;
    this.waiting.delete(kept);
  }

  private moveOldest(): void {
    const moved = new Map<Kept, Bytes>();
    let size = 0;
    for (const [kept, bytes] of this.waiting) {
      if (size >= FILE_BYTES) break;
      moved.set(kept, bytes);
      size += bytes.length;
    }
    const file = { blob: new Blob([...moved.values()]) };
    void onDisk(file.blob).then((stored) => (file.blob = stored));
    let from = 0;
    for (const [kept, { length }] of moved) {
      kept.moveTo(file, from, from + length);
      from += length;
      this.waiting.delete(kept);
    }
    this.size -= size;
  }
}
