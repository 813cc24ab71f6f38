// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Points over the map that can be touched: marks, gaps, the ends of the ruler.
import type { Vec3 } from "../wire/records";
import { byId, el, icon, plain, type Icon } from "./dom";

export interface Pin {
  key: string;
  at: Vec3;
  label: string;
  kind: "mark" | "end";
  onTap?: () => void;
}

const ICONS: Record<Pin["kind"], Icon | null> = { mark: "pin", end: null };

export class Pins {
  private readonly root = el("div", "pins");
  private shown = new Map<string, { element: HTMLElement; at: Vec3 }>();

  constructor(private readonly screenOf: (at: Vec3) => { x: number; y: number } | null) {
    byId("canvas").after(this.root);
  }

  /** Replaces all pins of a kind. */
  set(kind: Pin["kind"], pins: readonly Pin[]): void {
    for (const [key, { element }] of this.shown) {
      if (element.dataset["kind"] === kind && !pins.some((pin) => pin.key === key)) {
        element.remove();
        this.shown.delete(key);
      }
    }
    for (const pin of pins) {
      const known = this.shown.get(pin.key)?.element;
      const element = known ?? this.make(pin);
      element.setAttribute("aria-label", plain(pin.label));
      this.shown.set(pin.key, { element, at: pin.at });
    }
    this.place();
  }

  /** After every picture drawn. */
  place(): void {
    for (const { element, at } of this.shown.values()) {
      const place = this.screenOf(at);
      element.hidden = place === null;
      if (place !== null) element.style.translate = `${place.x}px ${place.y}px`;
    }
  }

  private make({ kind, onTap }: Pin): HTMLElement {
    const picture = ICONS[kind];
    const content = el("i", "dot", ...(picture === null ? [] : [icon(picture)]));
    const element = onTap === undefined ? el("span", "pin", content) : el("button", "pin", content);
    if (onTap === undefined) element.setAttribute("role", "img");
    else element.addEventListener("click", onTap);
    element.dataset["kind"] = kind;
    this.root.append(element);
    return element;
  }
}
