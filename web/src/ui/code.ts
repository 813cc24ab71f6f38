// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import encodeQR from "qr";
import type { Api } from "../api";
import { el } from "./dom";
import { S } from "./strings";

/** Light around the code, which readers need, and side of a module, px. */
const QUIET = 4;
const MODULE_PX = 8;

/** The device's address with its token, for the camera of a tablet; only the device's own screen can show it. */
export async function codePage(api: Api): Promise<HTMLElement> {
  const address = await api.controlAddress();
  if (address === null) return el("p", "none", S.control.noCode);
  const picture = el("canvas", "code");
  picture.setAttribute("role", "img");
  picture.setAttribute("aria-label", S.control.showCode);
  draw(picture, encodeQR(address, "raw", { ecc: "medium", border: QUIET }));
  return el("div", "form", el("p", "", S.control.code), picture, el("p", "address", address));
}

function draw(canvas: HTMLCanvasElement, modules: boolean[][]): void {
  canvas.width = canvas.height = MODULE_PX * modules.length;
  const context = canvas.getContext("2d");
  if (context === null) return;
  context.fillStyle = "#fff";
  context.fillRect(0, 0, canvas.width, canvas.height);
  context.fillStyle = "#000";
  modules.forEach((row, y) => {
    row.forEach((dark, x) => {
      if (dark) context.fillRect(MODULE_PX * x, MODULE_PX * y, MODULE_PX, MODULE_PX);
    });
  });
}
