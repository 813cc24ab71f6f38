// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Every word the page says by itself.
import type { Phase, Quantity, Tracking } from "../wire/records";
import type { Icon } from "./dom";

interface Advice {
  text: string;
  icon: Icon;
}

export const S = {
  tracking: {
    waiting: "Waiting",
    initialising: "Starting",
    tracking: "Tracking",
    lost: "Lost",
  } satisfies Record<Tracking, string>,
  finished: "Mapped",
  unmapped: "Not mapped",
  seeAlerts: "see Alerts",
  advice: {
    waiting: "no image yet",
    initialising: "move on slowly",
    lost: "swim back",
  } satisfies Partial<Record<Tracking, string>>,
  phases: {
    waiting: "Standby",
    recording: "Recording",
    paused: "Not recording",
    ended: "Dive ended",
  } satisfies Record<Phase, string>,
  images: "images",
  saved: (images: string) => `${images} saved`,
  missing: (images: string) => `${images} missing`,
  left: (room: string) => `${room} left`,
  dived: "dive time",
  submap: (number: number) => `part ${number + 1}`,
  unscaled: "no scale",
  scaled: { stereo: "stereo scale", laser: "laser scale", typed: "typed scale", altitude: "sonar scale", depth: "depth scale", poses: "given scale" },
  gauges: { recording: "Recording", tracking: "Tracking", clock: "Time" },
  quantities: {
    altitude: "Height",
    speed: "Speed",
    overlap: "Overlap",
    depth: "Depth",
    heading: "Heading",
    battery: "Battery",
    free_space: "Free space",
    recording_left: "Recording time left",
    blur: "Blur",
    brightness: "Light",
    temperature: "Board",
    utc: "Time",
  } satisfies Record<Quantity, string>,
  tooLow: {
    altitude: { text: "go higher", icon: "up" },
    overlap: { text: "slower", icon: "slower" },
    battery: { text: "low", icon: "warning" },
    brightness: { text: "more light", icon: "light" },
  } satisfies Partial<Record<Quantity, Advice>> as Partial<Record<Quantity, Advice>>,
  tooHigh: {
    altitude: { text: "go lower", icon: "down" },
    speed: { text: "slower", icon: "slower" },
    blur: { text: "blurred: slower", icon: "slower" },
    brightness: { text: "too bright", icon: "light" },
  } satisfies Partial<Record<Quantity, Advice>> as Partial<Record<Quantity, Advice>>,
  north: "N",
  link: { connecting: "Connecting", live: "Live", lost: "No link" },
  linkLost: "what you see is not up to date",
  counts: { cameras: "cameras", tiePoints: "tie points", planes: "planes", mosaicTiles: "mosaic tiles" },
  tools: {
    map: "Map",
    scene: "3D",
    picture: "Image",
    all: "All",
    follow: "Follow",
    closer: "Closer",
    farther: "Farther",
    top: "Top",
    hand: "Tools",
    layers: "Layers",
    alerts: "Alerts",
    menu: "Menu",
  },
  layers: {
    title: "Layers",
    mosaic: "Mosaic",
    quads: "Image planes",
    points: "Planes as points",
    tiePoints: "Tie points",
    cameras: "Cameras and path",
    coverage: "Coverage and gaps",
    plan: "Plan and lanes",
    marks: "Marks",
  },
  coverage: ["Gap", "1 view", "2 views", "3 and more"],
  guide: {
    label: "Coverage",
    covered: (part: string, area: string) => `${part} of ${area}`,
    gap: (distance: string, area: string) => `gap ${distance}, ${area}`,
    noGap: "no gap",
    lane: (lane: number, of: number) => `lane ${lane} of ${of}`,
    onLane: "on it",
    left: (distance: string) => `${distance} to the left`,
    right: (distance: string) => `${distance} to the right`,
  },
  alerts: {
    none: "No alerts",
    image: (image: number) => `image ${image}`,
    acknowledge: "Seen",
    more: (count: number) => `${count} more`,
  },
  hands: {
    ruler: "Ruler",
    mark: "Mark a point",
    markHere: "Mark here",
    probe: "What is here?",
    screenshot: "Screenshot",
    rulerHint: "Tap two points",
    rulerNext: "Tap the other end",
    markHint: "Tap the point",
    probeHint: "Tap the ground",
    nothing: "No ground there",
    done: "Done",
    length: (length: string, sigma: string) => `${length} ± ${sigma}`,
    lengthUnknown: (length: string) => `${length} ± unknown`,
    probeText: (image: number, time: string, distance: string, pixel: string) =>
      `Image ${image} at ${time}, ${distance} away, ${pixel} a pixel`,
    seenBy: (count: number) => `seen by ${count} images`,
    note: "Note",
    save: "Save",
    cancel: "Cancel",
    remove: "Remove",
  },
  marks: { title: "Mark", none: "No marks yet", photo: "Photograph", at: (time: string) => `at ${time}` },
  menu: {
    dive: "Dive",
    dives: "Dives",
    system: "System",
    look: "Display",
  },
  control: {
    controller: (name: string) => (name === "" ? "Nobody controls the device" : `In control: ${name}`),
    you: "this screen",
    name: "Your name",
    noToken: "Only a screen that knows the device's code may change anything: scan the code on the device's own screen, or open the address that nadir token prints.",
    asking: "Asking the device …",
    unreachable: "The device does not answer",
    refused: "The device refused",
    take: "Take control",
    takeOver: "Take over",
    release: "Give control back",
    start: "Start a dive",
    stop: "End the dive",
    stopSure: "End the dive? What was recorded is kept.",
    submap: "New part of the map",
    shutDown: "Shut down",
    shutDownSure: "End the dive and switch the device off?",
    replay: "This is a replay: there is no dive to begin or end.",
    done: (time: string) => `Done at ${time}`,
    code: "Scan this with a tablet on the same network: it may then control the device.",
    showCode: "Code for a tablet",
    noCode: "The code is shown on the device's own screen only, and by the command nadir token.",
  },
  dives: {
    none: "No dives yet",
    view: "Look at it",
    files: "Files",
    archive: "Everything",
    folder: (name: string, files: string, size: string) => `${name}: ${files} files, ${size}, in Everything`,
    remove: "Delete",
    removeNow: "Delete for ever",
    sure: (name: string) => `Delete ${name} with all its images and maps? This cannot be undone.`,
    cutOff: "cut off",
    images: (images: string) => `${images} images`,
  },
  recorded: {
    title: "Recorded dive",
    live: "Back to the live view",
    opening: "is being opened",
    reading: (images: string) => `is being read, ${images} images so far`,
    read: (images: string) => `${images} images, read to its end`,
    letGo: (parts: string) => `too large to be shown whole: ${parts} parts left out, its oldest colours and points first`,
    gone: "is not on the device any more",
    busy: "waits until another recorded dive is closed: two are open, and watched",
    unreachable: "the device does not answer",
    reads: "Reading",
    control: "A recorded dive is shown. Go back to the live view to begin or end one.",
  },
  themes: { dark: "Dark", light: "Sunlight", night: "Night (red)" },
  sound: "Sound and vibration",
  ghost: "Last good view",
  wayBack: (distance: string, sigma: string) => `Swim ${distance} ± ${sigma} this way`,
  wayUnknown: "Swim back the way you came until this view fits",
  system: {
    heads: ["Stage", "Per s", "Queue", "Dropped", "ms", "95 %"],
    ignored: (count: number) => `${count} messages not understood`,
    none: "No figures yet",
    stages: "Stages",
    map: "The map",
    input: "Source",
  },
  equipment: { none: "The equipment is checked on a live dive" },
  live: { title: "Image", open: "Open the image view", none: "No image yet", late: (seconds: number) => `${seconds} s late`, caption: (image: number) => `image ${image}`, tiePoints: (count: string) => `${count} tie points` },
  close: "Close",
  back: "Back",
  no3d: "This browser cannot draw in 3D (WebGL 2). State, alerts and the current image work.",
  canvas: "Map of the dive. Arrow keys move, plus and minus zoom, M map, 3 for 3D, I image, F follow, A all.",
  unit: "u",
  units: "units",
} as const;

const grouped = new Intl.NumberFormat("en", { maximumFractionDigits: 0 });

export function count(value: number): string {
  return grouped.format(value).replaceAll(",", "\u202f");
}

/** Three digits are what a diver can read and what most figures are good for. */
export function amount(value: number, unit: string): string {
  const size = Math.abs(value);
  const digits = size >= 100 ? 0 : size >= 10 ? 1 : 2;
  return `${value.toFixed(digits)} ${unit}`;
}

export function share(value: number): string {
  return `${Math.round(100 * value)} %`;
}

export function clock(seconds: number): string {
  if (seconds > 1e8) return new Date(seconds * 1000).toISOString().slice(11, 19);
  const whole = Math.floor(seconds);
  const [hours, minutes] = [Math.floor(whole / 3600), Math.floor(whole / 60) % 60];
  const rest = String(whole % 60).padStart(2, "0");
  return hours > 0 ? `${hours}:${String(minutes).padStart(2, "0")}:${rest}` : `${minutes}:${rest}`;
}
