// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The records of the browser protocol; include/nadir/wire/README.md is their written form.

export const VERSION = 2;
export const HEADER_SIZE = 16;
export const TIE_POINT_BLOCK = 512;
export const TILE_SIZE = 256;
export const OVERVIEW_TILES = 8;
export const COVERAGE_CELLS = 64;

export type Vec2 = readonly [number, number];
export type Vec3 = readonly [number, number, number];

export const TRACKING = ["waiting", "initialising", "tracking", "lost"] as const;
export type Tracking = (typeof TRACKING)[number];
export const AXES = ["none", "first_plane", "attitude", "first_camera", "poses", "doubtful"] as const;
export type Axes = (typeof AXES)[number];
export const SCALE_SOURCES = ["none", "stereo", "laser", "typed", "altitude", "depth", "poses"] as const;
export type ScaleSource = (typeof SCALE_SOURCES)[number];

export interface Welcome {
  type: "welcome";
  feed: bigint;
  newest: number;
}

export interface CaughtUp {
  type: "caught_up";
  /** The sequence up to which this viewer has everything. */
  upTo: bigint;
  evicted: number;
}

export interface State {
  type: "state";
  tracking: Tracking;
  axes: Axes;
  finished: boolean;
  scale: ScaleSource;
  /** Relative, one sigma. */
  sigma: number;
  submap: number;
  image: number;
  /** Seconds of the survey's clock. */
  time: number;
  rate: number;
  captured: number;
  oriented: number;
  lost: number;
  dropped: number;
  tiePoints: number;
  windows: number;
  planes: number;
  mosaicTiles: number;
  /** 0: unknown. */
  total: number;
  input: string;
}

export interface Alert {
  type: "alert";
  id: number;
  time: number;
  image: number | null;
  kind: string;
  message: string;
  remedy: string;
}

export interface CameraInfo {
  type: "camera";
  width: number;
  height: number;
  fx: number;
  fy: number;
  cx: number;
  cy: number;
}

export interface Pose {
  type: "pose";
  image: number;
  time: number;
  position: Vec3;
  /** x y z w of survey_from_camera. */
  rotation: readonly [number, number, number, number];
  submap: number;
  tiePoints: number;
  rms: number;
  /** Of the position, relative to the key frame before: root of the sum of three variances; 0: unknown. */
  sigma: number;
  keyFrame: boolean;
}

export interface TiePoints {
  type: "tie_points";
  block: number;
  origin: Vec3;
  /** 3 n: x y z relative to the origin. */
  offsets: Float32Array;
  /** n: id = block * TIE_POINT_BLOCK + index. */
  indices: Uint16Array;
  /** 3 n: red green blue. */
  colours: Uint8Array;
}

export interface PlaneGrid {
  type: "plane_grid";
  image: number;
  submap: number;
  columns: number;
  rows: number;
  /** 4 x 3, row by row: homogeneous survey point of (column, row, 1). */
  surveyFromGrid: Float64Array;
  camera: Vec3;
  maxRange: number;
}

export interface PlaneColour {
  type: "plane_colour";
  image: number;
  jpeg: Uint8Array;
}

export interface Mosaic {
  type: "mosaic";
  mosaic: number;
  submap: number;
  groundSamplingDistance: number;
  world: { a: number; d: number; b: number; e: number; c: number; f: number };
  normal: Vec3;
  offset: number;
}

export interface MosaicTile {
  type: "mosaic_tile";
  mosaic: number;
  column: number;
  row: number;
  jpeg: Uint8Array;
  /** Null: the whole tile was seen. */
  mask: Uint8Array | null;
}

/** Tiles eight to a side as one, each in fewer and larger pixels. */
export interface MosaicOverview {
  type: "mosaic_overview";
  mosaic: number;
  column: number;
  row: number;
  jpeg: Uint8Array;
  /** Null: all of it was seen. */
  mask: Uint8Array | null;
}

export interface LiveImage {
  type: "live_image";
  image: number;
  time: number;
  jpeg: Uint8Array;
  /** 2 n: x y of tie points, in 65535ths of the width and height. */
  tiePoints: Uint16Array;
}

export interface StageStats {
  stage: string;
  rateIn: number;
  rateOut: number;
  processed: number;
  dropped: number;
  depth: number;
  lastMs: number;
  p95Ms: number;
}

export interface Statistics {
  type: "statistics";
  stages: StageStats[];
}

export const VERDICTS = ["good", "doubtful", "bad", "absent"] as const;

export interface Finding {
  verdict: (typeof VERDICTS)[number];
  item: string;
  found: string;
  remedy: string;
}

/** How the equipment does, item by item. */
export interface Check {
  type: "check";
  findings: Finding[];
}

export const QUANTITIES = [
  "altitude",
  "speed",
  "overlap",
  "depth",
  "heading",
  "battery",
  "free_space",
  "recording_left",
  "blur",
  "brightness",
  "temperature",
  "utc",
] as const;
export type Quantity = (typeof QUANTITIES)[number];

export interface Measure {
  quantity: Quantity;
  value: number;
  /** Beyond these mapping suffers. */
  low: number | null;
  high: number | null;
}

/** What is known of the vehicle and the board by now. */
export interface Measures {
  type: "measures";
  measures: Measure[];
}

export const PHASES = ["waiting", "recording", "paused", "ended"] as const;
export type Phase = (typeof PHASES)[number];

export interface Recording {
  type: "recording";
  phase: Phase;
  /** Dives can be begun and ended from here. */
  controllable: boolean;
  saved: number;
  /** Seconds of the survey's clock. */
  began: number;
  name: string;
  /** Empty: nobody. */
  controller: string;
}

/** How often ground was seen, north up: COVERAGE_CELLS squared. */
export interface CoverageTile {
  type: "coverage_tile";
  column: number;
  row: number;
  /** Side of a cell, survey units. */
  cell: number;
  png: Uint8Array;
}

export interface Gap {
  centre: Vec2;
  area: number;
}

export interface Lane {
  from: Vec2;
  to: Vec2;
  /** Share. */
  covered: number;
}

/** Where to swim. */
export interface Guidance {
  type: "guidance";
  area: number;
  covered: number;
  /** Index of the lane being swum. */
  lane: number | null;
  /** How far to the right of it, seen along its direction. */
  offLane: number;
  plan: Vec2[];
  /** The nearest first. */
  gaps: Gap[];
  lanes: Lane[];
}

/** A point somebody wants to find again. */
export interface Mark {
  type: "mark";
  id: number;
  time: number;
  image: number | null;
  position: Vec3;
  removed: boolean;
  note: string;
}

/** The last image that could be oriented. */
export interface LastView {
  type: "last_view";
  image: number;
  time: number;
  jpeg: Uint8Array;
}

export interface WayBack {
  type: "way_back";
  lost: boolean;
  known: boolean;
  /** Radians, clockwise from the top of the image. */
  turn: number;
  distance: number;
  sigma: number;
}

/** What a dive consists of, as against the conversation about it. */
export type DiveBody =
  | State
  | Alert
  | CameraInfo
  | Pose
  | TiePoints
  | PlaneGrid
  | PlaneColour
  | Mosaic
  | MosaicTile
  | MosaicOverview
  | LiveImage
  | Statistics
  | Check
  | Measures
  | Recording
  | CoverageTile
  | Guidance
  | Mark
  | LastView
  | WayBack;

export type Body = Welcome | CaughtUp | DiveBody;

type Numbered<T> = T extends unknown ? T & { sequence: number } : never;
export type DiveRecord = Numbered<DiveBody>;
export type WireRecord = Numbered<Body>;
