// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A cloud is a matrix and a small picture; many are drawn at once, as instances whose pictures are the layers of one
// array texture. The graphics card itself makes the points, or the quad: its corners are handed over homogeneous, so
// that it interpolates them in perspective.
import {
  DataArrayTexture,
  DoubleSide,
  InstancedBufferAttribute,
  InstancedBufferGeometry,
  LinearFilter,
  Mesh,
  Points,
  ShaderMaterial,
} from "three";
import type { PlaneGrid } from "../wire/records";
import type { Origin } from "./origin";

/** Planes that share a texture and a draw call. */
const CHUNK = 64;
const NOWHERE = -1;

const COMMON = `
  attribute vec4 perColumn;
  attribute vec4 perRow;
  attribute vec4 atZero;
  attribute vec4 cameraAndRange;
  attribute float layer;
  uniform ivec2 cells;
  varying vec4 place;
  flat varying vec4 seenFrom;
  // A layer below 0 is a place that nobody has.
  void setPlace(vec2 cell) {
    place = perColumn * cell.x + perRow * cell.y + atZero;
    seenFrom = cameraAndRange;
    gl_Position = layer < 0.0 ? vec4(2.0, 2.0, 2.0, 1.0) : projectionMatrix * viewMatrix * place;
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
  uniform int cellsPerTexel;
  uniform ivec2 texels;
  uniform float size;
  varying vec3 shade;
  void main() {
    int across = (texels.x + stride - 1) / stride;
    ivec2 texel = ivec2(gl_VertexID % across, gl_VertexID / across) * stride;
    shade = texelFetch(colours, ivec3(texel, max(int(layer), 0)), 0).rgb;
    setPlace((vec2(texel) + 0.5) * float(cellsPerTexel) - 0.5);
    if (place.w <= 0.0 || distance(place.xyz / place.w, seenFrom.xyz) > seenFrom.w) {
      gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    }
    gl_PointSize = size;
  }`;
const POINT_FRAGMENT = `
  varying vec3 shade;
  void main() { gl_FragColor = vec4(shade, 1.0); }`;

/** Up to CHUNK planes of one grid size, with a picture of every so many cells. */
export class Chunk {
  readonly quads: Mesh<InstancedBufferGeometry, ShaderMaterial>;
  readonly points: Points<InstancedBufferGeometry, ShaderMaterial>;
  /** Size of a plane's picture. */
  readonly width: number;
  readonly height: number;
  private free = Array.from({ length: CHUNK }, (_, i) => CHUNK - 1 - i);
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
    readonly cellsPerTexel: number,
  ) {
    this.width = Math.ceil(columns / cellsPerTexel);
    this.height = Math.ceil(rows / cellsPerTexel);
    this.attributes.layer.array.fill(NOWHERE);
    this.texture = new DataArrayTexture(new Uint8Array(4 * this.width * this.height * CHUNK), this.width, this.height, CHUNK);
    this.texture.minFilter = this.texture.magFilter = LinearFilter;
    this.texture.needsUpdate = true;
    const uniforms = {
      colours: { value: this.texture },
      cells: { value: [columns, rows] },
      texels: { value: [this.width, this.height] },
      cellsPerTexel: { value: cellsPerTexel },
      stride: { value: 1 },
      size: { value: 2 },
    };
    this.quads = new Mesh(
      this.geometry(6),
      new ShaderMaterial({ vertexShader: QUAD_VERTEX, fragmentShader: QUAD_FRAGMENT, uniforms, side: DoubleSide }),
    );
    this.quads.geometry.setIndex([0, 1, 2, 2, 1, 3]);
    this.points = new Points(
      this.geometry(this.width * this.height),
      new ShaderMaterial({ vertexShader: POINT_VERTEX, fragmentShader: POINT_FRAGMENT, uniforms }),
    );
    this.quads.frustumCulled = this.points.frustumCulled = false;
  }

  get used(): number {
    return CHUNK - this.free.length;
  }

  /** Points of all its planes. */
  get size(): number {
    return this.used * this.width * this.height;
  }

  get isFull(): boolean {
    return this.free.length === 0;
  }

  /** A place for a plane, which must not be full; not shown before it has a grid. */
  take(): number {
    return this.free.pop() ?? 0;
  }

  release(index: number): void {
    this.hide(index);
    this.free.push(index);
  }

  hide(index: number): void {
    this.setLayer(index, NOWHERE);
  }

  /** width x height RGBA. */
  setColours(index: number, rgba: Uint8ClampedArray): void {
    (this.texture.image.data as Uint8Array).set(rgba, index * rgba.length);
    this.texture.addLayerUpdate(index);
    this.texture.needsUpdate = true;
  }

  show(index: number, grid: PlaneGrid, origin: Origin): void {
    const h = inScene(grid, origin);
    const { perColumn, perRow, atZero, cameraAndRange } = this.attributes;
    [perColumn, perRow, atZero].forEach((attribute, column) => {
      attribute.set([0, 1, 2, 3].map((row) => h[3 * row + column] ?? 0), 4 * index);
      attribute.needsUpdate = true;
    });
    cameraAndRange.set([...origin.toScene(grid.camera), grid.maxRange], 4 * index);
    cameraAndRange.needsUpdate = true;
    this.setLayer(index, index);
  }

  /** Leaves out all but every so many points in each direction. */
  setStride(stride: number): void {
    this.points.material.uniforms["stride"] = { value: stride };
    this.points.geometry.setDrawRange(0, Math.ceil(this.width / stride) * Math.ceil(this.height / stride));
  }

  dispose(): void {
    this.texture.dispose();
    for (const object of [this.quads, this.points]) {
      object.geometry.dispose();
      object.material.dispose();
    }
  }

  private setLayer(index: number, layer: number): void {
    this.attributes.layer.set([layer], index);
    this.attributes.layer.needsUpdate = true;
  }

  private geometry(vertices: number): InstancedBufferGeometry {
    const geometry = new InstancedBufferGeometry();
    for (const [name, attribute] of Object.entries(this.attributes)) geometry.setAttribute(name, attribute);
    geometry.setDrawRange(0, vertices);
    geometry.instanceCount = CHUNK;
    return geometry;
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

function instanced(itemSize: number): InstancedBufferAttribute {
  return new InstancedBufferAttribute(new Float32Array(CHUNK * itemSize), itemSize);
}
