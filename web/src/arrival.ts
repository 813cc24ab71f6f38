// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0

/** A link that never carries all there is is no reason to draw coarsely for ever. */
const LONGEST_MS = 10_000;

/** Whether what there was when the link came up is still to be drawn: it comes all at once. */
export class Arrival {
  isUnderWay = true;
  private timer: ReturnType<typeof setTimeout> | undefined;

  constructor(private readonly onEnd: () => void) {}

  begin(): void {
    this.isUnderWay = true;
    clearTimeout(this.timer);
    this.timer = setTimeout(() => {
      this.end();
    }, LONGEST_MS);
  }

  end(): void {
    clearTimeout(this.timer);
    if (!this.isUnderWay) return;
    this.isUnderWay = false;
    this.onEnd();
  }
}
