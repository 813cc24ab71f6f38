// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The planar clouds (3DSIP). Those near what is looked at are drawn cell by cell, the others from a sixteenth of their
// cells: what a dive of any length takes on the graphics card is bounded but for some 4 kB a plane.
import { Group, type Vector3 } from "three";
import type { PlaneColour, PlaneGrid, Vec3 } from "../wire/records";
import { unpack, type Size, type Unpacked } from "./images";
import type { Origin } from "./origin";
import { Chunk } from "./plane_chunk";
import { Store, type Kept } from "./store";

export type PlaneStyle = "quads" | "points";

/** Beyond so many points every second row and column is left out, and so on. */
const MAX_POINTS = 1_500_000;
/** Planes that are drawn cell by cell. */
const MOST_FINE = 512;
const COARSE = 4;
/** Planes that become fine at a time. */
const AT_ONCE = 64;

interface Place {
  chunk: Chunk;
  index: number;
}

interface Plane {
  grid?: PlaneGrid;
  jpeg?: Kept;
  /** Was not unpacked yet. */
  isFresh?: boolean;
  /** Of the colours. */
  sequence: number;
  coarse?: Place;
  fine?: Place | undefined;
  /** Its fine picture is being made, or could not be. */
  busy?: boolean;
  broken?: Kept;
}

export class Planes {
  readonly object = new Group();
  /** Planes with geometry and colours. */
  count = 0;
  /** Much is told at once: only what is coarse is unpacked of it. */
  isCatchingUp: () => boolean = () => false;
  private planes = new Map<number, Plane>();
  private chunks: Chunk[] = [];
  private fine = new Set<Plane>();
  private store = new Store();
  private style: PlaneStyle = "quads";
  private coarseness = 1;

  constructor(private readonly origin: Origin) {}

  /** Those of them that are drawn cell by cell. */
  get fineCount(): number {
    return this.fine.size;
  }

  /** It has geometry and colours. */
  has(image: number): boolean {
    return this.planes.get(image)?.coarse !== undefined;
  }

  /** Rejects when the picture that came before cannot be decoded. */
  async setGrid(grid: PlaneGrid): Promise<void> {
    const plane = this.plane(grid.image);
    const known = plane.grid;
    plane.grid = grid;
    if (known === undefined) await this.paint(plane);
    else this.place(plane);
  }

  /** Rejects when the picture cannot be decoded. */
  async setColour(colour: PlaneColour & { sequence: number }): Promise<void> {
    const plane = this.plane(colour.image);
    if (plane.sequence > colour.sequence) return;
    plane.sequence = colour.sequence;
    this.store.drop(plane.jpeg ?? null);
    plane.jpeg = this.store.keep(colour.jpeg);
    plane.isFresh = true;
    await this.paint(plane);
  }

  setStyle(style: PlaneStyle): void {
    this.style = style;
    this.chunks.forEach((chunk) => {
      this.dress(chunk);
    });
  }

  /** Draws only every so many points in each direction. */
  setCoarseness(coarseness: number): void {
    if (coarseness === this.coarseness) return;
    this.coarseness = coarseness;
    this.setStrides();
  }

  /** Draws those nearest to what is looked at cell by cell; resolves when something has changed. */
  async refine(target: Vector3): Promise<boolean> {
    if (this.fine.size === this.count) return false;
    const distance = ({ grid }: Plane) => {
      if (grid === undefined) return Infinity;
      const [x, y, z] = this.origin.toScene(grid.camera);
      return (x - target.x) ** 2 + (y - target.y) ** 2 + (z - target.z) ** 2;
    };
    const nearest = [...this.planes.values()].map((plane) => ({ plane, at: distance(plane) })).sort((one, other) => one.at - other.at);
    const wanted = new Set(nearest.slice(0, MOST_FINE).map(({ plane }) => plane));
    const isMissing = ({ fine, coarse, busy, jpeg, broken }: Plane) =>
      fine === undefined && coarse !== undefined && busy !== true && (broken === undefined || broken !== jpeg);
    const coming = nearest.filter(({ plane }) => plane.busy === true).length;
    const missing = [...wanted].filter(isMissing).slice(0, Math.max(0, AT_ONCE - coming));
    const spare = [...this.fine].filter((plane) => !wanted.has(plane));
    for (const plane of spare.slice(0, Math.max(0, this.fine.size + coming + missing.length - MOST_FINE))) this.coarsen(plane);
    await Promise.all(missing.map((plane) => this.makeFine(plane)));
    return missing.length > 0;
  }

  clear(): void {
    this.chunks.forEach((chunk) => {
      this.object.remove(chunk.quads, chunk.points);
      chunk.dispose();
    });
    this.chunks = [];
    this.planes.forEach((plane) => {
      delete plane.jpeg;
    });
    this.store = new Store();
    this.planes = new Map();
    this.fine = new Set();
    this.count = 0;
  }

  private plane(image: number): Plane {
    let plane = this.planes.get(image);
    if (plane === undefined) {
      plane = { sequence: -1 };
      this.planes.set(image, plane);
    }
    return plane;
  }

  /** Unpacks its colours for the first time, or anew; newcomers are fine while there is room and time. */
  private async paint(plane: Plane): Promise<void> {
    const { grid, jpeg, isFresh } = plane;
    if (grid === undefined || jpeg === undefined || isFresh !== true) return;
    plane.isFresh = false;
    const mayBeFine = plane.fine !== undefined || (this.fine.size < MOST_FINE && !this.isCatchingUp());
    const unpacked = await unpack(jpeg.bytes, null, mayBeFine ? [coarseSize(grid), fineSize(grid)] : [coarseSize(grid)]);
    if (plane.jpeg !== jpeg || !fits(unpacked, grid)) return;
    const isNew = plane.coarse === undefined;
    plane.coarse ??= this.newPlace(grid, COARSE);
    fill(plane.coarse, unpacked.pixels[0]);
    if (mayBeFine && plane.fine === undefined && this.fine.size < MOST_FINE) this.giveFine(plane, grid);
    if (mayBeFine && plane.fine !== undefined) fill(plane.fine, unpacked.pixels[1]);
    if (isNew) ++this.count;
    this.place(plane);
  }

  private async makeFine(plane: Plane): Promise<void> {
    const { grid, jpeg } = plane;
    if (grid === undefined || jpeg === undefined) return;
    plane.busy = true;
    const unpacked = await unpack(jpeg.bytes, null, [fineSize(grid)]).catch(() => null);
    plane.busy = false;
    if (unpacked === null) {
      plane.broken = jpeg;
    } else if (plane.jpeg === jpeg && plane.fine === undefined) {
      fill(this.giveFine(plane, grid), unpacked.pixels[0]);
      this.place(plane);
    }
  }

  private giveFine(plane: Plane, grid: PlaneGrid): Place {
    const place = this.newPlace(grid, 1);
    plane.fine = place;
    this.fine.add(plane);
    return place;
  }

  private coarsen(plane: Plane): void {
    plane.fine?.chunk.release(plane.fine.index);
    plane.fine = undefined;
    this.fine.delete(plane);
    this.place(plane);
  }

  private place({ grid, coarse, fine }: Plane): void {
    if (grid === undefined) return;
    fine?.chunk.show(fine.index, grid, this.origin);
    if (fine === undefined) coarse?.chunk.show(coarse.index, grid, this.origin);
    else coarse?.chunk.hide(coarse.index);
  }

  private newPlace({ columns, rows }: PlaneGrid, cellsPerTexel: number): Place {
    const takes = (one: Chunk) => one.columns === columns && one.rows === rows && one.cellsPerTexel === cellsPerTexel;
    let chunk = this.chunks.find((one) => takes(one) && !one.isFull);
    if (chunk === undefined) {
      chunk = new Chunk(columns, rows, cellsPerTexel);
      this.chunks.push(chunk);
      this.object.add(chunk.quads, chunk.points);
      this.dress(chunk);
    }
    const place = { chunk, index: chunk.take() };
    this.setStrides();
    return place;
  }

  private setStrides(): void {
    const points = this.chunks.reduce((sum, chunk) => sum + chunk.size, 0);
    const least = Math.ceil(Math.sqrt(points / MAX_POINTS));
    this.chunks.forEach((chunk) => {
      // What is coarse already keeps its points the longest.
      chunk.setStride(Math.max(1, Math.ceil(Math.max(least, this.coarseness) / chunk.cellsPerTexel)));
    });
  }

  private dress(chunk: Chunk): void {
    chunk.quads.visible = this.style === "quads";
    chunk.points.visible = this.style === "points";
  }
}

function fill({ chunk, index }: Place, pixels: Uint8ClampedArray | undefined): void {
  if (pixels !== undefined) chunk.setColours(index, pixels);
}

function fineSize({ columns, rows }: PlaneGrid): Size {
  return { width: columns, height: rows };
}

function coarseSize({ columns, rows }: PlaneGrid): Size {
  return { width: Math.ceil(columns / COARSE), height: Math.ceil(rows / COARSE) };
}

function fits({ width, height }: Unpacked, { columns, rows }: PlaneGrid): boolean {
  return width === columns && height === rows;
}

/** Survey point of a grid's cell; null where the grid has none. */
export function pointOf(grid: PlaneGrid, column: number, row: number): Vec3 | null {
  const h = (i: number) =>
    (grid.surveyFromGrid[3 * i] ?? 0) * column + (grid.surveyFromGrid[3 * i + 1] ?? 0) * row + (grid.surveyFromGrid[3 * i + 2] ?? 0);
  const w = h(3);
  return w > 0 ? [h(0) / w, h(1) / w, h(2) / w] : null;
}
