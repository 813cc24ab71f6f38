// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import { Malformed, Reader, require } from "./reader";
import {
  AXES,
  PHASES,
  QUANTITIES,
  SCALE_SOURCES,
  TIE_POINT_BLOCK,
  TRACKING,
  VERDICTS,
  type Alert,
  type Body,
  type CameraInfo,
  type CaughtUp,
  type Check,
  type CoverageTile,
  type Guidance,
  type LastView,
  type LiveImage,
  type Mark,
  type Measures,
  type Mosaic,
  type MosaicOverview,
  type MosaicTile,
  type PlaneColour,
  type PlaneGrid,
  type Pose,
  type Recording,
  type State,
  type Statistics,
  type TiePoints,
  type Vec3,
  type WayBack,
  type Welcome,
  type WireRecord,
} from "./records";

/** Null unless the bytes are exactly one well-formed record of a known type. */
export function decode(buffer: ArrayBuffer): WireRecord | null {
  try {
    const from = new Reader(buffer);
    const body = BODIES[from.type]?.(from);
    if (body === undefined) return null;
    from.end();
    return { ...body, sequence: from.sequence };
  } catch (fault) {
    if (fault instanceof Malformed) return null;
    throw fault;
  }
}

/** Of an alert's record. */
export const ALERT_TYPE = 4;

const BODIES: Partial<Record<number, (from: Reader) => Body>> = {
  2: welcome,
  3: state,
  [ALERT_TYPE]: alert,
  5: camera,
  6: pose,
  7: tiePoints,
  8: planeGrid,
  9: planeColour,
  10: mosaic,
  11: mosaicTile,
  12: liveImage,
  13: statistics,
  14: caughtUp,
  15: check,
  16: measures,
  17: recording,
  18: coverageTile,
  19: guidance,
  20: mark,
  21: lastView,
  22: wayBack,
  23: mosaicOverview,
};

// Members of an object literal are evaluated in their order, which here is the order on the wire.

function welcome(from: Reader): Welcome {
  return { type: "welcome", feed: from.u64(), newest: from.count() };
}

function caughtUp(from: Reader): CaughtUp {
  return { type: "caught_up", upTo: from.u64(), evicted: from.count() };
}

function state(from: Reader): State {
  return {
    type: "state",
    tracking: from.choice(TRACKING),
    axes: from.choice(AXES),
    finished: from.flag(),
    scale: from.choice(SCALE_SOURCES),
    submap: from.u32(),
    image: from.count(),
    time: from.time(),
    sigma: from.f64(),
    rate: from.f64(),
    captured: from.count(),
    oriented: from.count(),
    lost: from.count(),
    dropped: from.count(),
    tiePoints: from.count(),
    windows: from.count(),
    planes: from.count(),
    mosaicTiles: from.count(),
    total: from.count(),
    input: from.text(),
  };
}

function alert(from: Reader): Alert {
  const id = from.count();
  const time = from.time();
  const image = from.count();
  return {
    type: "alert",
    id,
    time,
    image: from.flag() ? image : null,
    kind: from.text(),
    message: from.text(),
    remedy: from.text(),
  };
}

function camera(from: Reader): CameraInfo {
  const width = from.u32();
  const height = from.u32();
  require(width > 0 && height > 0);
  return {
    type: "camera",
    width,
    height,
    fx: from.positive(),
    fy: from.positive(),
    cx: from.f64(),
    cy: from.f64(),
  };
}

function pose(from: Reader): Pose {
  const record: Pose = {
    type: "pose",
    image: from.count(),
    time: from.time(),
    position: from.vec3(),
    rotation: [from.f64(), from.f64(), from.f64(), from.f64()],
    submap: from.u32(),
    tiePoints: from.u32(),
    rms: from.f32(),
    sigma: from.f32(),
    keyFrame: from.flag(),
  };
  require(isUnit(record.rotation));
  return record;
}

function tiePoints(from: Reader): TiePoints {
  const block = from.count();
  const origin = from.vec3();
  const count = from.left / 17;
  require(Number.isInteger(count) && count <= TIE_POINT_BLOCK);
  const record: TiePoints = {
    type: "tie_points",
    block,
    origin,
    offsets: from.floats(3 * count),
    indices: from.shorts(count),
    colours: from.bytes(3 * count),
  };
  let least = 0;
  for (const index of record.indices) {
    require(index >= least && index < TIE_POINT_BLOCK);
    least = index + 1;
  }
  return record;
}

function planeGrid(from: Reader): PlaneGrid {
  const record: PlaneGrid = {
    type: "plane_grid",
    image: from.count(),
    submap: from.u32(),
    columns: from.u16(),
    rows: from.u16(),
    surveyFromGrid: Float64Array.from({ length: 12 }, () => from.f64()),
    camera: from.vec3(),
    maxRange: from.positive(),
  };
  require(record.columns > 1 && record.rows > 1);
  return record;
}

function planeColour(from: Reader): PlaneColour {
  return { type: "plane_colour", image: from.count(), jpeg: from.jpeg() };
}

function mosaic(from: Reader): Mosaic {
  const record: Mosaic = {
    type: "mosaic",
    mosaic: from.u32(),
    submap: from.u32(),
    groundSamplingDistance: from.positive(),
    world: {
      a: from.f64(),
      d: from.f64(),
      b: from.f64(),
      e: from.f64(),
      c: from.f64(),
      f: from.f64(),
    },
    normal: from.vec3(),
    offset: from.f64(),
  };
  require(isUnit(record.normal) && record.normal[2] !== 0);
  return record;
}

function mosaicTile(from: Reader): MosaicTile {
  return { type: "mosaic_tile", ...tile(from) };
}

function mosaicOverview(from: Reader): MosaicOverview {
  return { type: "mosaic_overview", ...tile(from) };
}

function tile(from: Reader): Omit<MosaicTile, "type"> {
  return {
    mosaic: from.u32(),
    column: from.i32(),
    row: from.i32(),
    jpeg: from.jpeg(),
    mask: from.left === 4 ? none(from) : from.png(),
  };
}

function none(from: Reader): null {
  require(from.u32() === 0);
  return null;
}

function liveImage(from: Reader): LiveImage {
  return { type: "live_image", image: from.count(), time: from.time(), jpeg: from.jpeg(), tiePoints: pairs(from) };
}

function pairs(from: Reader): Uint16Array {
  return Uint16Array.from({ length: 2 * from.u16() }, () => from.u16());
}

function statistics(from: Reader): Statistics {
  const stages = Array.from({ length: from.u8() }, () => ({
    stage: from.text(),
    rateIn: from.f64(),
    rateOut: from.f64(),
    processed: from.count(),
    dropped: from.count(),
    depth: from.u32(),
    lastMs: from.f64(),
    p95Ms: from.f64(),
  }));
  return { type: "statistics", stages };
}

function check(from: Reader): Check {
  const findings = Array.from({ length: from.u8() }, () => ({
    verdict: from.choice(VERDICTS),
    item: from.text(),
    found: from.text(),
    remedy: from.text(),
  }));
  return { type: "check", findings };
}

function measures(from: Reader): Measures {
  const all = Array.from({ length: from.u8() }, () => {
    const quantity = from.choice(QUANTITIES);
    const hasLow = from.flag();
    const hasHigh = from.flag();
    const value = from.f64();
    const low = from.f64();
    const high = from.f64();
    return { quantity, value, low: hasLow ? low : null, high: hasHigh ? high : null };
  });
  return { type: "measures", measures: all };
}

function recording(from: Reader): Recording {
  return {
    type: "recording",
    phase: from.choice(PHASES),
    controllable: from.flag(),
    saved: from.count(),
    began: from.time(),
    name: from.text(),
    controller: from.text(),
  };
}

function coverageTile(from: Reader): CoverageTile {
  return { type: "coverage_tile", column: from.i32(), row: from.i32(), cell: from.positive(), png: from.png() };
}

function guidance(from: Reader): Guidance {
  const area = from.notNegative();
  const covered = from.notNegative();
  const onLane = from.flag();
  const lane = from.u16();
  const record: Guidance = {
    type: "guidance",
    area,
    covered,
    lane: onLane ? lane : null,
    offLane: from.f64(),
    plan: Array.from({ length: from.u8() }, () => from.vec2()),
    gaps: Array.from({ length: from.u8() }, () => ({ centre: from.vec2(), area: from.notNegative() })),
    lanes: Array.from({ length: from.u16() }, () => ({ from: from.vec2(), to: from.vec2(), covered: from.share() })),
  };
  require(!onLane || lane < record.lanes.length);
  return record;
}

function mark(from: Reader): Mark {
  const id = from.count();
  const time = from.time();
  const image = from.count();
  return {
    type: "mark",
    id,
    time,
    image: from.flag() ? image : null,
    position: from.vec3(),
    removed: from.flag(),
    note: from.text(),
  };
}

function lastView(from: Reader): LastView {
  return { type: "last_view", image: from.count(), time: from.time(), jpeg: from.jpeg() };
}

function wayBack(from: Reader): WayBack {
  return {
    type: "way_back",
    lost: from.flag(),
    known: from.flag(),
    turn: from.f64(),
    distance: from.notNegative(),
    sigma: from.notNegative(),
  };
}

function isUnit(vector: readonly number[] | Vec3): boolean {
  return Math.abs(Math.hypot(...vector) - 1) <= 1e-6;
}
