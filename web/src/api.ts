// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// What the page asks of the device beside the feed; include/nadir/serve/README.md is its written form. Whatever changes
// something there needs the device's token.
import { recall, remember } from "./ui/memory";

export interface DiveEntry {
  id: string;
  name: string;
  /** UTC as 2026-11-29T19:04:02Z; null where the clock was not set. */
  begun: string | null;
  images: number | null;
  area_m2: number | null;
  bytes: number;
  complete: boolean;
  recording: boolean;
}

/** A dive's files, and its folders of many. */
export interface Contents {
  products: Product[];
  folders: { name: string; files: number; bytes: number }[];
}

export interface Product {
  id: string;
  name: string;
  bytes: number;
  kind: string;
}

export type Answer<T> = { ok: true; value: T } | { ok: false; status: number; reason: string };

const RENEW_MS = 20_000;
/** A device that says nothing for so long does not answer. */
const SILENCE_MS = 15_000;
/** As the device makes them: include/nadir/serve/README.md. */
const TOKEN = /^[\w-]{43}$/;
const OWN_SCREEN = /^(localhost|127\.\d+\.\d+\.\d+|\[::1\])$/;

export class Api {
  /** Told when this page takes or loses control. */
  onControl: () => void = () => undefined;
  private readonly session = crypto.getRandomValues(new Uint32Array(4)).join("-");
  private renewal: ReturnType<typeof setInterval> | undefined;
  private token = recall("token");

  constructor() {
    // The code that was scanned carries the token behind the #, which a browser never sends.
    const given = new URLSearchParams(location.hash.slice(1)).get("token");
    if (given !== null) history.replaceState(null, "", location.pathname + location.search);
    if (given !== null && TOKEN.test(given)) void this.tryToken(given);
  }

  get hasToken(): boolean {
    return this.token !== null;
  }

  get name(): string {
    return recall("name") ?? "";
  }

  set name(name: string) {
    remember("name", name.trim() === "" ? null : name.trim());
  }

  get controls(): boolean {
    return this.renewal !== undefined;
  }

  /** force: from whoever has it. */
  async takeControl(force: boolean): Promise<Answer<unknown>> {
    const answer = await this.ask("POST", "control/take", { force });
    if (answer.ok) this.keepControl(true);
    return answer;
  }

  async releaseControl(): Promise<void> {
    this.keepControl(false);
    await this.ask("POST", "control/release");
  }

  async command(what: "dive/start" | "dive/stop" | "dive/submap" | "shutdown"): Promise<Answer<unknown>> {
    return this.ask("POST", what);
  }

  async addMark(point: readonly number[], image: number | null, note: string): Promise<Answer<unknown>> {
    const [x, y, z] = point;
    return this.ask("POST", "marks", { x, y, z, note, ...(image === null ? {} : { image }) });
  }

  async removeMark(id: number): Promise<Answer<unknown>> {
    return this.ask("DELETE", `marks/${id}`);
  }

  photoAddress(mark: number): string {
    return new URL(`api/marks/${mark}/photo`, location.href).href;
  }

  async dives(): Promise<Answer<DiveEntry[]>> {
    return this.ask("GET", "dives");
  }

  async contents(dive: string): Promise<Answer<Contents>> {
    return this.ask("GET", `dives/${dive}`);
  }

  /** An image of a recorded dive as it lies on the ground. */
  imageAddress(dive: string, image: number): string {
    return new URL(`api/dives/${dive}/images/${image}`, location.href).href;
  }

  /** All of a dive in one file. */
  archiveAddress(dive: string): string {
    return new URL(`api/dives/${dive}/archive`, location.href).href;
  }

  productAddress(dive: string, product: string): string {
    return new URL(`api/dives/${dive}/files/${product}`, location.href).href;
  }

  async removeDive(dive: string): Promise<Answer<unknown>> {
    return this.ask("DELETE", `dives/${dive}`);
  }

  /** Where a tablet may control the device; only the device's own screen is told. */
  async controlAddress(): Promise<string | null> {
    const answer = await this.ask<{ token: string; url: string | null }>("GET", "token");
    return answer.ok && answer.value.url !== null ? `${answer.value.url}#token=${answer.value.token}` : null;
  }

  /** The link is up, perhaps to a device that has begun anew: whoever stands before its own screen may control it. */
  async greet(): Promise<void> {
    if (!OWN_SCREEN.test(location.hostname)) return;
    const answer = await this.ask<{ token: string }>("GET", "token");
    if (!answer.ok) return;
    this.token = answer.value.token;
    this.onControl();
  }

  /** In place of one that the device knows only if it knows this one: any link may carry one. */
  private async tryToken(given: string): Promise<void> {
    const before = this.token;
    this.token = given;
    const answer = before === null || before === given ? null : await this.ask("POST", "control/renew");
    // 429: too many wrong ones came from here.
    if (answer !== null && !answer.ok && [0, 401, 429].includes(answer.status)) this.token = before;
    else remember("token", given);
    this.onControl();
  }

  private keepControl(keep: boolean): void {
    clearInterval(this.renewal);
    this.renewal = undefined;
    if (keep) {
      this.renewal = setInterval(() => {
        void this.ask("POST", "control/renew");
      }, RENEW_MS);
    }
    this.onControl();
  }

  private async ask<T>(method: string, path: string, body?: object): Promise<Answer<T>> {
    const headers: Record<string, string> = { "Nadir-Session": this.session, "Nadir-Name": encodeURIComponent(this.name) };
    if (this.token !== null && method !== "GET") headers["Authorization"] = `Bearer ${this.token}`;
    if (body !== undefined) headers["Content-Type"] = "application/json";
    try {
      const response = await fetch(new URL(`api/${path}`, location.href), {
        method,
        headers,
        cache: "no-store",
        signal: AbortSignal.timeout(SILENCE_MS),
        ...(body === undefined ? {} : { body: JSON.stringify(body) }),
      });
      const text = await response.text();
      if (response.ok) return { ok: true, value: (text === "" ? null : JSON.parse(text)) as T };
      if (path !== "control/take" && isLoss(response.status, text)) this.keepControl(false);
      return { ok: false, status: response.status, reason: reasonIn(text) };
    } catch {
      return { ok: false, status: 0, reason: "" };
    }
  }
}

/** Whether this page has no control any more: a refusal says who has it, or the token is another. */
function isLoss(status: number, text: string): boolean {
  if (status === 401) return true;
  try {
    return status === 409 && "controller" in (JSON.parse(text) as object);
  } catch {
    return false;
  }
}

function reasonIn(text: string): string {
  try {
    return String((JSON.parse(text) as { error: unknown }).error);
  } catch {
    return text;
  }
}
