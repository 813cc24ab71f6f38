// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import type { State } from "../wire/records";

/** An hour of images without a picture: nobody looks. */
const MOST = 36_000;

/** How long there have been newer images than the one that is shown: over a thin link the state comes before pictures. */
export class Delay {
  /** Images that are newer, by the time of the dive, and when they were told of, s. */
  private newer: { time: number; told: number }[] = [];

  setState(state: State, now: number): void {
    if (state.finished || this.newer.length >= MOST) this.newer = [];
    else if (state.time > (this.newer.at(-1)?.time ?? -Infinity)) this.newer.push({ time: state.time, told: now });
  }

  /** Seconds; 0 when there is none. The image shown never becomes an older one. */
  of(shown: number, now: number): number {
    while (this.newer[0] !== undefined && this.newer[0].time <= shown) this.newer.shift();
    return this.newer[0] === undefined ? 0 : now - this.newer[0].told;
  }
}
