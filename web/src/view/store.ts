// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Bytes that are seldom asked for, where the browser may put them on its disk: many in one file, since to make a file
// costs it more than to unpack a picture.

const FILE_BYTES = 8 << 20;

export type Bytes = Uint8Array<ArrayBuffer>;

export class Kept {
  constructor(private held: Bytes | { file: Blob; from: number; to: number }) {}

  get bytes(): Bytes | Blob {
    return this.held instanceof Uint8Array ? this.held : this.held.file.slice(this.held.from, this.held.to);
  }

  moveTo(file: Blob, from: number, to: number): void {
    this.held = { file, from, to };
  }
}

export class Store {
  private waiting = new Map<Kept, Bytes>();
  private size = 0;

  keep(bytes: Uint8Array): Kept {
    const own = new Uint8Array(bytes);
    const kept = new Kept(own);
    this.waiting.set(kept, own);
    this.size += own.length;
    if (this.size > FILE_BYTES) this.move();
    return kept;
  }

  /** It is not wanted any more. */
  drop(kept: Kept | null): void {
    if (kept === null) return;
    this.size -= this.waiting.get(kept)?.length ?? 0;
    this.waiting.delete(kept);
  }

  private move(): void {
    const file = new Blob([...this.waiting.values()]);
    let from = 0;
    for (const [kept, { length }] of this.waiting) {
      kept.moveTo(file, from, from + length);
      from += length;
    }
    this.waiting = new Map();
    this.size = 0;
  }
}
