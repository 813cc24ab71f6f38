// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import type { State } from "../wire/records";
import { byId, el, say } from "./dom";
import { S } from "./strings";

const WIDEST_PX = 160;

/** How long a metre is on the map, and where north is when it is known. */
export class ScaleBar {
  private readonly bar = el("i", "ruler");
  private readonly text = el("span", "");
  private readonly north = el("b", "north", S.north);
  private unit = "m";

  constructor() {
    this.north.hidden = true;
    byId("scale").append(this.north, this.bar, this.text);
  }

  setState(state: State): void {
    this.unit = state.scale === "none" ? S.units : "m";
    this.north.hidden = state.axes !== "attitude";
  }

  /** Survey units a CSS pixel covers. */
  show(unitsPerPixel: number): void {
    const length = roundDown(WIDEST_PX * unitsPerPixel);
    this.bar.style.width = `${length / unitsPerPixel}px`;
    const centimetres = this.unit === "m" && length < 1;
    say(this.text, centimetres ? `${Number((100 * length).toPrecision(1))} cm` : `${Number(length.toPrecision(1))} ${this.unit}`);
  }
}

/** The greatest of 1, 2, 5 times a power of ten that is not greater. */
export function roundDown(value: number): number {
  const power = 10 ** Math.floor(Math.log10(value));
  return power * ([5, 2, 1].find((step) => step * power <= value) ?? 1);
}
