// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import type { Api } from "../api";
import type { Recording, State } from "../wire/records";
import { byId, el, icon, plain, say } from "./dom";
import { count, S } from "./strings";

/** The recorded dive that the address names; null: the page shows what is now. */
export const recordedDive = new URLSearchParams(location.search).get("dive");

/** Says, in place of the dials, that what is seen is not now, and leads back to what is. */
export class Recorded {
  private readonly name = el("strong", "value");
  private readonly facts = el("span", "facts", S.recorded.opening);
  private state: State | null = null;
  private letGo = 0;

  constructor(
    private readonly api: Api,
    private readonly dive: string,
  ) {
    document.body.dataset["recorded"] = "";
    const text = el("div", "text", el("span", "label", S.recorded.title), this.name, this.facts);
    text.setAttribute("role", "status");
    const back = el("a", "seen", icon("back"), el("span", "label", S.recorded.live));
    back.href = location.pathname;
    byId("gauges").prepend(el("div", "recorded", icon("dives"), text, back));
  }

  /** All there is of it was sent. */
  get isWhole(): boolean {
    return this.state?.finished === true;
  }

  setRecording(recording: Recording): void {
    say(this.name, recording.name);
    document.title = plain(`${S.recorded.title} ${recording.name}`);
  }

  setState(state: State): void {
    this.state = state;
    this.refresh();
  }

  /** Records that found no room in the device's memory. */
  setLetGo(records: number): void {
    this.letGo = records;
    this.refresh();
  }

  /** The device has no feed of it for us, or is gone: why. */
  async explain(): Promise<void> {
    if (this.isWhole) return;
    const answer = await this.api.dives();
    const entry = answer.ok ? answer.value.find(({ id }) => id === this.dive) : undefined;
    if (entry?.recording === true) location.replace(location.pathname);
    else say(this.facts, !answer.ok ? S.recorded.unreachable : entry === undefined ? S.recorded.gone : S.recorded.busy);
    if (entry !== undefined) say(this.name, entry.name);
  }

  clear(): void {
    this.state = null;
    this.letGo = 0;
    say(this.facts, S.recorded.opening);
  }

  private refresh(): void {
    if (this.state === null) return;
    const images = count(this.state.captured);
    const read = this.letGo > 0 ? S.recorded.letGo(count(this.letGo)) : S.recorded.read(images);
    say(this.facts, this.isWhole ? read : S.recorded.reading(images));
  }
}
