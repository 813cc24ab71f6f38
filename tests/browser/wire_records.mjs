// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Records of include/nadir/wire/README.md, read and made, some from those in tests/wire/golden.
import { readFileSync } from "node:fs";
import { deflateSync, gzipSync } from "node:zlib";

export const HEADER = 16;
export const ALERT = 4; // of the type
export const NEWS = 1_000_000; // a sequence that no server here comes to
export const golden = (name) => readFileSync(new URL(`../wire/golden/${name}.bin`, import.meta.url));
const text = (words) => {
  const bytes = Buffer.from(words);
  return Buffer.concat([Buffer.from([bytes.length & 255, bytes.length >> 8]), bytes]);
};

/** Of the dive "dive-0007"; phase: 0 waiting, 1 recording, 2 paused by the disk, 3 ended. */
export function recording(phase, { saved = 120, began = 0n } = {}) {
  const record = golden("recording");
  record[HEADER] = phase;
  record[HEADER + 1] = 1; // can be begun and ended from a page
  record.writeBigUInt64LE(BigInt(saved), HEADER + 2);
  record.writeBigInt64LE(began, HEADER + 10);
  return record;
}

const QUANTITIES = ["altitude", "speed", "overlap", "depth", "heading", "battery", "free_space", "recording_left", "blur", "brightness", "temperature", "utc"];

/** all: {quantity: [value, low, high]}, null for no limit. */
export function measures(all) {
  const entries = Object.entries(all).map(([quantity, [value, low = null, high = null]]) => {
    const entry = Buffer.alloc(27);
    entry.set([QUANTITIES.indexOf(quantity), low === null ? 0 : 1, high === null ? 0 : 1]);
    [value, low ?? 0, high ?? 0].forEach((number, i) => entry.writeDoubleLE(number, 3 + 8 * i));
    return entry;
  });
  return Buffer.concat([golden("measures").subarray(0, HEADER), Buffer.from([entries.length]), ...entries]);
}

/** A state with so many images that are missing. */
export function missing(state, lost) {
  const record = Buffer.from(state);
  record.writeBigUInt64LE(BigInt(lost), HEADER + 56);
  return record;
}

/** A state with so many images that have a pose. */
export function oriented(state, images) {
  const record = Buffer.from(state);
  record.writeBigUInt64LE(BigInt(images), HEADER + 48);
  return record;
}

export function alert(id, sequence, kind, message, remedy) {
  const record = Buffer.concat([golden("alert").subarray(0, HEADER + 25), ...[kind, message, remedy].map(text)]);
  record.writeBigUInt64LE(BigInt(sequence), 8);
  record.writeBigUInt64LE(BigInt(id), HEADER);
  return record;
}

export function poseIn(record) {
  const f64 = (at) => record.readDoubleLE(at);
  return { position: [32, 40, 48].map(f64), rotation: [56, 64, 72, 80].map(f64) };
}

export function guidanceIn(record) {
  let at = 16;
  const f64 = () => record.readDoubleLE((at += 8) - 8);
  const u8 = () => record.readUInt8(at++);
  const [area, covered] = [f64(), f64()];
  const isOnLane = u8() === 1;
  const lane = record.readUInt16LE((at += 2) - 2);
  const offLane = f64();
  const plan = Array.from({ length: u8() }, () => [f64(), f64()]);
  const gaps = Array.from({ length: u8() }, () => ({ centre: [f64(), f64()], area: f64() }));
  return { area, covered, lane: isOnLane ? lane : null, offLane, plan, gaps };
}

/** An 8-bit grey PNG of rows of equal length. */
function greyPng(rows) {
  const chunk = (type, data) => {
    const body = Buffer.concat([Buffer.from(type), data]);
    const [size, sum] = [Buffer.alloc(4), Buffer.alloc(4)];
    size.writeUInt32BE(data.length);
    sum.writeUInt32BE(gzipSync(body).subarray(-8).readUInt32LE()); // its CRC-32, by RFC 1952
    return Buffer.concat([size, body, sum]);
  };
  const head = Buffer.alloc(13);
  head.writeUInt32BE(rows[0].length, 0);
  head.writeUInt32BE(rows.length, 4);
  head[8] = 8;
  const data = deflateSync(Buffer.concat(rows.map((row) => Buffer.from([0, ...row]))));
  return Buffer.concat([Buffer.from("\x89PNG\r\n\x1a\n", "latin1"), chunk("IHDR", head), chunk("IDAT", data), chunk("IEND", Buffer.alloc(0))]);
}

/** Record 18 of include/nadir/wire/README.md. */
export function coverageTile({ column, row, cell }, rows) {
  const png = greyPng(rows);
  const head = Buffer.alloc(36);
  head.writeUInt8(18, 0);
  head.writeUInt8(2, 1);
  head.writeBigUInt64LE(1n, 8);
  head.writeInt32LE(column, 16);
  head.writeInt32LE(row, 20);
  head.writeDoubleLE(cell, 24);
  head.writeUInt32LE(png.length, 32);
  return Buffer.concat([head, png]);
}
