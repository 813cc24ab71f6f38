// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What a tap on the ground does: measure, mark, ask what is there.
import type { Pick, View } from "../view/view";
import type { State, Vec3 } from "../wire/records";
import { byId, el, icon, say, type Icon } from "./dom";
import type { Pins } from "./pins";
import { amount, clock, S } from "./strings";

export type Hand = "ruler" | "mark" | "probe";

const ICONS: Record<Hand, Icon> = { ruler: "ruler", mark: "pin", probe: "question" };
/** A finger hits a point of the screen within so many CSS px, one sigma. */
const FINGER_PX = 3;

export class Hands {
  /** Told where a mark is wanted. */
  onMark: (point: Vec3, image: number | null) => void = () => undefined;
  private readonly root = byId("hint");
  private readonly text = el("p", "text");
  private readonly picture = el("span", "picture");
  private hand: Hand | null = null;
  private ends: Pick[] = [];
  private state: State | null = null;

  constructor(
    private readonly view: View,
    private readonly pins: Pins,
  ) {
    const done = el("button", "seen", icon("cross"), el("span", "label", S.hands.done));
    done.type = "button";
    done.addEventListener("click", () => {
      this.take(null);
    });
    this.root.append(this.picture, this.text, done);
    this.root.hidden = true;
    view.onTap = (x, y) => {
      this.tap(x, y);
    };
  }

  get current(): Hand | null {
    return this.hand;
  }

  setState(state: State): void {
    this.state = state;
  }

  take(hand: Hand | null): void {
    this.hand = hand;
    this.ends = [];
    this.showRuler();
    this.root.hidden = hand === null;
    if (hand === null) return;
    this.picture.replaceChildren(icon(ICONS[hand]));
    say(this.text, { ruler: S.hands.rulerHint, mark: S.hands.markHint, probe: S.hands.probeHint }[hand]);
  }

  private tap(x: number, y: number): void {
    if (this.hand === null) return;
    const pick = this.view.pick(x, y);
    if (pick === null) {
      say(this.text, S.hands.nothing);
      return;
    }
    if (this.hand === "ruler") this.measure(pick);
    else if (this.hand === "probe") this.probe(pick);
    else {
      this.take(null);
      this.onMark(pick.point, pick.sights[0]?.image ?? null);
    }
  }

  private measure(pick: Pick): void {
    this.ends = this.ends.length === 1 ? [...this.ends, pick] : [pick];
    this.showRuler();
    const [from, to] = this.ends;
    if (from === undefined || to === undefined) {
      say(this.text, S.hands.rulerNext);
      return;
    }
    const { length, sigma } = this.length(from, to);
    const text = amount(length, this.unit);
    say(this.text, sigma === null ? S.hands.lengthUnknown(text) : S.hands.length(text, sigmaText(sigma, this.unit)));
  }

  private showRuler(): void {
    this.view.setRuler(this.ends.map(({ point }) => point));
    this.pins.set("end", this.ends.map(({ point }, i) => ({ key: `end ${i}`, at: point, label: S.hands.ruler, kind: "end" })));
  }

  /** One sigma: of the scale, of the poses between the two images, and of the finger at both ends. */
  private length(from: Pick, to: Pick): { length: number; sigma: number | null } {
    const length = Math.hypot(...([0, 1, 2] as const).map((k) => to.point[k] - from.point[k]));
    if (this.state === null || this.state.scale === "none" || this.state.sigma === 0) return { length, sigma: null };
    const [one, other] = [from.sights[0]?.image, to.sights[0]?.image];
    const poses = one === undefined || other === undefined ? 0 : this.view.cameras.sigmaBetween(one, other) / Math.sqrt(3);
    const finger = FINGER_PX * this.view.eye.unitsPerPixel;
    return { length, sigma: Math.hypot(length * this.state.sigma, poses, finger, finger) };
  }

  private probe({ point, sights }: Pick): void {
    this.pins.set("end", [{ key: "probe", at: point, label: S.hands.probe, kind: "end" }]);
    const best = sights[0];
    if (best === undefined) {
      say(this.text, S.hands.nothing);
      return;
    }
    const pose = this.view.cameras.poses.get(best.image);
    const pixel = this.view.cameras.pixelAt(best.distance);
    const size = pixel === 0 ? "–" : sigmaText(pixel, this.unit);
    const what = S.hands.probeText(best.image, clock(pose?.time ?? 0), amount(best.distance, this.unit), size);
    say(this.text, `${what}, ${S.hands.seenBy(sights.length)}`);
  }

  private get unit(): string {
    return this.state === null || this.state.scale === "none" ? S.unit : "m";
  }
}

/** Two digits, in millimetres where that is fewer letters. */
function sigmaText(value: number, unit: string): string {
  if (unit !== "m" || value >= 1) return `${Number(value.toPrecision(2))} ${unit}`;
  return value >= 0.1 ? `${Number((100 * value).toPrecision(2))} cm` : `${Number((1000 * value).toPrecision(2))} mm`;
}
