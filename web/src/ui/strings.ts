// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Every word the page says by itself.
import type { Tracking } from "../wire/records";

export const S = {
  tracking: {
    waiting: "Waiting",
    initialising: "Starting",
    tracking: "Tracking",
    lost: "Lost",
  } satisfies Record<Tracking, string>,
  finished: "Dive mapped",
  noServer: "No connection",
  advice: {
    waiting: "no image yet",
    initialising: "move on slowly",
    lost: "go back to mapped ground",
  } satisfies Partial<Record<Tracking, string>>,
  images: (done: string, total: string | null) => (total === null ? `${done} images` : `${done} of ${total} images`),
  rate: (rate: string) => `${rate} per second`,
  lostImages: (count: string) => `${count} lost`,
  droppedImages: (count: string) => `${count} dropped`,
  submap: (number: number) => `part ${number + 1}`,
  unscaled: "Unscaled",
  unscaledLong: "no scale: lengths are not metres",
  scaled: { stereo: "Stereo scale", laser: "Laser scale", typed: "Typed scale", altitude: "Sonar scale", depth: "Depth scale", poses: "Given scale" },
  north: "N",
  link: { connecting: "Connecting", live: "Live", lost: "Reconnecting" },
  linkLost: "The picture is not up to date",
  counts: { cameras: "cameras", tiePoints: "tie points", planes: "planes", mosaicTiles: "mosaic tiles" },
  tools: {
    scene: "3D",
    map: "Map",
    all: "All",
    follow: "Follow",
    closer: "Closer",
    farther: "Farther",
    layers: "Layers",
    alerts: "Alerts",
    system: "System",
  },
  layers: {
    title: "Layers",
    mosaic: "Mosaic",
    quads: "Image planes",
    points: "Planes as points",
    tiePoints: "Tie points",
    cameras: "Cameras and path",
  },
  alerts: { title: "Alerts", none: "No alerts", image: (image: number) => `image ${image}`, dismiss: "Dismiss" },
  system: {
    title: "System",
    heads: ["Stage", "Per s", "Queue", "Dropped", "ms", "95 %"],
    ignored: (count: number) => `${count} messages not understood`,
    none: "No figures yet",
    stages: "Stages",
  },
  equipment: { none: "The equipment is checked on a live dive" },
  live: { title: "Current image", none: "No image yet", caption: (image: number) => `image ${image}` },
  close: "Close",
  no3d: "This browser cannot draw in 3D (WebGL 2). State, alerts and the current image work.",
  canvas: "Map of the dive. Arrow keys move, plus and minus zoom, M map, F follow, A all.",
  units: "units",
} as const;

const grouped = new Intl.NumberFormat("en", { maximumFractionDigits: 0 });

export function count(value: number): string {
  return grouped.format(value).replaceAll(",", "\u202f");
}

export function clock(seconds: number): string {
  if (seconds > 1e8) return new Date(seconds * 1000).toISOString().slice(11, 19);
  const whole = Math.floor(seconds);
  return `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, "0")}`;
}
