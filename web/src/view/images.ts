// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Compressed pictures to pixels, a few at a time, colours untouched.

const AT_ONCE = 8;
const MOST_CANVASES = 16;
const OPTIONS: ImageBitmapOptions = { colorSpaceConversion: "none", premultiplyAlpha: "none" };

export interface Size {
  width: number;
  height: number;
}

let running = 0;
const waiting: (() => void)[] = [];

/** A JPEG or PNG file, ahead of those that wait their turn. Rejects when it cannot be decoded. */
export async function decodeNow(file: Blob): Promise<ImageBitmap> {
  return createImageBitmap(file, OPTIONS);
}

/** The same in its turn; with a side, reduced to a square of so many pixels. */
export async function decodeImage(file: Blob, side?: number): Promise<ImageBitmap> {
  if (running >= AT_ONCE) await new Promise<void>((go) => waiting.push(go));
  ++running;
  try {
    if (side === undefined) return await decodeNow(file);
    return await createImageBitmap(file, { ...OPTIONS, resizeWidth: side, resizeHeight: side, resizeQuality: "medium" });
  } finally {
    --running;
    waiting.shift()?.();
  }
}

export function jpegFile(bytes: Uint8Array): Blob {
  return new Blob([new Uint8Array(bytes)], { type: "image/jpeg" });
}

export function pngFile(bytes: Uint8Array): Blob {
  return new Blob([new Uint8Array(bytes)], { type: "image/png" });
}

/** A canvas of each size that is asked for: there are few, and making one takes longer than to draw on it. */
const canvases = new Map<string, OffscreenCanvasRenderingContext2D>();

/** The bitmap's RGBA bytes at a size, by default its own, first row first. */
export function pixels(bitmap: ImageBitmap | OffscreenCanvas, size: Size = bitmap): ImageData {
  const { width, height } = size;
  const context = canvasOf(width, height);
  context.clearRect(0, 0, width, height);
  context.drawImage(bitmap, 0, 0, width, height);
  return context.getImageData(0, 0, width, height);
}

function canvasOf(width: number, height: number): OffscreenCanvasRenderingContext2D {
  const key = `${width} ${height}`;
  const known = canvases.get(key);
  if (known !== undefined) return known;
  const context = new OffscreenCanvas(width, height).getContext("2d", { willReadFrequently: true });
  if (context === null) throw new Error("no 2D canvas");
  context.imageSmoothingQuality = "medium";
  if (canvases.size >= MOST_CANVASES) canvases.clear();
  canvases.set(key, context);
  return context;
}
