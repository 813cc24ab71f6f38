// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import { decodeImage } from "../view/images";
import type { LiveImage } from "../wire/records";
import { byId, el, say } from "./dom";
import { clock, S } from "./strings";

/** The current image; a tap makes it large. While one is decoded only the newest of those that come is kept. */
export class LivePicture {
  private readonly root = byId("live");
  private readonly canvas = el("canvas", "");
  private readonly caption = el("figcaption", "", S.live.none);
  private next: LiveImage | null = null;
  private busy = false;

  constructor(private readonly broken: () => void) {
    const frame = el("button", "frame", el("figure", "", this.canvas, this.caption));
    frame.type = "button";
    frame.setAttribute("aria-label", S.live.title);
    frame.addEventListener("click", () => this.root.classList.toggle("large"));
    this.root.append(frame);
  }

  show(image: LiveImage): void {
    this.next = image;
    if (!this.busy) void this.drain();
  }

  private async drain(): Promise<void> {
    this.busy = true;
    while (this.next !== null) {
      const image = this.next;
      this.next = null;
      try {
        this.paint(await decodeImage(new Uint8Array(image.jpeg), "image/jpeg"));
        say(this.caption, `${S.live.caption(image.image)} · ${clock(image.time)}`);
      } catch {
        this.broken();
      }
    }
    this.busy = false;
  }

  private paint(bitmap: ImageBitmap): void {
    this.root.classList.add("some");
    if (this.canvas.width !== bitmap.width) this.canvas.width = bitmap.width;
    if (this.canvas.height !== bitmap.height) this.canvas.height = bitmap.height;
    this.canvas.getContext("2d")?.drawImage(bitmap, 0, 0);
    bitmap.close();
  }
}
