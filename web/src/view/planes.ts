// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The planar clouds (3DSIP). A cloud is a matrix and a small picture; hundreds of them are drawn at once, as
// instances whose pictures are the layers of one array texture. The graphics card itself makes the points, or
// the quad: its corners are handed over homogeneous, so that it interpolates them in perspective.
import {
  DataArrayTexture,
  DoubleSide,
  Group,
  InstancedBufferAttribute,
  InstancedBufferGeometry,
  LinearFilter,
  Mesh,
  Points,
  ShaderMaterial,
} from "three";
import type { PlaneColour, PlaneGrid, Vec3 } from "../wire/records";
import { decodeImage, pixels } from "./images";
import type { Origin } from "./origin";

export type PlaneStyle = "quads" | "points";

/** Planes that share a texture and a draw call. */
const CHUNK = 64;
/** Beyond so many points every second row and column is left out, and so on. */
const MAX_POINTS = 1_500_000;

const COMMON = `
  attribute vec4 perColumn;
  attribute vec4 perRow;
  attribute vec4 atZero;
  attribute vec4 cameraAndRange;
  attribute float layer;
  uniform ivec2 cells;
  varying vec4 place;
  flat varying vec4 seenFrom;
  void setPlace(vec2 cell) {
    place = perColumn * cell.x + perRow * cell.y + atZero;
    seenFrom = cameraAndRange;
    gl_Position = projectionMatrix * viewMatrix * place;
  }`;
const QUAD_VERTEX = `${COMMON}
  varying vec3 texel;
  void main() {
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
    texel = vec3(corner, layer);
    setPlace(corner * vec2(cells) - 0.5);
  }`;
const QUAD_FRAGMENT = `
  precision highp sampler2DArray;
  uniform sampler2DArray colours;
  varying vec4 place;
  flat varying vec4 seenFrom;
  varying vec3 texel;
  void main() {
    if (place.w <= 0.0 || distance(place.xyz / place.w, seenFrom.xyz) > seenFrom.w) discard;
    gl_FragColor = vec4(texture(colours, texel).rgb, 1.0);
  }`;
const POINT_VERTEX = `${COMMON}
  precision highp sampler2DArray;
  uniform sampler2DArray colours;
  uniform int stride;
  uniform float size;
  varying vec3 shade;
  void main() {
    int across = (cells.x + stride - 1) / stride;
    ivec2 cell = ivec2(gl_VertexID % across, gl_VertexID / across) * stride;
    shade = texelFetch(colours, ivec3(cell, int(layer)), 0).rgb;
    setPlace(vec2(cell));
    if (place.w <= 0.0 || distance(place.xyz / place.w, seenFrom.xyz) > seenFrom.w) {
      gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    }
    gl_PointSize = size;
  }`;
const POINT_FRAGMENT = `
  varying vec3 shade;
  void main() { gl_FragColor = vec4(shade, 1.0); }`;

/** Up to CHUNK planes of one grid size. */
class Chunk {
  readonly quads: Mesh<InstancedBufferGeometry, ShaderMaterial>;
  readonly points: Points<InstancedBufferGeometry, ShaderMaterial>;
  count = 0;
  private readonly texture: DataArrayTexture;
  private readonly attributes = {
    perColumn: instanced(4),
    perRow: instanced(4),
    atZero: instanced(4),
    cameraAndRange: instanced(4),
    layer: instanced(1),
  };

  constructor(
    readonly columns: number,
    readonly rows: number,
  ) {
    this.texture = new DataArrayTexture(new Uint8Array(4 * columns * rows * CHUNK), columns, rows, CHUNK);
    this.texture.minFilter = this.texture.magFilter = LinearFilter;
    this.texture.needsUpdate = true;
    const uniforms = {
      colours: { value: this.texture },
      cells: { value: [columns, rows] },
      stride: { value: 1 },
      size: { value: 2 },
    };
    this.quads = new Mesh(
      this.geometry(6),
      new ShaderMaterial({ vertexShader: QUAD_VERTEX, fragmentShader: QUAD_FRAGMENT, uniforms, side: DoubleSide }),
    );
    this.quads.geometry.setIndex([0, 1, 2, 2, 1, 3]);
    this.points = new Points(
      this.geometry(columns * rows),
      new ShaderMaterial({ vertexShader: POINT_VERTEX, fragmentShader: POINT_FRAGMENT, uniforms }),
    );
    this.quads.frustumCulled = this.points.frustumCulled = false;
  }

  setColours(index: number, rgba: Uint8ClampedArray): void {
    (this.texture.image.data as Uint8Array).set(rgba, index * rgba.length);
    this.texture.addLayerUpdate(index);
    this.texture.needsUpdate = true;
  }

  setGrid(index: number, grid: PlaneGrid, origin: Origin): void {
    const h = inScene(grid, origin);
    const { perColumn, perRow, atZero, cameraAndRange, layer } = this.attributes;
    [perColumn, perRow, atZero].forEach((attribute, column) => {
      attribute.set([0, 1, 2, 3].map((row) => h[3 * row + column] ?? 0), 4 * index);
    });
    cameraAndRange.set([...origin.toScene(grid.camera), grid.maxRange], 4 * index);
    layer.set([index], index);
    for (const attribute of Object.values(this.attributes)) attribute.needsUpdate = true;
  }

  append(): number {
    const index = this.count++;
    this.quads.geometry.instanceCount = this.points.geometry.instanceCount = this.count;
    return index;
  }

  setStride(stride: number): void {
    this.points.material.uniforms["stride"] = { value: stride };
    this.points.geometry.setDrawRange(0, Math.ceil(this.columns / stride) * Math.ceil(this.rows / stride));
  }

  dispose(): void {
    this.texture.dispose();
    for (const object of [this.quads, this.points]) {
      object.geometry.dispose();
      object.material.dispose();
    }
  }

  private geometry(vertices: number): InstancedBufferGeometry {
    const geometry = new InstancedBufferGeometry();
    for (const [name, attribute] of Object.entries(this.attributes)) geometry.setAttribute(name, attribute);
    geometry.setDrawRange(0, vertices);
    geometry.instanceCount = 0;
    return geometry;
  }
}

interface Plane {
  grid?: PlaneGrid;
  rgba?: Uint8ClampedArray | undefined;
  size?: string;
  /** Sequence of the newest colours asked for. */
  wanted: number;
  place?: { chunk: Chunk; index: number };
}

export class Planes {
  readonly object = new Group();
  /** Planes with geometry and colours. */
  count = 0;
  private planes = new Map<number, Plane>();
  private chunks: Chunk[] = [];
  private style: PlaneStyle = "quads";
  private coarseness = 1;

  constructor(private readonly origin: Origin) {}

  setGrid(grid: PlaneGrid): void {
    const plane = this.plane(grid.image);
    plane.grid = grid;
    this.show(plane);
  }

  /** Rejects when the picture cannot be decoded. */
  async setColour(colour: PlaneColour & { sequence: number }): Promise<void> {
    const plane = this.plane(colour.image);
    if (plane.wanted > colour.sequence) return;
    plane.wanted = colour.sequence;
    const bitmap = await decodeImage(new Uint8Array(colour.jpeg), "image/jpeg");
    if (plane.wanted !== colour.sequence) return;
    const image = pixels(bitmap);
    plane.rgba = image.data;
    plane.size = `${image.width}x${image.height}`;
    this.show(plane);
  }

  setStyle(style: PlaneStyle): void {
    this.style = style;
    this.chunks.forEach((chunk) => {
      this.dress(chunk);
    });
  }

  /** Draws only every so many points in each direction. */
  setCoarseness(coarseness: number): void {
    this.coarseness = coarseness;
    this.setStrides();
  }

  clear(): void {
    this.chunks.forEach((chunk) => {
      this.object.remove(chunk.quads, chunk.points);
      chunk.dispose();
    });
    this.chunks = [];
    this.planes.forEach((plane) => (plane.wanted = Infinity));
    this.planes = new Map();
    this.count = 0;
  }

  private plane(image: number): Plane {
    let plane = this.planes.get(image);
    if (plane === undefined) {
      plane = { wanted: -1 };
      this.planes.set(image, plane);
    }
    return plane;
  }

  private show(plane: Plane): void {
    const { grid, rgba } = plane;
    if (grid === undefined) return;
    if (rgba !== undefined && plane.size === `${grid.columns}x${grid.rows}`) {
      plane.place ??= this.newPlace(grid);
      plane.place.chunk.setColours(plane.place.index, rgba);
      plane.rgba = undefined;
    }
    plane.place?.chunk.setGrid(plane.place.index, grid, this.origin);
  }

  private newPlace(grid: PlaneGrid): { chunk: Chunk; index: number } {
    ++this.count;
    const { columns, rows } = grid;
    let chunk = this.chunks.find((one) => one.columns === columns && one.rows === rows && one.count < CHUNK);
    if (chunk === undefined) {
      chunk = new Chunk(columns, rows);
      this.chunks.push(chunk);
      this.object.add(chunk.quads, chunk.points);
    }
    this.setStrides();
    this.dress(chunk);
    return { chunk, index: chunk.append() };
  }

  private setStrides(): void {
    const points = this.chunks.reduce((sum, chunk) => sum + chunk.count * chunk.columns * chunk.rows, 0);
    const least = Math.ceil(Math.sqrt(points / MAX_POINTS));
    this.chunks.forEach((chunk) => {
      chunk.setStride(Math.max(1, least, this.coarseness));
    });
  }

  private dress(chunk: Chunk): void {
    chunk.quads.visible = this.style === "quads";
    chunk.points.visible = this.style === "points";
  }
}

/** H of the scene's coordinates: each column's x y z less the origin times its w. */
export function inScene(grid: PlaneGrid, origin: Origin): number[] {
  origin.toScene(grid.camera);
  return Array.from(grid.surveyFromGrid, (value, at) => {
    const w = grid.surveyFromGrid[9 + (at % 3)] ?? 0;
    return at < 9 ? value - (origin.point[Math.floor(at / 3)] ?? 0) * w : value;
  });
}

/** Survey point of a grid's cell; null where the grid has none. */
export function pointOf(grid: PlaneGrid, column: number, row: number): Vec3 | null {
  const h = (i: number) =>
    (grid.surveyFromGrid[3 * i] ?? 0) * column + (grid.surveyFromGrid[3 * i + 1] ?? 0) * row + (grid.surveyFromGrid[3 * i + 2] ?? 0);
  const w = h(3);
  return w > 0 ? [h(0) / w, h(1) / w, h(2) / w] : null;
}

function instanced(itemSize: number): InstancedBufferAttribute {
  return new InstancedBufferAttribute(new Float32Array(CHUNK * itemSize), itemSize);
}
