// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import type { LinkState } from "../link";
import type { Counts } from "../view/view";
import type { State } from "../wire/records";
import { byId, el, icon, say, type Icon } from "./dom";
import { count, S } from "./strings";

/** What the diver glances at: tracking, progress, scale. */
export class StatusCard {
  private readonly root = byId("status");
  private readonly badge = el("span", "badge");
  private readonly word = el("strong", "word");
  private readonly advice = el("span", "advice");
  private readonly progress = el("p", "progress");
  private readonly bar = el("div", "bar", el("i", ""));
  private readonly scale = el("span", "chip");
  private readonly input = el("span", "input");
  private shown = "";

  constructor() {
    const head = el("h1", "head", this.badge, el("span", "words", this.word, this.advice));
    this.root.append(head, this.progress, this.bar, el("p", "facts", this.scale, this.input));
    this.setMode("waiting", S.tracking.waiting, "", "wait");
  }

  show(state: State): void {
    if (state.finished) this.setMode("finished", S.finished, "", "flag");
    else {
      const icons = { waiting: "wait", initialising: "search", tracking: "check", lost: "warning" } as const;
      const advice = state.tracking === "tracking" ? "" : S.advice[state.tracking];
      this.setMode(state.tracking, S.tracking[state.tracking], advice, icons[state.tracking]);
    }
    say(this.progress, progressText(state));
    this.bar.hidden = state.total === 0;
    this.bar.style.setProperty("--done", `${state.total > 0 ? (100 * state.captured) / state.total : 0}%`);
    say(this.scale, scaleText(state));
    this.scale.dataset["kind"] = state.scale === "none" ? "warning" : "good";
    this.scale.title = state.scale === "none" ? S.unscaledLong : "";
    say(this.input, state.submap > 0 ? `${state.input} · ${S.submap(state.submap)}` : state.input);
  }

  private setMode(mode: string, word: string, advice: string, name: Icon): void {
    say(this.word, word);
    say(this.advice, advice);
    if (this.shown === mode) return;
    this.shown = mode;
    document.body.dataset["tracking"] = mode;
    this.badge.replaceChildren(icon(name));
  }
}

function progressText(state: State): string {
  const parts = [S.images(count(state.captured), state.total > 0 ? count(state.total) : null)];
  if (!state.finished && state.rate > 0) parts.push(S.rate(state.rate.toFixed(1)));
  if (state.lost > 0) parts.push(S.lostImages(count(state.lost)));
  if (state.dropped > 0) parts.push(S.droppedImages(count(state.dropped)));
  return parts.join(" · ");
}

function scaleText(state: State): string {
  if (state.scale === "none") return S.unscaled;
  const sigma = state.sigma > 0 ? ` ±${(100 * state.sigma).toFixed(state.sigma < 0.01 ? 1 : 0)} %` : "";
  return S.scaled[state.scale] + sigma;
}

/** Whether what is on the screen is now. */
export class LinkChip {
  private readonly root = byId("link");
  private readonly word = el("span", "");

  constructor() {
    this.root.append(el("i", "dot"), this.word);
  }

  show(state: LinkState): void {
    this.root.dataset["state"] = state;
    document.body.dataset["link"] = state;
    say(this.word, S.link[state]);
    this.root.title = state === "live" ? "" : S.linkLost;
  }
}

/** How much is on the map. */
export class CountStrip {
  private readonly numbers: Record<keyof Counts, HTMLElement>;

  constructor() {
    const root = byId("counts");
    const cell = (name: keyof Counts) => {
      const number = el("b", "", "0");
      root.append(el("div", "count", number, el("span", "", S.counts[name])));
      return number;
    };
    this.numbers = {
      cameras: cell("cameras"),
      tiePoints: cell("tiePoints"),
      planes: cell("planes"),
      mosaicTiles: cell("mosaicTiles"),
    };
  }

  show(counts: Counts): void {
    for (const name of ["cameras", "tiePoints", "planes", "mosaicTiles"] as const) {
      say(this.numbers[name], count(counts[name]));
    }
  }
}
