// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import type { Check, Finding } from "../wire/records";
import { el, icon, type Icon } from "./dom";
import { S } from "./strings";

const LEVELS = {
  bad: { order: 0, level: "bad", icon: "warning" },
  doubtful: { order: 1, level: "warning", icon: "warning" },
  good: { order: 2, level: "good", icon: "check" },
  absent: { order: 3, level: "note", icon: "info" },
} as const satisfies Record<Finding["verdict"], { order: number; level: string; icon: Icon }>;

/** What the device says of its own equipment, the worst first. */
export class Equipment {
  private findings: Finding[] = [];

  show(check: Check): void {
    this.findings = [...check.findings].sort((one, other) => LEVELS[one.verdict].order - LEVELS[other.verdict].order);
  }

  /** Items that ask for something to be done. */
  get faults(): number {
    return this.findings.filter(({ verdict }) => verdict === "bad" || verdict === "doubtful").length;
  }

  list(): HTMLElement {
    if (this.findings.length === 0) return el("p", "none", S.equipment.none);
    return el("ol", "alert-list", ...this.findings.map((finding) => el("li", "", card(finding))));
  }

  clear(): void {
    this.findings = [];
  }
}

function card({ verdict, item, found, remedy }: Finding): HTMLElement {
  const shown = el("article", "alert", icon(LEVELS[verdict].icon));
  const lines = [el("p", "message", `${item}: ${found}`)];
  if (remedy !== "") lines.push(el("p", "remedy", remedy));
  shown.append(el("div", "text", ...lines));
  shown.dataset["level"] = LEVELS[verdict].level;
  return shown;
}
