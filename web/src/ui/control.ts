// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import type { Answer, Api } from "../api";
import type { Recording } from "../wire/records";
import { button, el, type Icon } from "./dom";
import type { Rail } from "./rail";
import { recordedDive } from "./recorded";
import { clock, S } from "./strings";

type Command = Parameters<Api["command"]>[0];

/** What the device said no to, for people. */
export function refusal(answer: Answer<unknown>): string {
  if (answer.ok) return "";
  if (answer.status === 0) return S.control.unreachable;
  if (answer.status === 401) return S.control.noToken;
  return answer.reason.trim() === "" ? S.control.refused : answer.reason.trim();
}

/** Begin and end a dive, for the one who controls. */
export class Control {
  private recording: Recording | null = null;
  private outcome = "";

  constructor(
    private readonly api: Api,
    private readonly rail: Rail,
  ) {
    api.onControl = () => {
      this.refresh();
    };
  }

  setRecording(recording: Recording): void {
    const before = this.recording;
    this.recording = recording;
    if (before?.phase !== recording.phase || before.controller !== recording.controller) this.refresh();
  }

  clear(): void {
    this.recording = null;
  }

  page(): HTMLElement {
    const { recording } = this;
    // A recorded dive's feed does not know who controls.
    const isKnown = this.api.controls || recordedDive === null;
    const facts = [
      isKnown ? S.control.controller(this.api.controls ? S.control.you : (recording?.controller ?? "")) : "",
      recording === null || recording.name === "" ? "" : `${recording.name} · ${S.phases[recording.phase]}`,
    ].filter((fact) => fact !== "");
    const outcome = el("p", "outcome", this.outcome);
    outcome.setAttribute("role", "status");
    return el("div", "form", ...facts.map((fact) => el("p", "", fact)), ...this.actions(), outcome);
  }

  private actions(): HTMLElement[] {
    if (!this.api.hasToken) return [el("p", "none", S.control.noToken)];
    if (!this.api.controls) return [this.nameField(), button("hand", S.control.take, async () => this.take(false), "wide")];
    const list: HTMLElement[] = [];
    const { recording } = this;
    if (recording?.controllable) {
      if (recording.phase === "recording" || recording.phase === "paused") {
        list.push(this.action("flag", S.control.stop, "dive/stop", S.control.stopSure));
        list.push(this.action("scene", S.control.submap, "dive/submap", null));
      } else {
        list.push(this.action("record", S.control.start, "dive/start", null));
      }
      list.push(this.action("system", S.control.shutDown, "shutdown", S.control.shutDownSure));
    } else {
      list.push(el("p", "none", recordedDive === null ? S.control.replay : S.recorded.control));
    }
    list.push(button("back", S.control.release, async () => this.api.releaseControl(), "wide"));
    return list;
  }

  /** sure: the question that is asked first. */
  private action(name: Icon, label: string, command: Command, sure: string | null): HTMLElement {
    const send = async () => this.send(command);
    if (sure === null) return button(name, label, send, "wide");
    return button(name, label, () => {
      this.rail.push(label, () => el("div", "form", el("p", "", sure), button(name, label, send, "wide danger")));
    }, "wide");
  }

  private nameField(): HTMLElement {
    const input = el("input", "");
    input.value = this.api.name;
    input.maxLength = 40;
    input.autocomplete = "off";
    input.addEventListener("change", () => {
      this.api.name = input.value;
    });
    return el("label", "field", el("span", "", S.control.name), input);
  }

  private async take(force: boolean): Promise<void> {
    const { place } = this.rail;
    const answer = await this.api.takeControl(force);
    this.outcome = refusal(answer);
    if (!answer.ok && answer.status === 409 && this.rail.isAt(place)) {
      const ask = button("hand", S.control.takeOver, async () => {
        this.rail.push(S.menu.dive, () => this.page());
        await this.take(true);
      }, "wide danger");
      this.rail.push(S.control.takeOver, () => el("div", "form", el("p", "", refusal(answer)), ask));
    }
    this.refresh();
  }

  private async send(command: Command): Promise<void> {
    const { place } = this.rail;
    const answer = await this.api.command(command);
    this.outcome = answer.ok ? S.control.done(clock(Date.now() / 1000)) : refusal(answer);
    if (this.rail.isAt(place)) this.rail.push(S.menu.dive, () => this.page());
  }

  private refresh(): void {
    this.rail.refreshPage(S.menu.dive);
  }
}
