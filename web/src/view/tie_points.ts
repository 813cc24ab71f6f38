// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import { BufferGeometry, Points, ShaderMaterial } from "three";
import { TIE_POINT_BLOCK, type TiePoints } from "../wire/records";
import { GrowingAttribute } from "./growing";
import type { Origin } from "./origin";

const VERTEX = `
  attribute vec4 colour;
  uniform float size;
  varying vec3 shade;
  void main() {
    shade = colour.rgb;
    // Alpha 0: the point was withdrawn.
    gl_Position = colour.a > 0.0 ? projectionMatrix * viewMatrix * vec4(position, 1.0) : vec4(2.0, 2.0, 2.0, 1.0);
    gl_PointSize = size;
  }`;
const FRAGMENT = `
  varying vec3 shade;
  void main() { gl_FragColor = vec4(shade, 1.0); }`;

/** The sparse cloud: one growing buffer, a slot for each point that was ever seen. */
export class TiePointCloud {
  readonly object: Points<BufferGeometry, ShaderMaterial>;
  /** Points now known. */
  count = 0;
  private slots = new Map<number, Int32Array>();
  private used = 0;
  private readonly positions = new GrowingAttribute((n) => new Float32Array(n), 3);
  private readonly colours = new GrowingAttribute((n) => new Uint8Array(n), 4, { normalized: true });

  constructor(private readonly origin: Origin) {
    const material = new ShaderMaterial({
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      uniforms: { size: { value: 2 } },
    });
    this.object = new Points(new BufferGeometry(), material);
    this.object.frustumCulled = false;
    this.attach();
  }

  set(block: TiePoints): void {
    const slots = this.slotsOf(block.block);
    const origin = this.origin.toScene(block.origin);
    const present = new Set(block.indices);
    this.reserve(this.used + block.indices.length);
    slots.forEach((slot, index) => {
      if (slot >= 0 && this.isShown(slot) && !present.has(index)) this.withdraw(slot);
    });
    block.indices.forEach((index, i) => {
      if ((slots[index] ?? -1) < 0) slots[index] = this.used++;
      this.place(slots[index] ?? 0, block, i, origin);
    });
    this.object.geometry.setDrawRange(0, this.used);
  }

  clear(): void {
    this.slots = new Map();
    this.used = 0;
    this.count = 0;
    this.colours.clear();
    this.object.geometry.setDrawRange(0, 0);
  }

  private slotsOf(block: number): Int32Array {
    let slots = this.slots.get(block);
    if (slots === undefined) {
      slots = new Int32Array(TIE_POINT_BLOCK).fill(-1);
      this.slots.set(block, slots);
    }
    return slots;
  }

  private place(slot: number, block: TiePoints, i: number, origin: readonly number[]): void {
    if (!this.isShown(slot)) ++this.count;
    const at = (k: number) => (block.offsets[3 * i + k] ?? 0) + (origin[k] ?? 0);
    this.positions.set(slot, [at(0), at(1), at(2)]);
    this.colours.set(slot, [...block.colours.subarray(3 * i, 3 * i + 3), 255]);
  }

  private isShown(slot: number): boolean {
    return (this.colours.attribute.array[4 * slot + 3] ?? 0) > 0;
  }

  private withdraw(slot: number): void {
    this.colours.set(slot, [0, 0, 0, 0]);
    --this.count;
  }

  private reserve(points: number): void {
    const moved = this.positions.reserve(points);
    if (this.colours.reserve(points) || moved) this.attach();
  }

  private attach(): void {
    this.object.geometry.dispose();
    this.object.geometry.setAttribute("position", this.positions.attribute);
    this.object.geometry.setAttribute("colour", this.colours.attribute);
  }
}
