// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import type { Guidance, Pose, State } from "../wire/records";
import { byId, el, icon, say } from "./dom";
import { amount, S, share } from "./strings";
import { wayTo } from "./way";

/** Where to swim next: how much is covered, which way to the nearest gap, how far off the lane. */
export class Guide {
  private readonly root = byId("guide");
  private readonly covered = el("strong", "covered");
  private readonly arrow = icon("arrow");
  private readonly gap = el("span", "gap");
  private readonly lane = el("span", "lane");
  private guidance: Guidance | null = null;
  private vehicle: Pose | null = null;
  private unit = "m";

  constructor() {
    this.root.setAttribute("aria-label", S.guide.label);
    this.root.append(this.covered, this.arrow, this.gap, this.lane);
    this.refresh();
  }

  setGuidance(guidance: Guidance): void {
    this.guidance = guidance;
    this.refresh();
  }

  setVehicle(pose: Pose | null): void {
    this.vehicle = pose;
    this.refresh();
  }

  setState(state: State): void {
    this.unit = state.scale === "none" ? S.unit : "m";
  }

  clear(): void {
    this.guidance = this.vehicle = null;
    this.refresh();
  }

  private refresh(): void {
    const { guidance, vehicle } = this;
    this.root.hidden = guidance === null || guidance.area === 0;
    if (guidance === null || guidance.area === 0) return;
    say(this.covered, S.guide.covered(share(guidance.covered / guidance.area), amount(guidance.area, `${this.unit}²`)));
    const nearest = guidance.gaps[0];
    this.arrow.toggleAttribute("hidden", nearest === undefined || vehicle === null);
    if (nearest === undefined || vehicle === null) say(this.gap, nearest === undefined ? S.guide.noGap : "");
    else {
      const { turn, distance } = wayTo(vehicle, nearest.centre);
      this.arrow.style.rotate = `${turn}rad`;
      say(this.gap, S.guide.gap(amount(distance, this.unit), amount(nearest.area, `${this.unit}²`)));
    }
    say(this.lane, this.laneText(guidance));
  }

  private laneText({ lane, lanes, offLane }: Guidance): string {
    if (lane === null) return "";
    const distance = amount(Math.abs(offLane), this.unit);
    // To the right of the lane, the lane is to the left.
    const where = Math.abs(offLane) < 0.05 ? S.guide.onLane : offLane > 0 ? S.guide.left(distance) : S.guide.right(distance);
    return `${S.guide.lane(lane + 1, lanes.length)}: ${where}`;
  }
}
