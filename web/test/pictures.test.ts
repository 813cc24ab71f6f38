// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Pictures are unpacked beside the page: one that a newer has overtaken must not be shown.
import { Vector3, type BufferGeometry, type Mesh, type Points, type ShaderMaterial } from "three";
import { beforeEach, describe, expect, it, vi } from "vitest";
import { Mosaics } from "../src/view/mosaics";
import { Origin } from "../src/view/origin";
import { Planes } from "../src/view/planes";
import type { Mosaic, MosaicOverview, MosaicTile, PlaneGrid } from "../src/wire/records";

interface Size {
  width: number;
  height: number;
}

interface Job {
  picture: Uint8Array | Blob;
  finish(): void;
  fail(): void;
}

const { jobs } = vi.hoisted(() => ({ jobs: [] as Job[] }));

vi.mock("../src/view/images", () => ({
  unpack: async (picture: Uint8Array | Blob, _mask: unknown, sizes: Size[], bitmapSize: Size | "own" | null) =>
    new Promise((resolve, reject) => {
      const file = picture instanceof Blob ? picture : new Blob([new Uint8Array(picture)]);
      const pixels = sizes.map(({ width, height }) => new Uint8ClampedArray(4 * width * height));
      const { width, height } = typeof bitmapSize === "object" && bitmapSize !== null ? bitmapSize : { width: 256, height: 256 };
      const bitmap = { file, width, height, close: () => undefined };
      jobs.push({
        picture,
        finish: () => { resolve({ width: 150, height: 100, pixels, bitmap }); },
        fail: () => { reject(new Error("broken")); },
      });
    }),
}));

interface Picture {
  file: Blob;
  width: number;
}

const GRID: Mosaic = {
  type: "mosaic",
  mosaic: 0,
  submap: 0,
  world: { a: 0.01, d: 0, b: 0, e: -0.01, c: 0, f: 0 },
  normal: [0, 0, 1],
  offset: 0,
  groundSamplingDistance: 0.01,
};

const GRID_OF_3: PlaneGrid = {
  type: "plane_grid",
  image: 3,
  submap: 0,
  columns: 150,
  rows: 100,
  surveyFromGrid: new Float64Array(12),
  camera: [0, 0, 0],
  maxRange: 1,
};

/** Cells to a texel of each plane that is drawn. */
function quadsShown(planes: Planes): number[] {
  return planes.object.children.flatMap((object) => {
    const layer = (object as Mesh | Points).geometry.getAttribute("layer");
    if ("isPoints" in object) return [];
    const cells = uniformsOf(object)["cellsPerTexel"]?.value as number;
    return [...layer.array].filter((at) => at >= 0).map(() => cells);
  });
}

function tile(sequence: number): MosaicTile & { sequence: number } {
  return { type: "mosaic_tile", mosaic: 0, column: 0, row: 0, jpeg: new Uint8Array([sequence]), mask: null, sequence };
}

/** Ends what is unpacked now and lets what follows from it begin. */
async function finish(): Promise<void> {
  for (const job of jobs.splice(0)) job.finish();
  await new Promise((resolve) => setTimeout(resolve));
}

async function shown(mosaics: Mosaics): Promise<number | undefined> {
  const [, full] = mosaics.object.children;
  const mesh = full?.children[0] as { material: { map: { image: Picture } } } | undefined;
  const file = mesh?.material.map.image.file;
  return file === undefined ? undefined : new Uint8Array(await file.arrayBuffer())[0];
}

function uniformsOf(object: unknown): ShaderMaterial["uniforms"] {
  return (object as Mesh<BufferGeometry, ShaderMaterial>).material.uniforms;
}

describe("Planes", () => {
  beforeEach(() => { jobs.length = 0; });

  it("are there once both their halves are, whichever comes first", async () => {
    const planes = new Planes(new Origin());
    void planes.setColour({ type: "plane_colour", image: 3, jpeg: new Uint8Array([1]), sequence: 1 });
    expect(jobs.length).toBe(0);
    const painted = planes.setGrid(GRID_OF_3);
    await finish();
    await painted;
    expect(planes.has(3)).toBe(true);
  });

  it("are coarse while much is told, and fine after that", async () => {
    const planes = new Planes(new Origin());
    planes.isCatchingUp = () => true;
    void planes.setGrid(GRID_OF_3);
    void planes.setColour({ type: "plane_colour", image: 3, jpeg: new Uint8Array([1]), sequence: 1 });
    await finish();
    expect(planes.has(3)).toBe(true);
    expect(quadsShown(planes)).toEqual([4]);
    planes.isCatchingUp = () => false;
    const refined = planes.refine(new Vector3());
    await finish();
    expect(await refined).toBe(true);
    expect(quadsShown(planes)).toEqual([1]);
    expect(await planes.refine(new Vector3())).toBe(false);
  });

  it("become fine though another cannot, which is not tried for ever", async () => {
    const planes = new Planes(new Origin());
    planes.isCatchingUp = () => true;
    for (const image of [3, 4]) {
      void planes.setGrid({ ...GRID_OF_3, image });
      void planes.setColour({ type: "plane_colour", image, jpeg: new Uint8Array([image]), sequence: image });
    }
    await finish();
    const refined = planes.refine(new Vector3());
    jobs.shift()?.fail();
    await finish();
    expect(await refined).toBe(true);
    expect(planes.fineCount).toBe(1);
    expect(await planes.refine(new Vector3())).toBe(false);
  });
});

describe("Mosaics", () => {
  beforeEach(() => { jobs.length = 0; });

  const wholeScreen = () => 1000;

  it("shows a tile in full, and anew when it is told anew", async () => {
    const mosaics = new Mosaics(new Origin());
    mosaics.setMosaic(GRID);
    void mosaics.setTile(tile(1));
    void mosaics.refine(wholeScreen);
    await finish();
    expect(await shown(mosaics)).toBe(1);
    void mosaics.setTile(tile(2));
    await finish();
    expect(await shown(mosaics)).toBe(2);
  });

  it("does not keep an older picture that was unpacked in full while a newer one came", async () => {
    const mosaics = new Mosaics(new Origin());
    mosaics.setMosaic(GRID);
    void mosaics.setTile(tile(1));
    void mosaics.refine(wholeScreen);
    void mosaics.setTile(tile(2));
    await finish();
    expect(await shown(mosaics)).toBeUndefined();
    void mosaics.refine(wholeScreen);
    await finish();
    expect(await shown(mosaics)).toBe(2);
  });

  it("shows the newest overview, in whatever order they are unpacked", async () => {
    const mosaics = new Mosaics(new Origin());
    mosaics.setMosaic(GRID);
    const overview = (sequence: number) => ({ ...tile(sequence), type: "mosaic_overview" }) satisfies MosaicOverview;
    void mosaics.setOverview(overview(1));
    void mosaics.setOverview(overview(2));
    jobs.reverse();
    await finish();
    const { colours } = uniformsOf(mosaics.object.children[0]?.children[0]);
    const { file } = (colours?.value as { image: Picture }).image;
    expect(new Uint8Array(await file.arrayBuffer())[0]).toBe(2);
  });

  it("keeps overviews small but for those that are large on the screen", async () => {
    const mosaics = new Mosaics(new Origin());
    mosaics.setMosaic(GRID);
    const told = (sequence: number) => { void mosaics.setOverview({ ...tile(sequence), type: "mosaic_overview" }); };
    const width = () => (uniformsOf(mosaics.object.children[0]?.children[0])["colours"]?.value as { image: Picture }).image.width;
    told(1);
    await finish();
    expect(width()).toBe(64);
    expect(await mosaics.refine(() => 70)).toBe(false);
    const refined = mosaics.refine(() => 100);
    await finish();
    expect(await refined).toBe(true);
    expect(width()).toBe(256);
    told(2);
    await finish();
    expect(width()).toBe(256);
    expect(await mosaics.refine(() => 100)).toBe(false);
  });

  it("leaves out of an overview the tiles that are shown in full, and no other", async () => {
    const mosaics = new Mosaics(new Origin());
    mosaics.setMosaic(GRID);
    void mosaics.setTile({ ...tile(1), column: -1, row: 9 });
    void mosaics.refine(wholeScreen);
    await finish();
    const { holes } = uniformsOf(mosaics.object.children[0]?.children[0]);
    expect(holes?.value).toEqual(new Uint32Array([1 << (8 * 1 + 7), 0]));  // its row 1, column 7
  });

  it("shows nothing of the dive before that is unpacked late", async () => {
    const mosaics = new Mosaics(new Origin());
    mosaics.setMosaic(GRID);
    void mosaics.setTile(tile(1));
    void mosaics.refine(wholeScreen);
    mosaics.clear();
    await finish();
    expect(mosaics.count).toBe(0);
    expect(await shown(mosaics)).toBeUndefined();
  });
});
