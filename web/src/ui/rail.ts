// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import type { Framing, View } from "../view/view";
import { button, byId, el, icon, mark, say } from "./dom";
import { recordedDive } from "./recorded";
import { count, S } from "./strings";

/** What fills the screen. */
export const STAGES = ["map", "scene", "picture"] as const;
export type Stage = (typeof STAGES)[number];
export const SHEETS = ["hand", "layers", "alerts", "menu"] as const;
export type Sheet = (typeof SHEETS)[number];

/** The buttons along the edge, the sheet they open, and the same by keyboard. */
export class Rail {
  /** Told when another stage is chosen. */
  onStage: (stage: Stage) => void = () => undefined;
  stage: Stage = "map";
  private readonly panel = byId("panel");
  private readonly body = el("div", "body");
  private readonly title = el("h2", "");
  private readonly stages: Record<Stage, HTMLButtonElement>;
  private readonly sheets: Record<Sheet, HTMLButtonElement>;
  private readonly follow: HTMLButtonElement;
  private readonly bubbles: Partial<Record<Sheet, HTMLElement>>;
  private readonly pages: { title: string; build: () => HTMLElement }[] = [];
  private readonly back: HTMLButtonElement;
  private open: Sheet | null = null;
  private framing: Framing = "all";

  constructor(
    private readonly view: View | null,
    private readonly build: Record<Sheet, () => HTMLElement>,
  ) {
    const stage = (name: Stage) => button(name, S.tools[name], () => { this.setStage(name); });
    const sheet = (name: Sheet) => button(name === "alerts" ? "bell" : name, S.tools[name], () => { this.toggle(name); });
    this.stages = { map: stage("map"), scene: stage("scene"), picture: stage("picture") };
    this.stages.picture.hidden = recordedDive !== null;
    this.sheets = { hand: sheet("hand"), layers: sheet("layers"), alerts: sheet("alerts"), menu: sheet("menu") };
    this.bubbles = { alerts: el("span", "bubble"), menu: el("span", "bubble") };
    for (const name of ["alerts", "menu"] as const) this.sheets[name].append(this.bubbles[name] ?? "");
    this.follow = button("follow", S.tools.follow, () => { this.view?.setFraming(this.framing === "follow" ? "all" : "follow"); });
    byId("tools").append(...Object.values(this.stages), this.follow, ...Object.values(this.sheets));
    byId("tools").setAttribute("aria-label", S.tools.menu);
    this.buildZoom();
    this.back = el("button", "dismiss", icon("back"));
    this.buildPanel();
    this.listenToKeys();
    if (view !== null) view.onFraming = (now) => { this.showFraming(now); };
    this.showFraming("all");
    this.setStage("map");
  }

  setStage(stage: Stage): void {
    if (stage === "picture" && recordedDive !== null) return;
    this.stage = stage;
    if (stage !== "picture") this.view?.setLook(stage);
    mark(this.stages, stage);
    document.body.dataset["stage"] = stage;
    this.onStage(stage);
    this.refresh("layers");
  }

  /** What asks to be looked at behind a button. */
  setBubble(sheet: Sheet, number: number): void {
    const bubble = this.bubbles[sheet];
    if (bubble !== undefined) say(bubble, number > 0 ? count(number) : "");
  }

  /** Builds the sheet anew if it is open at its first page. */
  refresh(sheet: Sheet): void {
    if (this.open === sheet && this.pages.length === 0) this.fill();
  }

  /** Leads deeper into the open sheet; the same title again is the same page, brought up to date. */
  push(title: string, build: () => HTMLElement): void {
    if (this.open === null) this.toggle("menu");
    if (this.pages.at(-1)?.title === title) this.pages.pop();
    this.pages.push({ title, build });
    this.fill();
  }

  /** Brings a page up to date if it is the one that is seen. */
  refreshPage(title: string): void {
    if (this.open !== null && this.pages.at(-1)?.title === title) this.fill();
  }

  close(): void {
    if (this.open !== null) this.toggle(this.open);
  }

  /** What is looked at. An answer that comes late finds with isAt whether it still is. */
  get place(): unknown {
    return this.pages.at(-1)?.build ?? this.open;
  }

  isAt(place: unknown): boolean {
    return this.open !== null && this.place === place;
  }

  closeAt(place: unknown): void {
    if (this.isAt(place)) this.close();
  }

  private toggle(sheet: Sheet): void {
    this.pages.length = 0;
    this.open = this.open === sheet ? null : sheet;
    this.panel.hidden = this.open === null;
    mark(this.sheets, this.open);
    if (this.open !== null) this.fill();
  }

  private fill(): void {
    if (this.open === null) return;
    const page = this.pages.at(-1);
    const { scrollTop } = this.panel;
    say(this.title, page?.title ?? S.tools[this.open]);
    this.back.hidden = page === undefined;
    this.body.replaceChildren((page?.build ?? this.build[this.open])());
    this.panel.scrollTop = scrollTop;
  }

  private showFraming(framing: Framing): void {
    this.framing = framing;
    this.follow.setAttribute("aria-pressed", String(framing === "follow"));
  }

  private buildZoom(): void {
    byId("zoom").append(
      button("top", S.tools.top, () => this.view?.lookDown(), "tool top"),
      button("all", S.tools.all, () => this.view?.setFraming("all")),
      button("closer", S.tools.closer, () => this.view?.eye.zoomBy(1.4)),
      button("farther", S.tools.farther, () => this.view?.eye.zoomBy(1 / 1.4)),
    );
  }

  private buildPanel(): void {
    const close = el("button", "dismiss", icon("cross"));
    close.type = this.back.type = "button";
    close.setAttribute("aria-label", S.close);
    this.back.setAttribute("aria-label", S.back);
    close.addEventListener("click", () => {
      this.close();
    });
    this.back.addEventListener("click", () => {
      this.pages.pop();
      this.fill();
    });
    this.panel.append(el("header", "", this.back, this.title, close), this.body);
  }

  private listenToKeys(): void {
    const keys: Partial<Record<string, () => void>> = {
      m: () => { this.setStage("map"); },
      "3": () => { this.setStage("scene"); },
      i: () => { this.setStage("picture"); },
      f: () => this.view?.setFraming("follow"),
      a: () => this.view?.setFraming("all"),
      t: () => this.view?.lookDown(),
      l: () => { this.toggle("layers"); },
      "+": () => this.view?.eye.zoomBy(1.4),
      "=": () => this.view?.eye.zoomBy(1.4),
      "-": () => this.view?.eye.zoomBy(1 / 1.4),
      Escape: () => { this.close(); },
    };
    addEventListener("keydown", (event) => {
      const typing = event.target instanceof HTMLInputElement || event.target instanceof HTMLTextAreaElement;
      if (!typing && !event.ctrlKey && !event.metaKey && !event.altKey) keys[event.key]?.();
    });
  }
}
