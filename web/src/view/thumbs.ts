// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A mosaic's tiles from afar: a small picture of each, all of them in few draw calls.
import {
  CustomBlending,
  DataArrayTexture,
  DoubleSide,
  Group,
  InstancedBufferAttribute,
  InstancedBufferGeometry,
  LinearFilter,
  Mesh,
  OneFactor,
  OneMinusSrcAlphaFactor,
  ShaderMaterial,
} from "three";

export const THUMB_SIZE = 32;
const CHUNK = 64;

const VERTEX = `
  attribute vec3 corner;
  attribute vec3 right;
  attribute vec3 down;
  attribute float layer;
  varying vec3 texel;
  void main() {
    vec2 at = vec2(gl_VertexID & 1, gl_VertexID >> 1);
    texel = vec3(at, layer);
    gl_Position = layer < 0.0 ? vec4(2.0, 2.0, 2.0, 1.0)
      : projectionMatrix * viewMatrix * vec4(corner + at.x * right + at.y * down, 1.0);
  }`;
const FRAGMENT = `
  precision highp sampler2DArray;
  uniform sampler2DArray colours;
  varying vec3 texel;
  void main() { gl_FragColor = texture(colours, texel); }`;

class Chunk {
  readonly mesh: Mesh<InstancedBufferGeometry, ShaderMaterial>;
  used = 0;
  private readonly texture = new DataArrayTexture(new Uint8Array(4 * THUMB_SIZE ** 2 * CHUNK), THUMB_SIZE, THUMB_SIZE, CHUNK);
  private readonly places = { corner: instanced(3), right: instanced(3), down: instanced(3) };
  private readonly layer = instanced(1);

  constructor(renderOrder: number) {
    this.layer.array.fill(-1);
    this.texture.minFilter = this.texture.magFilter = LinearFilter;
    this.texture.needsUpdate = true;
    const geometry = new InstancedBufferGeometry();
    for (const [name, attribute] of Object.entries({ ...this.places, layer: this.layer })) geometry.setAttribute(name, attribute);
    geometry.setIndex([0, 2, 1, 1, 2, 3]);
    geometry.instanceCount = CHUNK;
    const material = new ShaderMaterial({
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      uniforms: { colours: { value: this.texture } },
      side: DoubleSide,
      transparent: true,
      depthWrite: false,
      blending: CustomBlending,
      blendSrc: OneFactor,
      blendDst: OneMinusSrcAlphaFactor,
    });
    this.mesh = new Mesh(geometry, material);
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = renderOrder;
  }

  paint(index: number, rgba: Uint8ClampedArray): void {
    const to = this.texture.image.data as Uint8Array;
    const at = index * rgba.length;
    // Colours are multiplied by alpha, so that what was not seen does not darken the edge when they are interpolated.
    for (let i = 0; i < rgba.length; i += 4) {
      const alpha = rgba[i + 3] ?? 0;
      for (let k = 0; k < 3; ++k) to[at + i + k] = Math.round(((rgba[i + k] ?? 0) * alpha) / 255);
      to[at + i + 3] = alpha;
    }
    this.texture.addLayerUpdate(index);
    this.texture.needsUpdate = true;
  }

  /** Scene coordinates of its upper left, upper right and lower left corners. */
  place(index: number, corners: readonly (readonly number[])[]): void {
    const [corner, right, down] = corners;
    const less = (one: readonly number[] = [], other: readonly number[] = []) => one.map((value, k) => value - (other[k] ?? 0));
    this.places.corner.set(corner ?? [], 3 * index);
    this.places.right.set(less(right, corner), 3 * index);
    this.places.down.set(less(down, corner), 3 * index);
    for (const attribute of Object.values(this.places)) attribute.needsUpdate = true;
  }

  show(index: number, shown: boolean): void {
    this.layer.set([shown ? index : -1], index);
    this.layer.needsUpdate = true;
  }

  dispose(): void {
    this.texture.dispose();
    this.mesh.geometry.dispose();
    this.mesh.material.dispose();
  }
}

/** One tile's small picture. */
export interface Thumb {
  paint(rgba: Uint8ClampedArray): void;
  place(corners: readonly (readonly number[])[]): void;
  show(shown: boolean): void;
}

export class Thumbs {
  readonly object = new Group();
  private chunks: { chunk: Chunk; renderOrder: number }[] = [];

  make(renderOrder: number): Thumb {
    let found = this.chunks.find((one) => one.renderOrder === renderOrder && one.chunk.used < CHUNK)?.chunk;
    if (found === undefined) {
      found = new Chunk(renderOrder);
      this.chunks.push({ chunk: found, renderOrder });
      this.object.add(found.mesh);
    }
    const chunk = found;
    const index = chunk.used++;
    return {
      paint: (rgba) => { chunk.paint(index, rgba); },
      place: (corners) => { chunk.place(index, corners); },
      show: (shown) => { chunk.show(index, shown); },
    };
  }

  clear(): void {
    for (const { chunk } of this.chunks) chunk.dispose();
    this.chunks = [];
    this.object.clear();
  }
}

function instanced(itemSize: number): InstancedBufferAttribute {
  return new InstancedBufferAttribute(new Float32Array(CHUNK * itemSize), itemSize);
}
