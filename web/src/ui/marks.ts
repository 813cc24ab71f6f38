// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import type { Api } from "../api";
import type { Mark, Vec3 } from "../wire/records";
import { button, el, say } from "./dom";
import { refusal } from "./control";
import type { Pins } from "./pins";
import type { Rail } from "./rail";
import { recordedDive } from "./recorded";
import { clock, S } from "./strings";

/** Points somebody wants to find again, on the map and in the dive. */
export class Marks {
  /** There is a dive to keep them. */
  canBeMade = false;
  private all = new Map<number, Mark>();
  private shown = true;

  constructor(
    private readonly api: Api,
    private readonly pins: Pins,
    private readonly rail: Rail,
  ) {}

  get isShown(): boolean {
    return this.shown;
  }

  set isShown(shown: boolean) {
    this.shown = shown;
    this.place();
  }

  set(mark: Mark): void {
    this.all.set(mark.id, mark);
    this.place();
  }

  clear(): void {
    this.canBeMade = false;
    this.all = new Map();
    this.place();
  }

  get count(): number {
    return this.present.length;
  }

  /** Asks for a note and keeps the mark. */
  begin(point: Vec3, image: number | null): void {
    const note = el("textarea", "note");
    note.maxLength = 500;
    note.rows = 3;
    const label = el("label", "field", el("span", "", S.hands.note), note);
    const outcome = el("p", "outcome", this.api.hasToken ? "" : S.control.noToken);
    outcome.setAttribute("role", "status");
    const save = button("pin", S.hands.save, async () => this.save(point, image, note.value, outcome), "wide");
    this.rail.push(S.marks.title, () => el("div", "form", label, save, outcome));
  }

  private async save(point: Vec3, image: number | null, note: string, outcome: HTMLElement): Promise<void> {
    const { place } = this.rail;
    say(outcome, S.control.asking);
    const answer = await this.api.addMark(point, image, note);
    if (answer.ok) this.rail.closeAt(place);
    else say(outcome, refusal(answer));
  }

  private get present(): Mark[] {
    return [...this.all.values()].filter(({ removed }) => !removed);
  }

  private place(): void {
    const pins = this.shown ? this.present : [];
    this.pins.set(
      "mark",
      pins.map((mark) => ({
        key: `mark ${mark.id}`,
        at: mark.position,
        label: `${S.marks.title}: ${mark.note}`,
        kind: "mark" as const,
        onTap: () => {
          this.open(mark.id);
        },
      })),
    );
  }

  private open(id: number): void {
    const mark = this.all.get(id);
    if (mark === undefined) return;
    const outcome = el("p", "outcome", "");
    outcome.setAttribute("role", "status");
    const remove = button("trash", S.hands.remove, async () => this.remove(id, outcome), "wide");
    const hands = recordedDive === null ? [remove, outcome] : [];  // a recorded dive's marks stay
    this.rail.push(S.marks.title, () => el("div", "form", ...describe(mark), ...photograph(mark, this.api), ...hands));
  }

  private async remove(id: number, outcome: HTMLElement): Promise<void> {
    const { place } = this.rail;
    say(outcome, S.control.asking);
    const answer = await this.api.removeMark(id);
    if (answer.ok) this.rail.closeAt(place);
    else say(outcome, refusal(answer));
  }
}

function describe(mark: Mark): HTMLElement[] {
  return [el("p", "note", mark.note), el("p", "when", S.marks.at(clock(mark.time)))];
}

function photograph(mark: Mark, api: Api): HTMLElement[] {
  if (mark.image === null) return [];
  const photo = el("img", "photo");
  photo.alt = S.marks.photo;
  photo.addEventListener("error", () => { photo.remove(); });  // it was not projected
  photo.src = recordedDive === null ? api.photoAddress(mark.id) : api.imageAddress(recordedDive, mark.image);
  return [photo];
}
