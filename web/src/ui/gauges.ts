// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What the diver glances at: is it recording, am I tracking, how high, how fast, where to.
import type { LinkState } from "../link";
import type { Measure, Measures, Quantity, Recording, State } from "../wire/records";
import { byId, el, icon, say, type Icon } from "./dom";
import { recordedDive } from "./recorded";
import { amount, clock, count, S, share } from "./strings";

export type Level = "good" | "note" | "warning" | "bad" | "plain";

/** A name, a value and what to do about it. */
class Gauge {
  readonly root: HTMLElement;
  private readonly number = el("span", "");
  private readonly unit = el("small", "");
  private readonly value = el("strong", "value", this.number, this.unit);
  private readonly advice = el("span", "advice");
  private readonly badge = el("span", "badge");
  private shown = "";

  constructor(name: string, label: string) {
    this.root = el("div", `gauge ${name}`, el("span", "label", label), this.value, this.advice, this.badge);
    this.root.setAttribute("role", "group");
    this.root.setAttribute("aria-label", label);
  }

  show(value: string, advice: string, level: Level, picture: Icon | null = null): void {
    const [, number, unit] = /^([\d.]+) (\S+)$/.exec(value) ?? [];
    say(this.number, number ?? value);
    say(this.unit, unit === undefined ? "" : ` ${unit}`);
    say(this.advice, advice);
    this.root.dataset["level"] = level;
    const name = picture ?? "";
    if (this.shown === name) return;
    this.shown = name;
    this.badge.replaceChildren(...(picture === null ? [] : [icon(picture)]));
  }

  set hidden(hidden: boolean) {
    this.root.hidden = hidden;
  }
}

const TRACKING_ICONS = { waiting: "wait", initialising: "search", tracking: "check", lost: "warning" } as const;
const TRACKING_LEVELS = { waiting: "plain", initialising: "note", tracking: "good", lost: "bad" } as const;
/** Shown once they are known; the others always. */
const ONLY_IF_KNOWN: readonly Quantity[] = ["depth", "heading", "battery"];
/** For images to be saved. */
const ROOM = ["free_space", "recording_left"] as const;

export class Gauges {
  private readonly recording = new Gauge("recording", S.gauges.recording);
  private readonly tracking = new Gauge("tracking", S.gauges.tracking);
  private readonly clock = new Gauge("clock", S.gauges.clock);
  private readonly gauges: Partial<Record<Quantity, Gauge>>;
  private state: State | null = null;
  private dive: Recording | null = null;
  private measures = new Map<Quantity, Measure>();
  private link: LinkState = "connecting";

  constructor() {
    const gauge = (name: Quantity) => new Gauge(name, S.quantities[name]);
    this.gauges = {
      altitude: gauge("altitude"),
      speed: gauge("speed"),
      overlap: gauge("overlap"),
      depth: gauge("depth"),
      heading: gauge("heading"),
      battery: gauge("battery"),
    };
    byId("gauges").append(...[this.recording, this.tracking, ...Object.values(this.gauges), this.clock].map(({ root }) => root));
    this.refresh();
    setInterval(() => {
      this.showClock();
    }, 1000);
  }

  setState(state: State): void {
    this.state = state;
    this.refresh();
  }

  setRecording(recording: Recording): void {
    this.dive = recording;
    this.refresh();
  }

  setMeasures(measures: Measures): void {
    this.measures = new Map(measures.measures.map((measure) => [measure.quantity, measure]));
    this.refresh();
  }

  setLink(link: LinkState): void {
    this.link = link;
    document.body.dataset["link"] = link;
    this.refresh();
  }

  clear(): void {
    this.state = this.dive = null;
    this.measures = new Map();
    this.refresh();
  }

  private refresh(): void {
    this.showRecording();
    this.showTracking();
    this.showClock();
    for (const [name, gauge] of Object.entries(this.gauges) as [Quantity, Gauge][]) this.showMeasure(name, gauge);
  }

  private showRecording(): void {
    if (this.link !== "live") {
      this.recording.show(S.link[this.link], S.linkLost, "warning", "link");
      return;
    }
    const { dive, state } = this;
    if (dive === null) {
      this.recording.show(state === null ? "–" : count(state.captured), state === null ? "" : S.images, "plain", "picture");
      return;
    }
    const levels = { waiting: "note", recording: "good", paused: "bad", ended: "plain" } as const;
    const icons = { waiting: "wait", recording: "record", paused: "warning", ended: "flag" } as const;
    const isShort = dive.phase === "recording" && ROOM.some((name) => isLow(this.measures.get(name)));
    const [level, picture] = isShort ? (["warning", "warning"] as const) : [levels[dive.phase], icons[dive.phase]];
    this.recording.show(S.phases[dive.phase], this.savedText(dive, state), level, picture);
  }

  /** What matters most first: the rest may find no place. */
  private savedText(dive: Recording, state: State | null): string {
    const [space, left] = ROOM.map((name) => this.measures.get(name)?.value);
    const room = space === undefined ? [] : [`${(space / 1e9).toFixed(space < 1e10 ? 1 : 0)} GB`];
    if (left !== undefined && left < 48 * 3600) room.push(clock(left));
    const lost = (state?.lost ?? 0) + (state?.dropped ?? 0);
    const parts = [room.length > 0 ? S.left(room.join(", ")) : "", lost > 0 ? S.missing(count(lost)) : "", S.saved(count(dive.saved))];
    return parts.filter((part) => part !== "").join(" · ");
  }

  private showTracking(): void {
    const { state } = this;
    if (state === null) {
      this.tracking.show(S.tracking.waiting, "", "plain", "wait");
      return;
    }
    if (recordedDive !== null && !state.finished) {
      this.tracking.show(S.recorded.reads, "", "note", "wait");
      return;
    }
    document.body.dataset["tracking"] = state.finished ? "finished" : state.tracking;
    if (state.finished && state.oriented === 0) {
      this.tracking.show(S.unmapped, state.captured === 0 ? S.advice.waiting : S.seeAlerts, "warning", "warning");
    } else if (state.finished) {
      this.tracking.show(S.finished, scaleText(state), state.scale === "none" ? "warning" : "plain", "flag");
    } else {
      const advice = state.tracking === "tracking" ? scaleText(state) : S.advice[state.tracking];
      const level = state.tracking === "tracking" && state.scale === "none" ? "warning" : TRACKING_LEVELS[state.tracking];
      this.tracking.show(S.tracking[state.tracking], advice, this.ofNow(level), TRACKING_ICONS[state.tracking]);
    }
  }

  private showMeasure(name: Quantity, gauge: Gauge): void {
    const measure = this.measures.get(name);
    gauge.hidden = measure === undefined && ONLY_IF_KNOWN.includes(name);
    if (measure === undefined) {
      gauge.show("–", "", "plain");
      return;
    }
    const low = isLow(measure);
    const high = measure.high !== null && measure.value > measure.high;
    const advice = low ? S.tooLow[name] : high ? S.tooHigh[name] : undefined;
    const known = measure.low !== null || measure.high !== null;
    const level = low || high ? "warning" : known ? "good" : "plain";
    gauge.show(this.text(measure), advice?.text ?? "", this.ofNow(level), advice?.icon ?? null);
  }

  /** What was once known without a link is neither good nor bad. */
  private ofNow(level: Level): Level {
    return this.link === "live" ? level : "plain";
  }

  private text({ quantity, value }: Measure): string {
    const unit = this.state === null || this.state.scale === "none" ? S.unit : "m";
    switch (quantity) {
      case "altitude":
        return amount(value, unit);
      case "depth":
        return amount(value, "m");
      case "speed":
        return amount(value, `${unit}/s`);
      case "heading":
        return `${String(Math.round(((value * 180) / Math.PI + 360) % 360)).padStart(3, "0")}°`;
      case "overlap":
      case "battery":
        return share(value);
      default:
        return value.toPrecision(3);
    }
  }

  /** The time of day where the device knows it, else how long the dive has lasted. */
  private showClock(): void {
    const utc = this.measures.get("utc")?.value;
    const { state, dive } = this;
    const dived = state === null ? "" : clock(Math.max(0, state.time - (dive?.began ?? 0)));
    if (utc === undefined) this.clock.show(dived === "" ? "–" : dived, dived === "" ? "" : S.dived, "plain");
    else this.clock.show(new Date(1000 * utc).toTimeString().slice(0, 5), dived, "plain");
  }
}

function isLow(measure: Measure | undefined): boolean {
  return measure !== undefined && measure.low !== null && measure.value < measure.low;
}

function scaleText(state: State): string {
  if (state.scale === "none") return S.unscaled;
  const sigma = state.sigma > 0 ? ` ±${(100 * state.sigma).toFixed(state.sigma < 0.001 ? 2 : state.sigma < 0.01 ? 1 : 0)} %` : "";
  return S.scaled[state.scale] + sigma;
}
