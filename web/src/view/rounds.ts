// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0

const ROUND_MS = 250;

/** Work that follows pictures but not every one: four times a second, and once more at rest. */
export class Rounds {
  private next: ReturnType<typeof setTimeout> | undefined;
  private last = -ROUND_MS;

  constructor(private readonly work: () => unknown) {}

  hold(): void {
    clearTimeout(this.next);
  }

  soon(now: number): void {
    this.hold();
    this.next = setTimeout(() => {
      this.last = performance.now();
      this.work();
    }, Math.max(0, ROUND_MS - (now - this.last)));
  }
}
