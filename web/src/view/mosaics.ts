// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The 2D mosaics (2DSIM) on their planes: overviews of all of them, and in full those tiles that are large on the
// screen, so that what a mosaic of any size takes on the graphics card is bounded but for some 30 kB for eight by eight
// tiles. Pictures are unpacked for that only.
import {
  BufferGeometry,
  CustomBlending,
  DoubleSide,
  Float32BufferAttribute,
  Group,
  LinearMipmapLinearFilter,
  Mesh,
  MeshBasicMaterial,
  OneFactor,
  OneMinusSrcAlphaFactor,
  Texture,
  Vector3,
} from "three";
import { OVERVIEW_TILES, TILE_SIZE, type Mosaic, type MosaicOverview, type MosaicTile, type Vec3 } from "../wire/records";
import type { Ray } from "./ground";
import { unpack, type Size } from "./images";
import type { Origin } from "./origin";
import { Overview } from "./overviews";
import { Store, type Kept } from "./store";

/** Tiles shown in full at a time, overviews with all their pixels, and how many are decoded for it at once. */
const MOST_FULL = 160;
const MOST_FINE = 160;
const AT_ONCE = 40;
/** Side of the other overviews, px. */
const SMALL = 64;
/** A tile this wide on the screen shows more in full, px. */
const LARGE_PX = (1.2 * TILE_SIZE) / OVERVIEW_TILES;
/** An overview this wide on the screen shows more with all its pixels. */
const FINE_PX = 1.2 * SMALL;

/** px of a length at a scene point, 0 when it is out of sight. */
type SizeOf = (at: Vector3, length: number) => number;

interface Place {
  mosaic: number;
  column: number;
  row: number;
}

interface Tile extends Place {
  /** To be unpacked when it is large. */
  jpeg: Kept | null;
  mask: Kept | null;
  /** Of the colours. */
  sequence: number;
  mesh: Mesh<BufferGeometry, MeshBasicMaterial> | null;
  /** Being made full. */
  busy: boolean;
  /** Could not be unpacked. */
  broken: Kept | null;
}

export class Mosaics {
  readonly object = new Group();
  /** Tiles with colours. */
  count = 0;
  readonly grids = new Map<number, Mosaic>();
  private tiles = new Map<string, Tile>();
  private overviews = new Map<string, Overview>();
  private store = new Store();
  private readonly far = new Group();
  private readonly full = new Group();

  constructor(private readonly origin: Origin) {
    this.object.add(this.far, this.full);
  }

  setMosaic(mosaic: Mosaic): void {
    this.grids.set(mosaic.mosaic, mosaic);
    for (const tile of this.tiles.values()) {
      if (tile.mosaic === mosaic.mosaic) this.place(tile);
    }
    for (const overview of this.overviews.values()) {
      if (overview.mosaic === mosaic.mosaic) this.placeOverview(overview);
    }
  }

  /** Rejects when it is shown in full and cannot be decoded. */
  async setTile(record: MosaicTile & { sequence: number }): Promise<void> {
    const tile = this.tile(record);
    if (tile.sequence > record.sequence) return;
    tile.sequence = record.sequence;
    if (tile.jpeg === null) ++this.count;
    this.store.drop(tile.jpeg);
    this.store.drop(tile.mask);
    tile.jpeg = this.store.keep(record.jpeg);
    tile.mask = record.mask === null ? null : this.store.keep(record.mask);
    if (tile.mesh !== null) await this.renew(tile);
  }

  /** Rejects when a picture cannot be decoded. */
  async setOverview(record: MosaicOverview & { sequence: number }): Promise<void> {
    const overview = this.overview(record);
    if (overview.sequence > record.sequence) return;
    overview.sequence = record.sequence;
    this.store.drop(overview.jpeg);
    this.store.drop(overview.mask);
    overview.jpeg = this.store.keep(record.jpeg);
    overview.mask = record.mask === null ? null : this.store.keep(record.mask);
    await this.paint(overview, overview.isFine);
  }

  /** Shows in full what is large on the screen; resolves when something has changed. */
  async refine(sizeOf: SizeOf): Promise<boolean> {
    const changed = await Promise.all([this.refineTiles(sizeOf), this.refineOverviews(sizeOf)]);
    return changed.includes(true);
  }

  private async refineTiles(sizeOf: SizeOf): Promise<boolean> {
    const wanted = this.largest([...this.tiles.values()], 1, LARGE_PX, MOST_FULL, sizeOf);
    const missing = [...wanted].filter((tile) => tile.mesh === null && !tile.busy && tile.broken !== tile.jpeg).slice(0, AT_ONCE);
    const spare = [...this.tiles.values()].filter((tile) => tile.mesh !== null && !wanted.has(tile));
    const tooMany = this.full.children.length + missing.length - MOST_FULL;
    for (const tile of spare.slice(0, Math.max(0, tooMany))) this.reduce(tile);
    await Promise.all(missing.map((tile) => this.enlarge(tile)));
    return missing.length > 0;
  }

  /** Those that are wider on the screen than least px, the widest if they are too many; side: tiles. */
  private largest<T extends Place & { jpeg: Kept | null }>(all: T[], side: number, least: number, most: number, sizeOf: SizeOf): Set<T> {
    const sized = all.flatMap((one) => {
      const grid = this.grids.get(one.mosaic);
      if (grid === undefined || one.jpeg === null) return [];
      const size = sizeOf(this.centreOf(grid, one, side), side * TILE_SIZE * grid.groundSamplingDistance);
      return size > least ? [{ one, size }] : [];
    });
    sized.sort((one, other) => other.size - one.size);
    return new Set(sized.slice(0, most).map(({ one }) => one));
  }

  private async refineOverviews(sizeOf: SizeOf): Promise<boolean> {
    const wanted = this.largest([...this.overviews.values()], OVERVIEW_TILES, FINE_PX, MOST_FINE, sizeOf);
    const canBePainted = ({ busy, broken, jpeg }: Overview) => !busy && broken !== jpeg;
    const missing = [...wanted].filter((overview) => !overview.isFine && canBePainted(overview)).slice(0, AT_ONCE);
    const fine = [...this.overviews.values()].filter(({ isFine }) => isFine);
    const spare = fine.filter((overview) => !wanted.has(overview) && canBePainted(overview));
    const tooMany = spare.slice(0, Math.max(0, fine.length + missing.length - MOST_FINE));
    const paint = async (overview: Overview, isFine: boolean) => this.paint(overview, isFine).catch(() => (overview.broken = overview.jpeg));
    await Promise.all([...missing.map((overview) => paint(overview, true)), ...tooMany.map((overview) => paint(overview, false))]);
    return missing.length > 0;
  }

  /** Survey corners of a tile; none before its mosaic is known. */
  cornersOf({ mosaic, column, row }: Place): Vec3[] {
    const grid = this.grids.get(mosaic);
    return grid === undefined ? [] : tileCorners(grid, column, row);
  }

  /** Survey corners of all the tiles of one mosaic. */
  *corners(mosaic: number): Iterable<Vec3> {
    for (const tile of this.tiles.values()) if (tile.jpeg !== null && tile.mosaic === mosaic) yield* this.cornersOf(tile);
  }

  /** Where the ray meets a mosaic's tile, the newest mosaic first; null where there is none. */
  meet({ from, direction }: Ray): Vec3 | null {
    for (const grid of [...this.grids.values()].sort((one, other) => other.mosaic - one.mosaic)) {
      const along = (grid.offset - dot(grid.normal, from)) / dot(grid.normal, direction);
      if (!(along > 0)) continue;
      const at = (k: 0 | 1 | 2) => from[k] + along * direction[k];
      const { a, d, b, e, c, f } = grid.world;
      const determinant = a * e - b * d;
      const [x, y] = [at(0) - c, at(1) - f];
      const column = Math.floor(((e * x - b * y) / determinant + 0.5) / TILE_SIZE);
      const row = Math.floor(((a * y - d * x) / determinant + 0.5) / TILE_SIZE);
      if (this.tiles.get(keyOf({ mosaic: grid.mosaic, column, row }))?.jpeg) return [at(0), at(1), at(2)];
    }
    return null;
  }

  clear(): void {
    for (const tile of this.tiles.values()) {
      tile.jpeg = null;
      if (tile.mesh !== null) dispose(tile.mesh);
    }
    for (const overview of this.overviews.values()) {
      overview.jpeg = null;
      overview.dispose();
    }
    this.full.clear();
    this.far.clear();
    this.tiles = new Map();
    this.overviews = new Map();
    this.store = new Store();
    this.grids.clear();
    this.count = 0;
  }

  private tile({ mosaic, column, row }: MosaicTile): Tile {
    const key = keyOf({ mosaic, column, row });
    let tile = this.tiles.get(key);
    if (tile === undefined) {
      tile = { mosaic, column, row, jpeg: null, mask: null, sequence: -1, mesh: null, busy: false, broken: null };
      this.tiles.set(key, tile);
    }
    return tile;
  }

  private overview({ mosaic, column, row }: Place): Overview {
    const key = keyOf({ mosaic, column, row });
    let overview = this.overviews.get(key);
    if (overview === undefined) {
      overview = new Overview(mosaic, column, row, orderOf(mosaic));
      this.overviews.set(key, overview);
      this.far.add(overview.mesh);
      this.placeOverview(overview);
    }
    return overview;
  }

  /** Rejects when it cannot be unpacked. */
  private async paint(overview: Overview, isFine: boolean): Promise<void> {
    const { jpeg } = overview;
    overview.busy = true;
    const picture = await bitmapOf(overview, isFine ? "own" : { width: SMALL, height: SMALL }).finally(() => (overview.busy = false));
    if (overview.jpeg === jpeg && this.overviews.get(keyOf(overview)) === overview) {
      overview.paint(textureOf(picture), isFine);
      this.placeOverview(overview);
    } else picture.close();
  }

  private overviewOf({ mosaic, column, row }: Tile): Overview {
    return this.overview({ mosaic, column: Math.floor(column / OVERVIEW_TILES), row: Math.floor(row / OVERVIEW_TILES) });
  }

  /** The picture of a tile that is shown in full. */
  private async renew(tile: Tile): Promise<void> {
    const { jpeg } = tile;
    const picture = await bitmapOf(tile, "own");
    if (tile.jpeg === jpeg && tile.mesh !== null) dress(tile.mesh, picture);
    else picture.close();
  }

  private async enlarge(tile: Tile): Promise<void> {
    const { jpeg } = tile;
    tile.busy = true;
    const picture = await bitmapOf(tile, "own").catch(() => null);
    tile.busy = false;
    if (picture === null) {
      tile.broken = jpeg;
    } else if (tile.jpeg === jpeg && tile.mesh === null) {
      tile.mesh = newMesh(tile.mosaic);
      dress(tile.mesh, picture);
      this.full.add(tile.mesh);
      this.overviewOf(tile).setHole(tile.column, tile.row, true);
      this.place(tile);
    } else picture.close();
  }

  private reduce(tile: Tile): void {
    if (tile.mesh === null) return;
    dispose(tile.mesh);
    this.full.remove(tile.mesh);
    tile.mesh = null;
    this.overviewOf(tile).setHole(tile.column, tile.row, false);
  }

  private place(tile: Tile): void {
    const grid = this.grids.get(tile.mosaic);
    if (grid === undefined || tile.mesh === null) return;
    const corners = tileCorners(grid, tile.column, tile.row).map((corner) => this.origin.toScene(corner));
    tile.mesh.geometry.setAttribute("position", new Float32BufferAttribute(corners.flat(), 3));
    tile.mesh.geometry.computeBoundingSphere();
  }

  private placeOverview(overview: Overview): void {
    const grid = this.grids.get(overview.mosaic);
    if (grid === undefined) return;
    overview.place(tileCorners(grid, overview.column, overview.row, OVERVIEW_TILES).map((corner) => this.origin.toScene(corner)));
  }

  private centreOf(grid: Mosaic, { column, row }: Place, side: number): Vector3 {
    const corners = tileCorners(grid, column, row, side).map((corner) => this.origin.toScene(corner));
    return corners.reduce((sum, corner) => sum.add(new Vector3(...corner)), new Vector3()).divideScalar(4);
  }
}

function keyOf({ mosaic, column, row }: Place): string {
  return `${mosaic}/${column}/${row}`;
}

/** Upper left, upper right, lower left, lower right, of a square of so many tiles; survey. */
export function tileCorners(grid: Mosaic, column: number, row: number, side = 1): Vec3[] {
  const { a, d, b, e, c, f } = grid.world;
  const [nx, ny, nz] = grid.normal;
  return [0, 1].flatMap((down) =>
    [0, 1].map((right): Vec3 => {
      const px = TILE_SIZE * side * (column + right) - 0.5;
      const py = TILE_SIZE * side * (row + down) - 0.5;
      const x = a * px + b * py + c;
      const y = d * px + e * py + f;
      return [x, y, (grid.offset - nx * x - ny * y) / nz];
    }),
  );
}

function dot(one: Vec3, other: Vec3): number {
  return one[0] * other[0] + one[1] * other[1] + one[2] * other[2];
}

function newMesh(mosaic: number): Mesh<BufferGeometry, MeshBasicMaterial> {
  const geometry = new BufferGeometry();
  geometry.setAttribute("uv", new Float32BufferAttribute([0, 0, 1, 0, 0, 1, 1, 1], 2));
  geometry.setIndex([0, 2, 1, 1, 2, 3]);
  const material = new MeshBasicMaterial({
    side: DoubleSide,
    transparent: true,
    // Its picture is multiplied by alpha already; premultipliedAlpha would do so again.
    blending: CustomBlending,
    blendSrc: OneFactor,
    blendDst: OneMinusSrcAlphaFactor,
    depthWrite: false,
    toneMapped: false,
  });
  const mesh = new Mesh(geometry, material);
  mesh.renderOrder = orderOf(mosaic);
  return mesh;
}

/** The ground lies below all else, a newer mosaic above an older one. */
function orderOf(mosaic: number): number {
  return mosaic - 1e6;
}

function dispose(mesh: Mesh<BufferGeometry, MeshBasicMaterial>): void {
  mesh.material.map?.dispose();
  mesh.material.dispose();
  mesh.geometry.dispose();
}

function dress(mesh: Mesh<BufferGeometry, MeshBasicMaterial>, picture: ImageBitmap): void {
  mesh.material.map?.dispose();
  mesh.material.map = textureOf(picture);
  mesh.material.needsUpdate = true;
}

/** Takes the picture, which is kept as long: a graphics card may forget all it had. */
function textureOf(picture: ImageBitmap): Texture {
  const texture = new Texture(picture);
  texture.addEventListener("dispose", () => { picture.close(); });
  texture.needsUpdate = true;
  texture.flipY = false;
  texture.anisotropy = 4;
  texture.minFilter = LinearMipmapLinearFilter;
  return texture;
}

/** Its colours, transparent where nothing was seen. */
async function bitmapOf({ jpeg, mask }: Pick<Tile, "jpeg" | "mask">, size: Size | "own"): Promise<ImageBitmap> {
  const { bitmap } = jpeg === null ? { bitmap: null } : await unpack(jpeg.bytes, mask?.bytes ?? null, [], size);
  if (bitmap === null) throw new Error("a picture without colours");
  return bitmap;
}
