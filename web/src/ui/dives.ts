// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import type { Api, DiveEntry } from "../api";
import { refusal } from "./control";
import { button, el, icon, plain, say } from "./dom";
import type { Rail } from "./rail";
import { amount, count, S } from "./strings";

/** The dives on the device: look at one again, take its files away, delete it. */
export class Dives {
  constructor(
    private readonly api: Api,
    private readonly rail: Rail,
  ) {}

  async open(): Promise<void> {
    const { place } = this.rail;
    const answer = await this.api.dives();
    if (!this.rail.isAt(place)) return;
    if (!answer.ok) {
      this.rail.push(S.menu.dives, () => el("p", "none", refusal(answer)));
      return;
    }
    const dives = answer.value;
    const entry = (dive: DiveEntry) =>
      button("dives", dive.name, async () => this.openDive(dive), "wide entry");
    this.rail.push(S.menu.dives, () => {
      if (dives.length === 0) return el("p", "none", S.dives.none);
      return el("ul", "dives", ...dives.map((dive) => {
        const item = entry(dive);
        item.append(el("span", "facts", facts(dive)));
        return el("li", "", item);
      }));
    });
  }

  private async openDive(dive: DiveEntry): Promise<void> {
    const { place } = this.rail;
    const answer = await this.api.contents(dive.id);
    if (!this.rail.isAt(place)) return;
    const { products, folders } = answer.ok ? answer.value : { products: [], folders: [] };
    const view = el("a", "wide", icon("map"), el("span", "label", S.dives.view));
    view.href = `?dive=${encodeURIComponent(dive.id)}`;
    this.rail.push(dive.name, () => {
      const parts: HTMLElement[] = [el("p", "", facts(dive))];
      if (!dive.recording) parts.push(view);
      const all = this.link(this.api.archiveAddress(dive.id), `${dive.name}.tar`, S.dives.archive, dive.bytes);
      const links = products.map((file) => this.link(this.api.productAddress(dive.id, file.id), file.name, file.name, file.bytes));
      const inArchive = folders.map((folder) => el("p", "none", S.dives.folder(folder.name, count(folder.files), size(folder.bytes))));
      parts.push(el("h3", "", S.dives.files), el("ul", "files", ...[all, ...links].map((link) => el("li", "", link))), ...inArchive);
      if (!answer.ok) parts.push(el("p", "outcome", refusal(answer)));
      if (!dive.recording) parts.push(button("trash", S.dives.remove, () => { this.confirm(dive); }, "wide danger"));
      return el("div", "form", ...parts);
    });
  }

  private link(address: string, name: string, label: string, bytes: number): HTMLElement {
    const link = el("a", "wide", icon("save"), el("span", "label", label), el("span", "facts", size(bytes)));
    link.href = address;
    link.download = plain(name.split("/").at(-1) ?? name);
    return link;
  }

  private confirm(dive: DiveEntry): void {
    const outcome = el("p", "outcome", "");
    outcome.setAttribute("role", "status");
    const remove = button("trash", S.dives.removeNow, async () => this.remove(dive, outcome), "wide danger");
    this.rail.push(S.dives.remove, () => el("div", "form", el("p", "", S.dives.sure(dive.name)), remove, outcome));
  }

  private async remove(dive: DiveEntry, outcome: HTMLElement): Promise<void> {
    const { place } = this.rail;
    say(outcome, S.control.asking);
    const answer = await this.api.removeDive(dive.id);
    if (!this.rail.isAt(place)) return;
    if (answer.ok) await this.open();
    else say(outcome, refusal(answer));
  }
}

function facts(dive: DiveEntry): string {
  const parts = [];
  if (dive.begun !== null) parts.push(new Date(dive.begun).toLocaleString("en-GB", { dateStyle: "medium", timeStyle: "short" }));
  if (dive.recording) parts.push(S.phases.recording);
  else if (!dive.complete) parts.push(S.dives.cutOff);
  if (dive.images !== null) parts.push(S.dives.images(count(dive.images)));
  if (dive.area_m2 !== null && dive.area_m2 > 0) parts.push(amount(dive.area_m2, "m²"));
  parts.push(size(dive.bytes));
  return parts.join(" · ");
}

function size(bytes: number): string {
  const [value, unit] = bytes >= 1e9 ? [bytes / 1e9, "GB"] : bytes >= 1e6 ? [bytes / 1e6, "MB"] : [bytes / 1e3, "kB"];
  return amount(value, unit);
}
