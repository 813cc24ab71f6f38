// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Keeps a moving picture fluent on a weak graphics card, and a still one sharp.

/** A picture that takes longer is not followed by a hand. */
const MOST_MS = 45;
const LITTLE_MS = 22;
/** Pictures that must agree before the quality changes. */
const SAMPLES = 5;
/** Longer between two pictures is a rest. */
const REST_MS = 250;

/** Side of a pixel against the screen's, and points left out in each direction, from fine to coarse. */
export const QUALITIES = [
  { resolution: 1, stride: 1 },
  { resolution: 0.75, stride: 1 },
  { resolution: 0.6, stride: 2 },
  { resolution: 0.5, stride: 3 },
  { resolution: 0.4, stride: 4 },
] as const;
export type Quality = (typeof QUALITIES)[number];

export class Budget {
  /** Told when a picture at rest is due in full quality. */
  onRest: () => void = () => undefined;
  private level = 0;
  private last = -Infinity;
  private intervals: number[] = [];
  private resting = true;
  private rest: ReturnType<typeof setTimeout> | undefined;

  /** With the time at which a picture is begun, in milliseconds; the quality it is to have. */
  begin(now: number): Quality {
    const interval = now - this.last;
    this.last = now;
    const isRest = this.resting;
    this.resting = false;
    if (interval < REST_MS && !isRest) this.judge(interval);
    clearTimeout(this.rest);
    if (isRest) return QUALITIES[0];
    if (this.level > 0) {
      this.rest = setTimeout(() => {
        this.resting = true;
        this.onRest();
      }, REST_MS);
    }
    return QUALITIES[this.level] ?? QUALITIES[0];
  }

  private judge(interval: number): void {
    this.intervals.push(interval);
    if (this.intervals.length < SAMPLES) return;
    const median = [...this.intervals].sort((one, other) => one - other)[Math.floor(SAMPLES / 2)] ?? 0;
    this.intervals = [];
    if (median > MOST_MS) this.level = Math.min(this.level + 1, QUALITIES.length - 1);
    else if (median < LITTLE_MS) this.level = Math.max(this.level - 1, 0);
  }
}
