// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// How often the ground was seen, over the mosaic: what is missing stands out.
import { BufferGeometry, CanvasTexture, DoubleSide, Float32BufferAttribute, Group, Mesh, MeshBasicMaterial, NearestFilter } from "three";
import { COVERAGE_CELLS, type CoverageTile, type Vec3 } from "../wire/records";
import { unpack } from "./images";
import type { Origin } from "./origin";

/** Red, green, blue, alpha of a gap and of one, two, three and more views; safe for the colour-blind, and told apart by
 *  their lightness alone in blue light. A gap is striped besides. */
export const COVERAGE_COLOURS = [
  [255, 106, 61, 235],
  [255, 225, 77, 130],
  [86, 200, 240, 80],
  [46, 92, 190, 50],
] as const;
const WANTED = 128;
const STRIPE_CELLS = 4;

interface Tile {
  mesh: Mesh<BufferGeometry, MeshBasicMaterial>;
  record: CoverageTile;
}

export class Coverage {
  readonly object = new Group();
  /** Cells that are to be covered and were not seen. */
  gaps = 0;
  /** Survey height at which the layer lies. */
  private height = 0;
  private tiles = new Map<string, Tile>();
  private gapsOf = new Map<string, number>();
  /** Sequence of the newest counts asked for. */
  private wanted = new Map<string, number>();

  constructor(private readonly origin: Origin) {}

  /** Rejects when the picture cannot be decoded. */
  async setTile(record: CoverageTile & { sequence: number }): Promise<void> {
    const key = `${record.column}/${record.row}`;
    if ((this.wanted.get(key) ?? -1) > record.sequence) return;
    this.wanted.set(key, record.sequence);
    const unpacked = await unpack(record.png, null, [null]);
    const pixels = unpacked.pixels[0];
    if (this.wanted.get(key) !== record.sequence) return;
    if (pixels === undefined || unpacked.width !== COVERAGE_CELLS || unpacked.height !== COVERAGE_CELLS) throw new Error("not a coverage tile");
    const counts = new ImageData(pixels, COVERAGE_CELLS);
    const gaps = colour(counts);
    this.gaps += gaps - (this.gapsOf.get(key) ?? 0);
    this.gapsOf.set(key, gaps);
    this.paint(key, record, counts);
  }

  setHeight(height: number): void {
    if (Math.abs(height - this.height) < 1e-3) return;
    this.height = height;
    for (const tile of this.tiles.values()) this.place(tile);
  }

  clear(): void {
    for (const { mesh } of this.tiles.values()) {
      mesh.material.map?.dispose();
      mesh.material.dispose();
      mesh.geometry.dispose();
    }
    this.object.clear();
    this.tiles = new Map();
    this.wanted = new Map();
    this.gapsOf = new Map();
    this.gaps = 0;
  }

  private paint(key: string, record: CoverageTile, counts: ImageData): void {
    const canvas = new OffscreenCanvas(counts.width, counts.height);
    canvas.getContext("2d")?.putImageData(counts, 0, 0);
    const texture = new CanvasTexture(canvas);
    texture.flipY = false;
    texture.magFilter = NearestFilter;
    texture.generateMipmaps = false;
    texture.minFilter = NearestFilter;
    let tile = this.tiles.get(key);
    if (tile === undefined) {
      tile = { mesh: newMesh(), record };
      this.tiles.set(key, tile);
      this.object.add(tile.mesh);
    }
    tile.record = record;
    this.place(tile);
    tile.mesh.material.map?.dispose();
    tile.mesh.material.map = texture;
    tile.mesh.material.needsUpdate = true;
  }

  private place({ mesh, record }: Tile): void {
    const side = COVERAGE_CELLS * record.cell;
    const [left, top] = [side * record.column, -side * record.row];
    const corner = (x: number, y: number): Vec3 => this.origin.toScene([left + x * side, top - y * side, this.height]);
    const corners = [corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1)].flat();
    mesh.geometry.setAttribute("position", new Float32BufferAttribute(corners, 3));
    mesh.geometry.computeBoundingSphere();
  }
}

/** Turns counts into colours; how many cells are gaps. */
export function colour({ data, width }: ImageData): number {
  let gaps = 0;
  for (let i = 0; i < data.length; i += 4) {
    const value = data[i] ?? 0;
    const views = value % WANTED;
    const [column, row] = [(i / 4) % width, Math.floor(i / 4 / width)];
    const isGap = value === WANTED;
    if (isGap) ++gaps;
    const shade = COVERAGE_COLOURS[Math.min(views, 3)] ?? COVERAGE_COLOURS[0];
    data.set(shade, i);
    if (value === 0) data[i + 3] = 0;
    else if (isGap && (column + row) % STRIPE_CELLS >= STRIPE_CELLS / 2) data[i + 3] = 110;
  }
  return gaps;
}

function newMesh(): Mesh<BufferGeometry, MeshBasicMaterial> {
  const geometry = new BufferGeometry();
  geometry.setAttribute("uv", new Float32BufferAttribute([0, 0, 1, 0, 0, 1, 1, 1], 2));
  geometry.setIndex([0, 2, 1, 1, 2, 3]);
  const mesh = new Mesh(
    geometry,
    new MeshBasicMaterial({ side: DoubleSide, transparent: true, depthWrite: false, depthTest: false, toneMapped: false }),
  );
  mesh.renderOrder = 5;
  return mesh;
}
