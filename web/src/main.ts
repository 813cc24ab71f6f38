// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import "./style.css";
import { Link, type LinkState } from "./link";
import { Alerts } from "./ui/alerts";
import { byId } from "./ui/dom";
import { Equipment } from "./ui/equipment";
import { LivePicture } from "./ui/live";
import { ScaleBar } from "./ui/scale_bar";
import { CountStrip, LinkChip, StatusCard } from "./ui/status";
import { S } from "./ui/strings";
import { Tools } from "./ui/tools";
import { View } from "./view/view";
import type { DiveRecord, State } from "./wire/records";

let state: State | null = null;
let linkState: LinkState = "connecting";
let undecodable = 0;

const view = openView();
const status = new StatusCard();
const chip = new LinkChip();
const counts = new CountStrip();
const scaleBar = new ScaleBar();
const alerts = new Alerts();
const equipment = new Equipment();
const tools = new Tools(view, alerts, equipment);
const live = new LivePicture(() => ++undecodable);

const link = new Link(feedAddress(), {
  record: receive,
  newFeed: () => {
    state = null;
    link.mayBeSilent = false;
    view?.clear();
    alerts.clear();
    equipment.clear();
    tools.showAlerts();
    tools.showEquipment();
  },
  state: (now) => {
    linkState = now;
    chip.show(now);
  },
});
tools.ignored = () => link.ignored + undecodable;
link.connect();

addEventListener("online", () => {
  link.hurry();
});
document.addEventListener("visibilitychange", () => {
  if (!document.hidden) link.hurry();
});

function openView(): View | null {
  const canvas = byId("canvas") as HTMLCanvasElement;
  canvas.setAttribute("aria-label", S.canvas);
  try {
    const opened = new View(canvas);
    opened.onDrawn = () => {
      counts.show(opened.counts);
      if (opened.eye.look === "map") scaleBar.show(opened.eye.unitsPerPixel);
    };
    return opened;
  } catch {
    canvas.replaceWith(Object.assign(document.createElement("p"), { className: "no3d", textContent: S.no3d }));
    return null;
  }
}

function feedAddress(): string {
  const address = new URL("feed", location.href);
  address.protocol = location.protocol === "https:" ? "wss:" : "ws:";
  return address.href;
}

function receive(record: DiveRecord): void {
  if (record.type === "state") {
    state = record;
    link.mayBeSilent = record.finished;
    status.show(record);
    scaleBar.setState(record);
  } else if (record.type === "alert") {
    alerts.add(record, link.isCurrent);
    tools.showAlerts();
  } else if (record.type === "live_image") {
    live.show(record);
  } else if (record.type === "statistics") {
    tools.showStatistics(record);
  } else if (record.type === "check") {
    equipment.show(record);
    tools.showEquipment();
  }
  view?.show(record).catch(() => ++undecodable);
}

/** The page's automation interface: what a test, or a curious surveyor at the console, may ask. Coordinates are
 *  survey coordinates; positions CSS pixels from the canvas's upper left corner. */
const automation = {
  /** What the scene holds: cameras, tiePoints, planes, mosaicTiles. */
  get counts() {
    return view?.counts ?? { cameras: 0, tiePoints: 0, planes: 0, mosaicTiles: 0 };
  },
  /** The newest state record, or null. */
  get state() {
    return state;
  },
  /** "connecting", "live" or "lost". */
  get link() {
    return linkState;
  },
  /** Messages that were no record, and pictures that could not be decoded. */
  get ignored() {
    return link.ignored + undecodable;
  },
  /** Alerts known. */
  get alerts() {
    return alerts.count;
  },
  /** Where an image was taken from; null when it has no camera. */
  placeOf: (image: number) => view?.placeOf(image) ?? null,
  /** Where a survey point is on the canvas; null behind the eye. */
  screenOf: (x: number, y: number, z: number) => view?.screenOf(x, y, z) ?? null,
  /** Goes to the map and shows the whole of a mosaic; false when it has no tiles. */
  fitMosaic: (mosaic = 0) => {
    const shown = view?.fitMosaic(mosaic) ?? false;
    if (shown) tools.setLook("map");
    return shown;
  },
};
declare global {
  interface Window {
    nadir: typeof automation;
  }
}
window.nadir = Object.freeze(automation);
