// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Compressed pictures to pixels, a few at a time, colours untouched.

const AT_ONCE = 4;
const OPTIONS: ImageBitmapOptions = { colorSpaceConversion: "none", premultiplyAlpha: "none" };

let running = 0;
const waiting: (() => void)[] = [];

export async function decodeImage(bytes: Uint8Array<ArrayBuffer>, type: "image/jpeg" | "image/png"): Promise<ImageBitmap> {
  if (running >= AT_ONCE) await new Promise<void>((go) => waiting.push(go));
  ++running;
  try {
    return await createImageBitmap(new Blob([bytes], { type }), OPTIONS);
  } finally {
    --running;
    waiting.shift()?.();
  }
}

/** The bitmap's RGBA bytes, first row first; the bitmap is used up. */
export function pixels(bitmap: ImageBitmap): ImageData {
  const { width, height } = bitmap;
  const context = new OffscreenCanvas(width, height).getContext("2d", { willReadFrequently: true });
  if (context === null) throw new Error("no 2D canvas");
  context.drawImage(bitmap, 0, 0);
  bitmap.close();
  return context.getImageData(0, 0, width, height);
}
