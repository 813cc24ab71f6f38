// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import { decodeNow } from "../view/images";
import type { LastView, LiveImage, Measures, State, WayBack } from "../wire/records";
import { Delay } from "./delay";
import { byId, el, icon, say } from "./dom";
import { amount, clock, count, S } from "./strings";

const FOUND: WayBack = { type: "way_back", lost: false, known: false, turn: 0, distance: 0, sigma: 0 };
const POINT_PX = 3;
const LATE_SECONDS = 3;

/** Decodes pictures one after the other; while one is decoded only the newest of those that come is kept. */
class Decoder<T extends { jpeg: Uint8Array }> {
  private next: T | null = null;
  private busy = false;

  constructor(
    private readonly paint: (bitmap: ImageBitmap, of: T) => void,
    private readonly broken: () => void,
  ) {}

  show(image: T): void {
    this.next = image;
    if (!this.busy) void this.drain();
  }

  private async drain(): Promise<void> {
    this.busy = true;
    while (this.next !== null) {
      const image = this.next;
      this.next = null;
      try {
        const bitmap = await decodeNow(image.jpeg);
        this.paint(bitmap, image);
        bitmap.close();
      } catch {
        this.broken();
      }
    }
    this.busy = false;
  }
}

/** What the camera sees: small beside the map, or the whole screen with tie points, warnings and, once lost, the last
 *  good view as a ghost with the way back to it. */
export class Picture {
  /** Told when the small picture is tapped. */
  onOpen: () => void = () => undefined;
  tiePoints = true;
  private readonly small = byId("live");
  private readonly large = byId("picture");
  private readonly smallCanvas = el("canvas", "");
  private readonly canvas = el("canvas", "");
  private readonly ghost = el("canvas", "ghost");
  private readonly overlay = el("canvas", "overlay");
  private readonly caption = el("figcaption", "", S.live.none);
  private readonly title = el("p", "title", S.live.none);
  private readonly warnings = el("p", "warnings");
  private readonly smallWarnings = el("span", "warnings");
  private faults = "";
  private readonly way: HTMLElement;
  private readonly wayArrow = icon("arrow");
  private readonly wayText = el("span", "");
  private readonly images: Decoder<LiveImage>;
  private readonly views: Decoder<LastView>;
  private newest: LiveImage | null = null;
  private delay = new Delay();
  private lost = false;

  constructor(broken: () => void) {
    this.images = new Decoder((bitmap, image) => { this.paint(bitmap, image); }, broken);
    this.views = new Decoder((bitmap) => { draw(this.ghost, bitmap); }, broken);
    const frame = el("button", "frame", el("figure", "", this.smallCanvas, this.smallWarnings, this.caption));
    frame.type = "button";
    frame.title = S.live.open;
    frame.addEventListener("click", () => {
      this.onOpen();
    });
    this.small.append(frame);
    this.way = el("p", "way", this.wayArrow, this.wayText);
    this.large.setAttribute("aria-label", S.live.title);
    const layers = el("div", "layers", this.canvas, this.ghost, this.overlay);
    this.large.append(layers, el("div", "captions", this.title, this.warnings), el("p", "ghost-label", S.ghost), this.way);
    this.setWayBack(FOUND);
  }

  set isLarge(large: boolean) {
    if (this.newest !== null && large === this.large.hidden) {
      draw(large ? this.canvas : this.smallCanvas, large ? this.smallCanvas : this.canvas);
    }
    this.large.hidden = !large;
    this.small.hidden = large;
    this.redraw();
  }

  show(image: LiveImage): void {
    this.images.show(image);
  }

  setLastView(view: LastView): void {
    this.views.show(view);
  }

  setWayBack(way: WayBack): void {
    this.lost = way.lost;
    this.large.classList.toggle("lost", way.lost);
    this.wayArrow.style.rotate = `${way.turn}rad`;
    this.wayArrow.toggleAttribute("hidden", !way.known);
    say(this.wayText, way.known ? S.wayBack(amount(way.distance, "m"), amount(way.sigma, "m")) : S.wayUnknown);
  }

  /** Warns of what the pictures lack. */
  setMeasures({ measures }: Measures): void {
    const found = measures.flatMap(({ quantity, value, low, high }) => {
      if (quantity !== "blur" && quantity !== "brightness") return [];
      const advice = low !== null && value < low ? S.tooLow[quantity] : high !== null && value > high ? S.tooHigh[quantity] : undefined;
      return advice === undefined ? [] : [advice.text];
    });
    this.faults = found.join(" · ");
    this.warn();
  }

  setState(state: State): void {
    this.delay.setState(state, performance.now() / 1000);
    this.warn();
  }

  redraw(): void {
    this.mark(this.newest);
  }

  clear(): void {
    this.newest = null;
    this.delay = new Delay();
    this.faults = "";
    this.warn();
    this.setWayBack(FOUND);
    this.mark(null);
  }

  private paint(bitmap: ImageBitmap, image: LiveImage): void {
    this.newest = image;
    this.warn();
    this.small.classList.add("some");
    say(this.caption, `${S.live.caption(image.image)} · ${clock(image.time)}`);
    say(this.title, [S.live.caption(image.image), clock(image.time), S.live.tiePoints(count(image.tiePoints.length / 2))].join(" · "));
    if (this.large.hidden) {
      draw(this.smallCanvas, bitmap);
      return;
    }
    draw(this.canvas, bitmap);
    this.mark(image);
  }

  private warn(): void {
    const behind = this.delay.of(this.newest?.time ?? -Infinity, performance.now() / 1000);
    const late = this.newest === null ? 0 : behind;
    const said = [this.faults, late > LATE_SECONDS ? S.live.late(Math.round(late)) : ""].filter((part) => part !== "").join(" · ");
    say(this.warnings, said);
    say(this.smallWarnings, said);
  }

  private mark(image: LiveImage | null): void {
    const { overlay } = this;
    overlay.width = this.canvas.width;
    overlay.height = this.canvas.height;
    const context = overlay.getContext("2d");
    if (context === null || image === null || !this.tiePoints || this.lost) return;
    // A dark rim under a bright dot is seen on any ground.
    for (const [colour, radius] of [["#000", POINT_PX], ["#ffe14d", POINT_PX - 1.2]] as const) {
      context.fillStyle = colour;
      for (let i = 0; i < image.tiePoints.length; i += 2) {
        const x = ((image.tiePoints[i] ?? 0) / 65535) * overlay.width;
        const y = ((image.tiePoints[i + 1] ?? 0) / 65535) * overlay.height;
        context.fillRect(x - radius, y - radius, 2 * radius, 2 * radius);
      }
    }
  }
}

function draw(canvas: HTMLCanvasElement, from: ImageBitmap | HTMLCanvasElement): void {
  if (canvas.width !== from.width) canvas.width = from.width;
  if (canvas.height !== from.height) canvas.height = from.height;
  canvas.getContext("2d")?.drawImage(from, 0, 0);
}
