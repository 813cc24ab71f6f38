// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import {
  BufferGeometry,
  CanvasTexture,
  DoubleSide,
  Float32BufferAttribute,
  Group,
  LinearMipmapLinearFilter,
  Mesh,
  MeshBasicMaterial,
  Texture,
} from "three";
import { TILE_SIZE, type Mosaic, type MosaicTile, type Vec3 } from "../wire/records";
import { decodeImage, pixels } from "./images";
import type { Ray } from "./ground";
import type { Origin } from "./origin";

interface Tile {
  mosaic: number;
  column: number;
  row: number;
  mesh: Mesh<BufferGeometry, MeshBasicMaterial> | null;
  /** Sequence of the newest colours asked for. */
  wanted: number;
}

/** The 2D mosaics (2DSIM), tile by tile on their planes. */
export class Mosaics {
  readonly object = new Group();
  /** Tiles with colours. */
  count = 0;
  readonly grids = new Map<number, Mosaic>();
  private tiles = new Map<string, Tile>();

  constructor(private readonly origin: Origin) {}

  setMosaic(mosaic: Mosaic): void {
    this.grids.set(mosaic.mosaic, mosaic);
    for (const tile of this.tiles.values()) {
      if (tile.mosaic === mosaic.mosaic) this.place(tile);
    }
  }

  /** Rejects when a picture cannot be decoded. */
  async setTile(record: MosaicTile & { sequence: number }): Promise<void> {
    const tile = this.tile(record);
    if (tile.wanted > record.sequence) return;
    tile.wanted = record.sequence;
    const texture = await tileTexture(record);
    if (tile.wanted === record.sequence) this.paint(tile, texture);
    else texture.dispose();
  }

  /** Survey corners of all the tiles of one mosaic, or of every one. */
  *corners(mosaic?: number): Iterable<Vec3> {
    for (const tile of this.tiles.values()) {
      const grid = this.grids.get(tile.mosaic);
      if (grid === undefined || tile.mesh === null || (mosaic ?? tile.mosaic) !== tile.mosaic) continue;
      yield* tileCorners(grid, tile.column, tile.row);
    }
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
      if (this.tiles.get(`${grid.mosaic}/${column}/${row}`)?.mesh) return [at(0), at(1), at(2)];
    }
    return null;
  }

  clear(): void {
    for (const tile of this.tiles.values()) {
      tile.wanted = Infinity;
      if (tile.mesh !== null) dispose(tile.mesh);
    }
    this.object.clear();
    this.tiles = new Map();
    this.grids.clear();
    this.count = 0;
  }

  private tile({ mosaic, column, row }: MosaicTile): Tile {
    const key = `${mosaic}/${column}/${row}`;
    let tile = this.tiles.get(key);
    if (tile === undefined) {
      tile = { mosaic, column, row, mesh: null, wanted: -1 };
      this.tiles.set(key, tile);
    }
    return tile;
  }

  private paint(tile: Tile, texture: Texture): void {
    if (tile.mesh === null) {
      tile.mesh = newMesh(tile.mosaic);
      ++this.count;
      this.place(tile);
    }
    tile.mesh.material.map?.dispose();
    tile.mesh.material.map = texture;
    tile.mesh.material.needsUpdate = true;
  }

  private place(tile: Tile): void {
    const grid = this.grids.get(tile.mosaic);
    if (grid === undefined || tile.mesh === null) return;
    const corners = tileCorners(grid, tile.column, tile.row).flatMap((corner) => this.origin.toScene(corner));
    tile.mesh.geometry.setAttribute("position", new Float32BufferAttribute(corners, 3));
    tile.mesh.geometry.computeBoundingSphere();
    this.object.add(tile.mesh);
  }
}

/** Upper left, upper right, lower left, lower right; survey. */
export function tileCorners(grid: Mosaic, column: number, row: number): Vec3[] {
  const { a, d, b, e, c, f } = grid.world;
  const [nx, ny, nz] = grid.normal;
  return [0, 1].flatMap((down) =>
    [0, 1].map((right): Vec3 => {
      const px = TILE_SIZE * (column + right) - 0.5;
      const py = TILE_SIZE * (row + down) - 0.5;
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
    premultipliedAlpha: true,
    depthWrite: false,
    toneMapped: false,
  });
  const mesh = new Mesh(geometry, material);
  mesh.renderOrder = mosaic - 1e6; // the ground lies below all else, a newer mosaic above an older one
  return mesh;
}

function dispose(mesh: Mesh<BufferGeometry, MeshBasicMaterial>): void {
  mesh.material.map?.dispose();
  mesh.material.dispose();
  mesh.geometry.dispose();
}

async function tileTexture({ jpeg, mask }: MosaicTile): Promise<Texture> {
  const colour = decodeImage(new Uint8Array(jpeg), "image/jpeg");
  const texture = mask === null ? new Texture(await colour) : await masked(await colour, mask);
  texture.flipY = false;
  texture.anisotropy = 4;
  texture.minFilter = LinearMipmapLinearFilter;
  texture.premultiplyAlpha = true;
  texture.needsUpdate = true;
  return texture;
}

async function masked(colour: ImageBitmap, mask: Uint8Array): Promise<Texture> {
  const alpha = pixels(await decodeImage(new Uint8Array(mask), "image/png"));
  const image = pixels(colour);
  if (alpha.data.length !== image.data.length) throw new Error("the mask is not of the tile's size");
  for (let i = 0; i < image.data.length; i += 4) image.data[i + 3] = alpha.data[i] ?? 0;
  const canvas = new OffscreenCanvas(image.width, image.height);
  canvas.getContext("2d")?.putImageData(image, 0, 0);
  return new CanvasTexture(canvas);
}
