// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import { BufferAttribute, DynamicDrawUsage, InstancedBufferAttribute } from "three";

type Numbers = Float32Array | Uint8Array;

/** A vertex attribute that grows by doubling, so that each addition sends only itself to the graphics card. */
export class GrowingAttribute<T extends Numbers> {
  attribute: BufferAttribute;

  constructor(
    private readonly make: (length: number) => T,
    private readonly itemSize: number,
    private readonly kind: { instanced?: boolean; normalized?: boolean } = {},
    capacity = 256,
  ) {
    this.attribute = this.wrap(make(capacity * itemSize));
  }

  get capacity(): number {
    return this.attribute.count;
  }

  set(item: number, values: ArrayLike<number>): void {
    this.attribute.array.set(values, item * this.itemSize);
    this.attribute.addUpdateRange(item * this.itemSize, this.itemSize);
    this.attribute.needsUpdate = true;
  }

  clear(): void {
    this.attribute.array.fill(0);
    this.attribute.clearUpdateRanges();
    this.attribute.needsUpdate = true;
  }

  /** Makes room for so many items; true when the attribute is a new one. */
  reserve(items: number): boolean {
    if (items <= this.capacity) return false;
    const array = this.make(Math.max(items, 2 * this.capacity) * this.itemSize);
    array.set(this.attribute.array);
    this.attribute = this.wrap(array);
    return true;
  }

  private wrap(array: T): BufferAttribute {
    const Kind = this.kind.instanced ? InstancedBufferAttribute : BufferAttribute;
    const attribute = new Kind(array, this.itemSize, this.kind.normalized ?? false);
    attribute.setUsage(DynamicDrawUsage);
    return attribute;
  }
}
