// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The sheets that are lists of switches and figures.
import { COVERAGE_COLOURS } from "../view/coverage";
import type { Counts, View } from "../view/view";
import type { State, Statistics } from "../wire/records";
import { el, toggle } from "./dom";
import type { Equipment } from "./equipment";
import type { Marks } from "./marks";
import type { Picture } from "./picture";
import type { Stage } from "./rail";
import { count, S } from "./strings";

/** changed: builds the sheet anew. */
export function layerSwitches(view: View | null, picture: Picture, marks: Marks, stage: Stage, changed: () => void): HTMLElement {
  const flip = (change: () => void) => () => {
    change();
    view?.applyLayers();
    picture.redraw();
    changed();
  };
  if (stage === "picture") {
    return el("div", "switches", toggle(S.layers.tiePoints, picture.tiePoints, flip(() => (picture.tiePoints = !picture.tiePoints))));
  }
  if (view === null) return el("p", "none", S.no3d);
  const layers = view.layers[view.eye.look];
  const simple = (name: "mosaic" | "tiePoints" | "cameras" | "coverage" | "plan") =>
    toggle(S.layers[name], layers[name], flip(() => (layers[name] = !layers[name])));
  const planes = (["quads", "points"] as const).map((style) =>
    toggle(S.layers[style], layers.planes === style, flip(() => (layers.planes = layers.planes === style ? "off" : style))),
  );
  const ofMarks = toggle(S.layers.marks, marks.isShown, flip(() => (marks.isShown = !marks.isShown)));
  const ofGround = [simple("mosaic"), simple("coverage"), legend(), simple("plan")];
  return el("div", "switches", ...ofGround, ...planes, simple("tiePoints"), simple("cameras"), ofMarks);
}

function legend(): HTMLElement {
  const items = COVERAGE_COLOURS.map(([red, green, blue], i) => {
    const swatch = el("i", i === 0 ? "swatch gap" : "swatch");
    swatch.style.setProperty("--shade", `rgb(${red} ${green} ${blue})`);
    return el("li", "", swatch, S.coverage[i] ?? "");
  });
  return el("ul", "legend", ...items);
}

export class System {
  ignored: () => number = () => 0;
  private statistics: Statistics | null = null;
  private state: State | null = null;

  constructor(
    private readonly view: View | null,
    private readonly equipment: Equipment,
  ) {}

  setStatistics(statistics: Statistics): void {
    this.statistics = statistics;
  }

  setState(state: State): void {
    this.state = state;
  }

  clear(): void {
    this.statistics = this.state = null;
  }

  sheet(): HTMLElement {
    return el(
      "div",
      "",
      this.equipment.list(),
      el("h3", "", S.system.map),
      this.counts(),
      el("h3", "", S.system.stages),
      this.stages(),
    );
  }

  private counts(): HTMLElement {
    const counts = this.view === null ? [] : (Object.entries(this.view.counts) as [keyof Counts, number][]);
    const rows: string[][] = counts.map(([name, number]) => [S.counts[name], count(number)]);
    if (this.state !== null) {
      const part = this.state.submap > 0 ? ` · ${S.submap(this.state.submap)}` : "";
      rows.unshift([S.system.input, this.state.input + part]);
    }
    return el("table", "", ...rows.map((cells) => row("td", cells)));
  }

  private stages(): HTMLElement {
    if (this.statistics === null) return el("p", "none", S.system.none);
    const rows = this.statistics.stages.map((stage) =>
      row("td", [
        stage.stage,
        stage.rateOut.toFixed(1),
        count(stage.depth),
        count(stage.dropped),
        stage.lastMs.toFixed(0),
        stage.p95Ms.toFixed(0),
      ]),
    );
    const table = el("table", "", row("th", S.system.heads), ...rows);
    return el("div", "", table, el("p", "none", this.ignored() > 0 ? S.system.ignored(this.ignored()) : ""));
  }
}

function row(tag: "th" | "td", cells: readonly string[]): HTMLElement {
  return el("tr", "", ...cells.map((text) => el(tag, "", text)));
}
