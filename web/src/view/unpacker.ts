// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Compressed pictures to pixels, in a thread beside the page's.
import type { Job, Outcome, Size } from "./images";

const OPTIONS: ImageBitmapOptions = { colorSpaceConversion: "none", premultiplyAlpha: "none" };
const MOST_CANVASES = 16;

/** A canvas of each size that is asked for: there are few, and making one takes longer than to draw on it. */
const canvases = new Map<string, OffscreenCanvasRenderingContext2D>();

addEventListener("message", (event: MessageEvent<Job>) => {
  void unpack(event.data);
});

async function unpack({ id, picture, mask, sizes, bitmap: bitmapSize }: Job): Promise<void> {
  try {
    const colour = await createImageBitmap(fileOf(picture), OPTIONS);
    const seen = mask === null ? null : await createImageBitmap(fileOf(mask), OPTIONS);
    if (seen !== null && (seen.width !== colour.width || seen.height !== colour.height)) {
      throw new Error("the mask is not of the picture's size");
    }
    const { width, height } = colour;
    const pixels = sizes.map((size) => pixelsOf(colour, seen, size ?? colour).data);
    const bitmap = bitmapSize === null ? null : await bitmapOf(pixelsOf(colour, seen, bitmapSize === "own" ? colour : bitmapSize));
    colour.close();
    seen?.close();
    const outcome: Outcome = { id, width, height, pixels, bitmap };
    postMessage(outcome, { transfer: [...pixels.map(({ buffer }) => buffer), ...(bitmap === null ? [] : [bitmap])] });
  } catch (fault) {
    postMessage({ id, fault: String(fault) } satisfies Outcome);
  }
}

async function bitmapOf(pixels: ImageData): Promise<ImageBitmap> {
  return createImageBitmap(pixels, { ...OPTIONS, premultiplyAlpha: "premultiply" });
}

function fileOf(picture: Uint8Array<ArrayBuffer> | Blob): Blob {
  if (picture instanceof Blob) return picture;
  return new Blob([picture], { type: picture[0] === 0x89 ? "image/png" : "image/jpeg" });
}

/** RGBA, first row first; transparent where the mask is black. */
function pixelsOf(colour: ImageBitmap, mask: ImageBitmap | null, size: Size): ImageData {
  const image = drawn(colour, size);
  if (mask === null) return image;
  const alpha = drawn(mask, size);
  for (let i = 0; i < image.data.length; i += 4) image.data[i + 3] = alpha.data[i] ?? 0;
  return image;
}

function drawn(bitmap: ImageBitmap, { width, height }: Size): ImageData {
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
