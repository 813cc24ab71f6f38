// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import type { Look } from "../view/eye";
import type { Framing, View } from "../view/view";
import type { Statistics } from "../wire/records";
import type { Alerts } from "./alerts";
import { button, byId, el, icon, say } from "./dom";
import type { Equipment } from "./equipment";
import { count, S } from "./strings";

type Sheet = "layers" | "alerts" | "system";

/** The buttons beside the map, the sheets they open, and the same by keyboard. */
export class Tools {
  private readonly panel = byId("panel");
  private readonly body = el("div", "body");
  private readonly title = el("h2", "");
  private readonly sheets: Record<Sheet, HTMLButtonElement>;
  private readonly looks: Record<Look, HTMLButtonElement>;
  private readonly framings: Record<"all" | "follow", HTMLButtonElement>;
  private readonly alertCount = el("span", "bubble");
  private readonly faultCount = el("span", "bubble");
  private open: Sheet | null = null;
  private statistics: Statistics | null = null;
  ignored: () => number = () => 0;

  constructor(
    private readonly view: View | null,
    private readonly alerts: Alerts,
    private readonly equipment: Equipment,
  ) {
    const look = (name: Look) => button(name, S.tools[name], () => {
      this.setLook(name);
    });
    const framing = (name: "all" | "follow") => button(name, S.tools[name], () => {
      view?.setFraming(name);
    });
    const sheet = (name: Sheet) => button(name === "alerts" ? "bell" : name, S.tools[name], () => {
      this.toggle(name);
    });
    this.looks = { scene: look("scene"), map: look("map") };
    this.framings = { all: framing("all"), follow: framing("follow") };
    this.sheets = { layers: sheet("layers"), alerts: sheet("alerts"), system: sheet("system") };
    this.sheets.alerts.append(this.alertCount);
    this.sheets.system.append(this.faultCount);
    const zoom = [
      button("closer", S.tools.closer, () => view?.eye.zoomBy(1.4)),
      button("farther", S.tools.farther, () => view?.eye.zoomBy(1 / 1.4)),
    ];
    for (const group of [Object.values(this.looks), Object.values(this.framings), zoom, Object.values(this.sheets)]) {
      byId("tools").append(el("div", "group", ...group));
    }
    this.buildPanel();
    this.listenToKeys();
    this.setLook("scene");
    this.showFraming("all");
    if (view !== null) view.onFraming = (now) => { this.showFraming(now); };
  }

  setLook(look: Look): void {
    this.view?.setLook(look);
    mark(this.looks, look);
    document.body.dataset["look"] = look;
    this.refresh("layers");
  }

  showStatistics(statistics: Statistics): void {
    this.statistics = statistics;
    this.refresh("system");
  }

  showAlerts(): void {
    say(this.alertCount, this.alerts.count > 0 ? count(this.alerts.count) : "");
    this.refresh("alerts");
  }

  showEquipment(): void {
    const { faults } = this.equipment;
    say(this.faultCount, faults > 0 ? count(faults) : "");
    this.refresh("system");
  }

  private showFraming(framing: Framing): void {
    mark(this.framings, framing);
  }

  private buildPanel(): void {
    const close = el("button", "dismiss", icon("cross"));
    close.type = "button";
    close.setAttribute("aria-label", S.close);
    close.addEventListener("click", () => {
      if (this.open !== null) this.toggle(this.open);
    });
    this.panel.append(el("header", "", this.title, close), this.body);
  }

  private toggle(sheet: Sheet): void {
    this.open = this.open === sheet ? null : sheet;
    this.panel.hidden = this.open === null;
    mark(this.sheets, this.open);
    this.refresh(sheet);
  }

  private refresh(sheet: Sheet): void {
    if (this.open !== sheet) return;
    say(this.title, S.tools[sheet]);
    const build = { layers: () => this.layerSwitches(), alerts: () => this.alerts.list(), system: () => this.system() };
    this.body.replaceChildren(build[sheet]());
  }

  private layerSwitches(): HTMLElement {
    const { view } = this;
    if (view === null) return el("p", "none", S.no3d);
    const layers = view.layers[view.eye.look];
    const apply = (change: () => void) => () => {
      change();
      view.applyLayers();
      this.refresh("layers");
    };
    return el(
      "div",
      "switches",
      toggle(S.layers.mosaic, layers.mosaic, apply(() => (layers.mosaic = !layers.mosaic))),
      ...(["quads", "points"] as const).map((style) =>
        toggle(S.layers[style], layers.planes === style, apply(() => (layers.planes = layers.planes === style ? "off" : style))),
      ),
      toggle(S.layers.tiePoints, layers.tiePoints, apply(() => (layers.tiePoints = !layers.tiePoints))),
      toggle(S.layers.cameras, layers.cameras, apply(() => (layers.cameras = !layers.cameras))),
    );
  }

  private system(): HTMLElement {
    return el("div", "", this.equipment.list(), el("h3", "", S.system.stages), this.stages());
  }

  private stages(): HTMLElement {
    if (this.statistics === null) return el("p", "none", S.system.none);
    const row = (tag: "th" | "td", cells: readonly string[]) => el("tr", "", ...cells.map((text) => el(tag, "", text)));
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

  private listenToKeys(): void {
    const keys: Partial<Record<string, () => void>> = {
      m: () => {
        this.setLook(this.view?.eye.look === "map" ? "scene" : "map");
      },
      f: () => this.view?.setFraming("follow"),
      a: () => this.view?.setFraming("all"),
      l: () => {
        this.toggle("layers");
      },
      "+": () => this.view?.eye.zoomBy(1.4),
      "=": () => this.view?.eye.zoomBy(1.4),
      "-": () => this.view?.eye.zoomBy(1 / 1.4),
      Escape: () => {
        if (this.open !== null) this.toggle(this.open);
      },
    };
    addEventListener("keydown", (event) => {
      if (!event.ctrlKey && !event.metaKey && !event.altKey) keys[event.key]?.();
    });
  }
}

function mark(buttons: Partial<Record<string, HTMLButtonElement>>, pressed: string | null): void {
  for (const [name, one] of Object.entries(buttons)) one?.setAttribute("aria-pressed", String(name === pressed));
}

function toggle(label: string, on: boolean, flip: () => void): HTMLButtonElement {
  const element = el("button", "switch", el("span", "", label), el("i", "knob"));
  element.type = "button";
  element.setAttribute("role", "switch");
  element.setAttribute("aria-checked", String(on));
  element.addEventListener("click", flip);
  return element;
}
