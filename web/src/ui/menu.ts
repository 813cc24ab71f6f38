// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import type { Api } from "../api";
import type { View } from "../view/view";
import type { Recording } from "../wire/records";
import type { Alerts } from "./alerts";
import type { Control } from "./control";
import type { Dives } from "./dives";
import { codePage } from "./code";
import { button, el, icon, mark, toggle } from "./dom";
import type { Hands } from "./hands";
import type { Marks } from "./marks";
import type { Rail } from "./rail";
import { recordedDive } from "./recorded";
import type { System } from "./sheets";
import { S } from "./strings";
import { THEMES, type Themes } from "./theme";

interface Parts {
  rail: Rail;
  themes: Themes;
  alerts: Alerts;
  system: System;
  api: Api;
  control: Control;
  dives: Dives;
}

/** All that is not needed at a glance. */
export class Menu {
  /** There is a dive to be controlled, and others to be looked at. */
  private hasDives = false;

  constructor(private readonly parts: Parts) {}

  setRecording(recording: Recording): void {
    this.hasDives = true;
    this.parts.control.setRecording(recording);
  }

  clear(): void {
    this.hasDives = false;
    this.parts.control.clear();
  }

  sheet(): HTMLElement {
    const { rail, control, dives, system, api } = this.parts;
    const ofDives = [
      button("dive", S.menu.dive, () => { rail.push(S.menu.dive, () => control.page()); }, "wide"),
      button("dives", S.menu.dives, async () => dives.open(), "wide"),
      button("code", S.control.showCode, async () => {
        const { place } = rail;
        const page = await codePage(api);
        if (rail.isAt(place)) rail.push(S.control.showCode, () => page);
      }, "wide"),
    ];
    const items: HTMLElement[] = [
      ...(this.hasDives ? ofDives : []),
      button("system", S.menu.system, () => { rail.push(S.menu.system, () => system.sheet()); }, "wide"),
      button("sun", S.menu.look, () => { this.openLook(); }, "wide"),
    ];
    if (recordedDive !== null) {
      const back = el("a", "wide", icon("back"), el("span", "label", S.recorded.live));
      back.href = location.pathname;
      items.unshift(back);
    }
    return el("div", "form", ...items);
  }

  private openLook(): void {
    const { rail, themes, alerts } = this.parts;
    rail.push(S.menu.look, () => {
      const choice = Object.fromEntries(
        THEMES.map((theme) => [theme, button("sun", S.themes[theme], () => {
          themes.choose(theme);
          rail.refreshPage(S.menu.look);
        }, "wide")]),
      );
      mark(choice, themes.current);
      const sound = toggle(S.sound, alerts.sounds, () => {
        alerts.sounds = !alerts.sounds;
        rail.refreshPage(S.menu.look);
      });
      return el("div", "form", ...Object.values(choice), sound);
    });
  }
}

/** What a tap can be made to do, and what can be done at once. */
export function handSheet(hands: Hands | null, marks: Marks, view: View | null, close: () => void): HTMLElement {
  if (hands === null || view === null) return el("p", "none", S.no3d);
  const hand = (name: "ruler" | "mark" | "probe", picture: "ruler" | "pin" | "question") =>
    button(picture, S.hands[name], () => {
      close();
      hands.take(name);
    }, "wide");
  const here = button("pin", S.hands.markHere, () => {
    const vehicle = view.cameras.newest;
    if (vehicle === null) return;
    marks.begin(view.below(vehicle), vehicle.image);
  }, "wide");
  const shot = button("screenshot", S.hands.screenshot, () => {
    close();
    void view.screenshot().then(saveScreenshot);
  }, "wide");
  const marking = marks.canBeMade ? [here, hand("mark", "pin")] : [];
  return el("div", "form", hand("ruler", "ruler"), ...marking, hand("probe", "question"), shot);
}

function saveScreenshot(png: Blob | null): void {
  if (png === null) return;
  const link = el("a", "");
  link.href = URL.createObjectURL(png);
  link.download = `nadir-${new Date().toISOString().slice(0, 19).replaceAll(":", "")}.png`;
  link.click();
  setTimeout(() => { URL.revokeObjectURL(link.href); }, 10_000);
}
