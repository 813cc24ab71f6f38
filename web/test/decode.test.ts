// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import { readdirSync } from "node:fs";
import { describe, expect, it } from "vitest";
import { decode } from "../src/wire/decode";
import { VERSION } from "../src/wire/records";
import { golden, GOLDEN } from "./golden";

const JPEG = new Uint8Array([0xff, 0xd8, 0xff, 0xe0, 1, 2, 3, 0xff, 0xd9]);
const PNG = new Uint8Array([0x89, 0x50, 0x4e, 0x47, 13, 10, 0x1a, 10, 1, 2]);

/** The values tests/wire/records_test.cpp encodes. */
const EXPECTED: Record<string, object> = {
  welcome: { type: "welcome", feed: 0xfedcba9876543210n, newest: 7 },
  caught_up: { type: "caught_up", upTo: 12345678901n, evicted: 2 },
  state: {
    type: "state",
    tracking: "tracking",
    axes: "attitude",
    finished: true,
    scale: "stereo",
    sigma: 0.0025,
    submap: 2,
    image: 123,
    time: 61.5,
    captured: 124,
    oriented: 120,
    lost: 3,
    dropped: 1,
    tiePoints: 45678,
    windows: 116,
    planes: 110,
    mosaicTiles: 77,
    total: 250,
    rate: 3.75,
    input: "Portofino – relitto",
  },
  alert: {
    type: "alert",
    id: 4,
    time: 12.25,
    image: 25,
    kind: "tracking_lost",
    message: "tracking lost: 9 matches of 30 needed",
    remedy: "go back slowly over the last ground",
  },
  camera: { type: "camera", width: 968, height: 728, fx: 800.5, fy: 801.25, cx: 483.5, cy: 363.5 },
  pose: {
    type: "pose",
    image: 42,
    time: 21,
    position: [1000000.125, -2.5, 3.0625],
    rotation: [1, 0, 0, 0],
    submap: 1,
    tiePoints: 321,
    rms: 0.5,
    sigma: 0.25,
    keyFrame: true,
  },
  tie_points: {
    type: "tie_points",
    block: 3,
    origin: [1e6, 2e6, -3.25],
    offsets: new Float32Array([0.5, -0.25, 0.125, 8, 4, 2]),
    indices: new Uint16Array([0, 511]),
    colours: new Uint8Array([1, 2, 3, 253, 254, 255]),
  },
  plane_grid: {
    type: "plane_grid",
    image: 42,
    submap: 1,
    columns: 150,
    rows: 100,
    surveyFromGrid: new Float64Array([0.02, 0, -1.5, 0, -0.02, 1, 0, 0.001, -3, 0.0005, 0.00025, 1]),
    camera: [1.5, 2.5, 3.5],
    maxRange: 12.5,
  },
  plane_colour: { type: "plane_colour", image: 42, jpeg: JPEG },
  mosaic: {
    type: "mosaic",
    mosaic: 1,
    submap: 2,
    groundSamplingDistance: 0.005,
    world: { a: 0.005, d: 0, b: 0, e: -0.005, c: 10.5, f: -20.25 },
    normal: [0.6, 0, 0.8],
    offset: -3.5,
  },
  mosaic_tile: { type: "mosaic_tile", mosaic: 1, column: -2, row: 3, jpeg: JPEG, mask: PNG },
  live_image: { type: "live_image", image: 9, time: 4.5, jpeg: JPEG, tiePoints: new Uint16Array([0, 65535, 32768, 7]) },
  statistics: {
    type: "statistics",
    stages: [
      {
        stage: "odometry",
        rateIn: 4,
        rateOut: 3.5,
        processed: 120,
        dropped: 1,
        depth: 2,
        lastMs: 41.5,
        p95Ms: 62.25,
      },
      { stage: "plane", rateIn: 0, rateOut: 0, processed: 0, dropped: 0, depth: 0, lastMs: 0, p95Ms: 0 },
    ],
  },
  check: {
    type: "check",
    findings: [
      { verdict: "good", item: "camera", found: "10.0 images a second", remedy: "" },
      { verdict: "bad", item: "disk", found: "/dives cannot be written: read-only", remedy: "check the disk" },
    ],
  },
  measures: {
    type: "measures",
    measures: [
      { quantity: "altitude", value: 1.5, low: 1, high: 3 },
      { quantity: "overlap", value: 0.75, low: 0.6, high: null },
      { quantity: "utc", value: 1795996800.5, low: null, high: null },
    ],
  },
  recording: {
    type: "recording",
    phase: "recording",
    controllable: true,
    saved: 120,
    began: 3.5,
    name: "dive-0007",
    controller: "Anna",
  },
  mosaic_overview: { type: "mosaic_overview", mosaic: 1, column: -1, row: 0, jpeg: JPEG, mask: PNG },
  coverage_tile: { type: "coverage_tile", column: -1, row: 2, cell: 0.05, png: PNG },
  guidance: {
    type: "guidance",
    area: 50,
    covered: 12.5,
    lane: 1,
    offLane: -0.25,
    plan: [
      [0, 0],
      [10, 0],
      [10, 5],
      [0, 5],
    ],
    gaps: [
      { centre: [2.5, 1.25], area: 0.75 },
      { centre: [8, 4], area: 3 },
    ],
    lanes: [
      { from: [0, 1], to: [10, 1], covered: 0.5 },
      { from: [10, 3], to: [0, 3], covered: 0 },
    ],
  },
  mark: {
    type: "mark",
    id: 3,
    time: 30,
    image: 61,
    position: [1.5, -2.5, 0.125],
    removed: false,
    note: "amphora, handle broken",
  },
  last_view: { type: "last_view", image: 8, time: 4, jpeg: JPEG },
  way_back: { type: "way_back", lost: true, known: true, turn: -0.5, distance: 2.25, sigma: 0.5 },
};

describe("decode", () => {
  it("knows every golden record", () => {
    const files = readdirSync(GOLDEN).map((file) => file.replace(".bin", ""));
    expect(files.sort()).toEqual([...Object.keys(EXPECTED), "hello"].sort());
  });

  for (const [name, values] of Object.entries(EXPECTED)) {
    it(`reads the golden ${name} as the server wrote it`, () => {
      expect(decode(golden(name))).toEqual({ ...values, sequence: 0 });
    });

    it(`refuses a ${name} cut short or prolonged`, () => {
      const bytes = golden(name);
      for (let size = 0; size < bytes.byteLength; ++size) {
        // Without its points a block of tie points is whole.
        if (name === "tie_points" && (size - 48) % 17 === 0) continue;
        expect(decode(bytes.slice(0, size)), `cut to ${size}`).toBeNull();
      }
      const longer = new Uint8Array(bytes.byteLength + 1);
      longer.set(new Uint8Array(bytes));
      expect(decode(longer.buffer)).toBeNull();
    });

    it(`survives a ${name} with any byte changed`, () => {
      for (let at = 0; at < golden(name).byteLength; ++at) {
        for (const value of [0, 1, 0x7f, 0x80, 0xff]) {
          const bytes = golden(name);
          new Uint8Array(bytes)[at] = value;
          expect(() => decode(bytes)).not.toThrow();
        }
      }
    });
  }

  it("refuses another version and an unknown type", () => {
    for (const [at, value] of [
      [1, VERSION + 1],
      [0, 99],
    ] as const) {
      const bytes = golden("pose");
      new Uint8Array(bytes)[at] = value;
      expect(decode(bytes)).toBeNull();
    }
  });

  it("refuses numbers that are not finite", () => {
    const bytes = golden("pose");
    new DataView(bytes).setFloat64(32, NaN, true);
    expect(decode(bytes)).toBeNull();
  });

  it("reads the sequence", () => {
    const bytes = golden("pose");
    new DataView(bytes).setBigUint64(8, 12345678901n, true);
    expect(decode(bytes)?.sequence).toBe(12345678901);
  });

  it("reads a tile that was wholly seen", () => {
    const bytes = golden("mosaic_tile").slice(0, 55 - PNG.length);
    new DataView(bytes).setUint32(bytes.byteLength - 4, 0, true);
    expect(decode(bytes)).toMatchObject({ type: "mosaic_tile", mask: null });
  });
});
