// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import type { Alert } from "../wire/records";
import { byId, el, icon, type Icon } from "./dom";
import { clock, S } from "./strings";

type Level = "bad" | "warning" | "good" | "note";

/** Kinds not named here are warnings. */
const LEVELS: Partial<Record<string, Level>> = {
  tracking_lost: "bad",
  camera_lost: "bad",
  storage: "bad",
  tracking_recovered: "good",
  camera_back: "good",
  submap_joined: "good",
  submap_started: "note",
  mosaic_restarted: "note",
  not_planar: "note",
};
const ICONS: Record<Level, Icon> = { bad: "warning", warning: "warning", good: "check", note: "info" };
const SHOWN_SECONDS: Record<Level, number> = { bad: 60, warning: 20, good: 8, note: 8 };
const SHOWN_AT_ONCE = 2;

/** New alerts appear for a while; all stay in the list. */
export class Alerts {
  private readonly stack = byId("alerts");
  private all = new Map<number, Alert>();

  get count(): number {
    return this.all.size;
  }

  /** What is not news, sent to a viewer that came late, goes to the list without a cry. */
  add(alert: Alert, isNews: boolean): void {
    const known = this.all.has(alert.id);
    this.all.set(alert.id, alert);
    if (!known && isNews) this.cry(alert);
  }

  clear(): void {
    this.all = new Map();
    this.stack.replaceChildren();
  }

  list(): HTMLElement {
    const newestFirst = [...this.all.values()].sort((one, other) => other.id - one.id).slice(0, 200);
    if (newestFirst.length === 0) return el("p", "none", S.alerts.none);
    return el("ol", "alert-list", ...newestFirst.map((alert) => el("li", "", card(alert))));
  }

  private cry(alert: Alert): void {
    const shown = card(alert);
    const close = el("button", "dismiss", icon("cross"));
    close.type = "button";
    close.setAttribute("aria-label", S.alerts.dismiss);
    close.addEventListener("click", () => {
      shown.remove();
    });
    shown.append(close);
    this.stack.prepend(shown);
    while (this.stack.children.length > SHOWN_AT_ONCE) this.stack.lastElementChild?.remove();
    setTimeout(() => {
      shown.remove();
    }, 1000 * SHOWN_SECONDS[levelOf(alert)]);
  }
}

function levelOf(alert: Alert): Level {
  return LEVELS[alert.kind] ?? "warning";
}

function card(alert: Alert): HTMLElement {
  const when = clock(alert.time) + (alert.image === null ? "" : ` · ${S.alerts.image(alert.image)}`);
  const text = el("div", "text", el("p", "message", alert.message), el("p", "remedy", alert.remedy), el("p", "when", when));
  const shown = el("article", "alert", icon(ICONS[levelOf(alert)]), text);
  shown.dataset["level"] = levelOf(alert);
  return shown;
}
