// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import { VERSION, HEADER_SIZE, type Vec2, type Vec3 } from "./records";

/** The bytes are not a record of this protocol. */
export class Malformed extends Error {}

const text = new TextDecoder();

/** Reads a record from front to back; throws Malformed at the first fault. */
export class Reader {
  readonly type: number;
  readonly sequence: number;
  private readonly view: DataView;
  private at = HEADER_SIZE;

  constructor(private readonly buffer: ArrayBuffer) {
    this.view = new DataView(buffer);
    require(buffer.byteLength >= HEADER_SIZE && this.view.getUint8(1) === VERSION);
    this.type = this.view.getUint8(0);
    this.sequence = Number(this.view.getBigUint64(8, true));
  }

  u8(): number {
    return this.view.getUint8(this.take(1));
  }
  u16(): number {
    return this.view.getUint16(this.take(2), true);
  }
  u32(): number {
    return this.view.getUint32(this.take(4), true);
  }
  i32(): number {
    return this.view.getInt32(this.take(4), true);
  }
  f32(): number {
    return finite(this.view.getFloat32(this.take(4), true));
  }
  f64(): number {
    return finite(this.view.getFloat64(this.take(8), true));
  }
  /** A u64 that counts something: exact below 2^53. */
  count(): number {
    return Number(this.u64());
  }
  u64(): bigint {
    return this.view.getBigUint64(this.take(8), true);
  }
  /** Seconds from i64 nanoseconds. */
  time(): number {
    return Number(this.view.getBigInt64(this.take(8), true)) / 1e9;
  }
  positive(): number {
    const value = this.f64();
    require(value > 0);
    return value;
  }
  notNegative(): number {
    const value = this.f64();
    require(value >= 0);
    return value;
  }
  share(): number {
    const value = this.notNegative();
    require(value <= 1);
    return value;
  }
  vec2(): Vec2 {
    return [this.f64(), this.f64()];
  }
  vec3(): Vec3 {
    return [this.f64(), this.f64(), this.f64()];
  }
  flag(): boolean {
    const value = this.u8();
    require(value <= 1);
    return value === 1;
  }
  choice<T>(names: readonly T[]): T {
    const name = names[this.u8()];
    if (name === undefined) throw new Malformed();
    return name;
  }
  text(): string {
    return text.decode(this.bytes(this.u16()));
  }
  blob(): Uint8Array<ArrayBuffer> {
    return this.bytes(this.u32());
  }
  jpeg(): Uint8Array<ArrayBuffer> {
    const bytes = this.blob();
    require(bytes.length > 3 && bytes[0] === 0xff && bytes[1] === 0xd8 && bytes[2] === 0xff);
    return bytes;
  }
  png(): Uint8Array<ArrayBuffer> {
    const bytes = this.blob();
    require(bytes.length > 8 && bytes[0] === 0x89 && bytes[1] === 0x50 && bytes[2] === 0x4e);
    return bytes;
  }
  bytes(size: number): Uint8Array<ArrayBuffer> {
    return new Uint8Array(this.buffer, this.take(size), size);
  }
  /** Needs a position that is a multiple of 4. */
  floats(count: number): Float32Array {
    const values = new Float32Array(this.buffer, this.take(4 * count), count);
    require(values.every(Number.isFinite));
    return values;
  }
  shorts(count: number): Uint16Array {
    return new Uint16Array(this.buffer, this.take(2 * count), count);
  }
  get left(): number {
    return this.buffer.byteLength - this.at;
  }
  end(): void {
    require(this.left === 0);
  }

  private take(size: number): number {
    require(size <= this.left);
    const from = this.at;
    this.at += size;
    return from;
  }
}

export function require(condition: boolean): asserts condition {
  if (!condition) throw new Malformed();
}

function finite(value: number): number {
  require(Number.isFinite(value));
  return value;
}
