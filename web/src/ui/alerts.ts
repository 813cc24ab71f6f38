// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import type { Alert, State } from "../wire/records";
import { byId, el, icon, say, type Icon } from "./dom";
import { recall, remember } from "./memory";
import { clock, S } from "./strings";

export type AlertLevel = "bad" | "warning" | "good" | "note";

/** Kinds not named here are warnings. */
const LEVELS: Partial<Record<string, AlertLevel>> = {
  tracking_lost: "bad",
  camera_lost: "bad",
  storage: "bad",
  tracking_recovered: "good",
  camera_back: "good",
  storage_back: "good",
  submap_joined: "good",
  submap_started: "note",
  mosaic_restarted: "note",
  not_planar: "note",
};
/** What an alert ends: it folds away those that are over. */
const RESOLVES: Partial<Record<string, readonly string[]>> = {
  tracking_recovered: ["tracking_lost"],
  submap_started: ["tracking_lost"],
  submap_joined: ["tracking_lost", "submap_started"],
  camera_back: ["camera_lost"],
  storage_back: ["storage"],
};
const ICONS: Record<AlertLevel, Icon> = { bad: "stop", warning: "warning", good: "check", note: "info" };
/** A bad one stays until it is acknowledged or over. */
const SHOWN_SECONDS: Record<AlertLevel, number> = { bad: Infinity, warning: 30, good: 8, note: 8 };
/** Tones in Hz, each a sixth of a second, and the same as vibration. */
const CRIES: Record<AlertLevel, readonly number[]> = { bad: [880, 660, 880, 660], warning: [660, 660], good: [523, 784], note: [] };
const TONE_SECONDS = 1 / 6;
const LATEST_CRY_MS = 2000;

/** Loud: cries and stands across the screen, the gravest and newest one in full. Quiet: without the cry. All stay in the list. */
export type Manner = "loud" | "quiet" | "listed";

export class Alerts {
  /** Told when what is shown or listed has changed. */
  onChange: () => void = () => undefined;
  private readonly stack = byId("alerts");
  private all = new Map<number, Alert>();
  private open: Alert[] = [];
  private audio: AudioContext | null = null;
  private loud = recall("sound") !== "off";
  private wasTouched = false;

  constructor() {
    // A browser lets a page sound only once somebody has touched it.
    for (const hand of ["pointerup", "keydown"]) {
      addEventListener(hand, () => {
        this.wasTouched = true;
        void this.wakeAudio();
      });
    }
  }

  get count(): number {
    return this.all.size;
  }

  /** Alerts neither acknowledged nor over. */
  get openCount(): number {
    return this.open.length;
  }

  get sounds(): boolean {
    return this.loud;
  }

  set sounds(loud: boolean) {
    this.loud = loud;
    remember("sound", loud ? null : "off");
    if (loud) this.cry("good");
  }

  /** One that comes again, as the line for alerts or a link that broke bring it, says nothing new. */
  add(alert: Alert, manner: Manner): void {
    if (this.all.has(alert.id)) return;
    this.all.set(alert.id, alert);
    this.resolve(RESOLVES[alert.kind] ?? []);
    const isShown = manner !== "listed";
    if (isShown) this.open = [...this.open.filter(({ kind }) => kind !== alert.kind), alert];
    this.refresh();
    if (!isShown) return;
    const level = levelOf(alert);
    if (SHOWN_SECONDS[level] < Infinity) {
      setTimeout(() => {
        this.fold(alert.id);
      }, 1000 * SHOWN_SECONDS[level]);
    }
    if (manner === "loud") this.cry(level);
  }

  /** Who was lost when the dive ended is lost no more. */
  setState(state: State): void {
    if (!state.finished || !this.open.some(({ kind }) => kind === "tracking_lost")) return;
    this.resolve(["tracking_lost"]);
    this.refresh();
  }

  clear(): void {
    this.all = new Map();
    this.open = [];
    this.refresh();
  }

  list(): HTMLElement {
    const newestFirst = [...this.all.values()].sort((one, other) => other.id - one.id).slice(0, 200);
    if (newestFirst.length === 0) return el("p", "none", S.alerts.none);
    return el("ol", "alert-list", ...newestFirst.map((alert) => el("li", "", card(alert))));
  }

  private resolve(over: readonly string[]): void {
    this.open = this.open.filter(({ kind }) => !over.includes(kind));
  }

  private fold(id: number): void {
    const before = this.open.length;
    this.open = this.open.filter((alert) => alert.id !== id);
    if (this.open.length !== before) this.refresh();
  }

  private refresh(): void {
    const order: readonly AlertLevel[] = ["note", "good", "warning", "bad"];
    const gravest = [...this.open].sort((one, other) => order.indexOf(levelOf(other)) - order.indexOf(levelOf(one)) || other.id - one.id)[0];
    const shownId = gravest === undefined ? "" : String(gravest.id);
    if (this.stack.dataset["shown"] !== shownId) {
      this.stack.dataset["shown"] = shownId;
      this.stack.replaceChildren(...(gravest === undefined ? [] : [this.banner(gravest)]));
    }
    const more = this.stack.querySelector(".more");
    if (more instanceof HTMLElement) say(more, this.open.length > 1 ? S.alerts.more(this.open.length - 1) : "");
    this.onChange();
  }

  private banner(alert: Alert): HTMLElement {
    const shown = card(alert);
    const seen = el("button", "seen", icon("check"), el("span", "label", S.alerts.acknowledge));
    seen.type = "button";
    seen.addEventListener("click", () => {
      this.fold(alert.id);
    });
    shown.append(el("span", "more", ""), seen);
    return shown;
  }

  private cry(level: AlertLevel): void {
    const tones = CRIES[level];
    if (!this.loud || tones.length === 0) return;
    const pulse = 1000 * TONE_SECONDS;
    // Not every browser can.
    if (this.wasTouched && "vibrate" in navigator) navigator.vibrate(tones.flatMap(() => [pulse, pulse / 3]));
    void this.sound(tones);
  }

  private async sound(tones: readonly number[]): Promise<void> {
    const asked = performance.now();
    const audio = await this.wakeAudio();
    // One that may sound only much later is not news any more.
    if (audio?.state !== "running" || performance.now() - asked > LATEST_CRY_MS) return;
    const loudness = audio.createGain();
    loudness.gain.value = 0.4;
    loudness.connect(audio.destination);
    tones.forEach((tone, i) => {
      const sound = audio.createOscillator();
      sound.type = "square";
      sound.frequency.value = tone;
      sound.connect(loudness);
      sound.start(audio.currentTime + i * 1.2 * TONE_SECONDS);
      sound.stop(audio.currentTime + (1.2 * i + 1) * TONE_SECONDS);
    });
  }

  private async wakeAudio(): Promise<AudioContext | null> {
    if (!this.wasTouched) return null;
    this.audio ??= new AudioContext();
    if (this.audio.state === "suspended") await this.audio.resume().catch(() => undefined);
    return this.audio;
  }
}

export function levelOf(alert: Alert): AlertLevel {
  return LEVELS[alert.kind] ?? "warning";
}

function card(alert: Alert): HTMLElement {
  const when = clock(alert.time) + (alert.image === null ? "" : ` · ${S.alerts.image(alert.image)}`);
  const text = el("div", "text", el("p", "message", alert.message), el("p", "remedy", alert.remedy), el("p", "when", when));
  const shown = el("article", "alert", icon(ICONS[levelOf(alert)]), text);
  shown.dataset["level"] = levelOf(alert);
  return shown;
}
