// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import "./style.css";
import { AlertLine } from "./alert_line";
import { Api } from "./api";
import { Arrival } from "./arrival";
import { Link, type LinkState } from "./link";
import { Alerts, levelOf, type Manner } from "./ui/alerts";
import { Control } from "./ui/control";
import { Dives } from "./ui/dives";
import { byId } from "./ui/dom";
import { Equipment } from "./ui/equipment";
import { Gauges } from "./ui/gauges";
import { Guide } from "./ui/guide";
import { Hands } from "./ui/hands";
import { Marks } from "./ui/marks";
import { handSheet, Menu } from "./ui/menu";
import { Picture } from "./ui/picture";
import { Pins } from "./ui/pins";
import { Rail, type Stage } from "./ui/rail";
import { Recorded, recordedDive } from "./ui/recorded";
import { ScaleBar } from "./ui/scale_bar";
import { layerSwitches, System } from "./ui/sheets";
import { S } from "./ui/strings";
import { Themes } from "./ui/theme";
import { getReady, unpacking } from "./view/images";
import { View } from "./view/view";
import { ALERT_TYPE } from "./wire/decode";
import type { Alert, DiveRecord, State } from "./wire/records";

let state: State | null = null;
let linkState: LinkState = "connecting";
let undecodable = 0;
/** Where the viewer was before the picture took the screen because tracking was lost. */
let stageBeforeLoss: Stage | null = null;

getReady();
const themes = new Themes();
const api = new Api();
const view = openView();
const gauges = new Gauges();
const recorded = recordedDive === null ? null : new Recorded(api, recordedDive);
const guide = new Guide();
const scaleBar = new ScaleBar();
const equipment = new Equipment();
const alerts = new Alerts();
const picture = new Picture(() => ++undecodable);
const system = new System(view, equipment);
const pins = new Pins((at) => view?.screenOf(...at) ?? null);
const hands = view === null ? null : new Hands(view, pins);
const rail: Rail = new Rail(view, {
  hand: () => handSheet(hands, marks, view, () => { rail.close(); }),
  layers: () => layerSwitches(view, picture, marks, rail.stage, () => { rail.refresh("layers"); }),
  alerts: () => alerts.list(),
  menu: () => menu.sheet(),
});
const marks = new Marks(api, pins, rail);
const menu = new Menu({ rail, themes, alerts, system, api, control: new Control(api, rail), dives: new Dives(api, rail) });

const alertLine = new AlertLine(socketAddress(`records?type=${ALERT_TYPE}`), receive);
const link = new Link(feedAddress(), {
  record: receive,
  newFeed: forget,
  state: (now) => {
    linkState = now;
    if (now === "live") {
      arrival.begin();
      void api.greet();
    } else if (now === "lost") {
      alertLine.end();
      arrival.end();
    }
    showLink();
    if (now === "lost") void recorded?.explain();
  },
  welcome: ({ feed }) => {
    if (recorded === null) alertLine.follow(feed, () => link.complete);
  },
  caughtUp: (letGo) => {
    recorded?.setLetGo(letGo);
    seeArrival();
  },
});
const arrival = new Arrival(() => view?.arrive());
if (view !== null) view.pace.isCatchingUp = () => arrival.isUnderWay;
wire();
link.connect();

function wire(): void {
  system.ignored = () => link.ignored + undecodable;
  rail.onStage = showStage;
  showStage(rail.stage);
  // Both can be reached.
  new ResizeObserver(() => { byId("panel").style.top = `${byId("alerts").offsetHeight}px`; }).observe(byId("alerts"));
  picture.onOpen = () => { rail.setStage("picture"); };
  alerts.onChange = () => {
    rail.setBubble("alerts", alerts.openCount);
    rail.refresh("alerts");
  };
  if (hands !== null) hands.onMark = (point, image) => { marks.begin(point, image); };
  themes.onChange = () => { view?.setBackground(groundColour()); };
  view?.setBackground(groundColour());
  // Where a browser allows no service worker the page works all the same.
  if ("serviceWorker" in navigator) navigator.serviceWorker.register("sw.js").catch(() => undefined);
  addEventListener("online", () => { link.hurry(); });
  document.addEventListener("visibilitychange", () => {
    if (!document.hidden) link.hurry();
  });
}

function showStage(stage: Stage): void {
  picture.isLarge = stage === "picture";
}

function groundColour(): string {
  return getComputedStyle(document.documentElement).getPropertyValue("--ground").trim();
}

function openView(): View | null {
  const canvas = byId("canvas") as HTMLCanvasElement;
  canvas.setAttribute("aria-label", S.canvas);
  canvas.setAttribute("role", "img");
  try {
    const opened = new View(canvas);
    opened.onDrawn = () => {
      pins.place();
      if (opened.eye.look === "map") scaleBar.show(opened.eye.unitsPerPixel);
    };
    return opened;
  } catch {
    canvas.replaceWith(Object.assign(document.createElement("p"), { id: "canvas", className: "no3d", textContent: S.no3d }));
    return null;
  }
}

/** The live feed, or that of the recorded dive the address names. */
function feedAddress(): string {
  return socketAddress(recordedDive === null ? "feed" : `feed?${new URLSearchParams({ dive: recordedDive }).toString()}`);
}

function socketAddress(path: string): string {
  const address = new URL(path, location.href);
  address.protocol = location.protocol === "https:" ? "wss:" : "ws:";
  return address.href;
}

/** The server is another run of itself. */
function forget(): void {
  state = null;
  link.mayBeSilent = false;
  for (const part of [recorded, view, gauges, guide, alerts, equipment, picture, system, marks, menu]) part?.clear();
  showLoss(false);
  hands?.take(null);
  rail.setBubble("menu", 0);
}

function receive(record: DiveRecord): void {
  // Whoever was lost in a recorded dive is not lost now.
  if (recorded !== null && record.type === "state" && record.tracking === "lost") record.tracking = "tracking";
  switch (record.type) {
    case "state":
      showState(record);
      break;
    case "alert":
      alerts.add(record, mannerOf(record));
      break;
    case "live_image":
      picture.show(record);
      break;
    case "statistics":
      system.setStatistics(record);
      rail.refreshPage(S.menu.system);
      break;
    case "check":
      equipment.show(record);
      rail.setBubble("menu", equipment.faults);
      rail.refreshPage(S.menu.system);
      break;
    case "measures":
      gauges.setMeasures(record);
      picture.setMeasures(record);
      break;
    case "recording":
      gauges.setRecording(record);
      menu.setRecording(record);
      recorded?.setRecording(record);
      marks.canBeMade = recorded === null;
      break;
    case "guidance":
      guide.setGuidance(record);
      break;
    case "mark":
      marks.set(record);
      break;
    case "last_view":
      picture.setLastView(record);
      break;
    case "way_back":
      picture.setWayBack(record);
      showLoss(record.lost);
      break;
    default:
      break;
  }
  view?.show(record).catch(() => ++undecodable).finally(seeArrival);
  if (record.type === "pose") guide.setVehicle(view?.cameras.newest ?? record);
}

function mannerOf(alert: Alert & { sequence: number }): Manner {
  // Those of a recorded dive are old, but for what is said of the reading once it has ended.
  if (recorded !== null) return recorded.isWhole ? "quiet" : "listed";
  if (link.isNews(alert.sequence)) return "loud";
  // Whoever comes late is to see what is still bad.
  return levelOf(alert) === "bad" ? "quiet" : "listed";
}

function seeArrival(): void {
  if (link.isCurrent && unpacking() === 0) arrival.end();
}

function showState(record: State): void {
  state = record;
  link.mayBeSilent = record.finished;
  for (const part of [recorded, gauges, guide, scaleBar, system, hands, picture, alerts]) part?.setState(record);
  if (record.finished) showLink();
}

/** What is whole needs no link to be up to date. */
function showLink(): void {
  gauges.setLink(recorded?.isWhole === true ? "live" : linkState);
}

/** A lost diver sees what the camera sees and the view to be found again, and then what was on the screen before. */
function showLoss(lost: boolean): void {
  if (lost && stageBeforeLoss === null) {
    stageBeforeLoss = rail.stage;
    rail.setStage("picture");
  } else if (!lost && stageBeforeLoss !== null) {
    if (rail.stage === "picture") rail.setStage(stageBeforeLoss);
    stageBeforeLoss = null;
  }
}

/** The page's automation interface: what a test, or a curious surveyor at the console, may ask. Coordinates are
 *  survey coordinates; positions CSS pixels of the page. */
const automation = {
  /** What the scene holds: cameras, tiePoints, planes, mosaicTiles. */
  get counts() {
    return view?.counts ?? { cameras: 0, tiePoints: 0, planes: 0, mosaicTiles: 0 };
  },
  /** Planes that are drawn cell by cell. */
  get finePlanes() {
    return view?.finePlanes ?? 0;
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
  /** What was told so far is on the screen. */
  get isDrawn() {
    return unpacking() === 0 && (view?.pace.isSettled ?? true);
  },
  /** Alerts known. */
  get alerts() {
    return alerts.count;
  },
  /** Where an image was taken from; null when it has no camera. */
  placeOf: (image: number) => view?.cameras.poses.get(image)?.position ?? null,
  /** Whether an image's planar cloud is drawn. */
  hasPlane: (image: number) => view?.hasPlane(image) ?? false,
  /** Where a survey point is on the page; null behind the eye. */
  screenOf: (x: number, y: number, z: number) => {
    const at = view?.screenOf(x, y, z) ?? null;
    const box = byId("canvas").getBoundingClientRect();
    return at === null ? null : { x: at.x + box.left, y: at.y + box.top };
  },
  /** Goes to the map and shows the whole of a mosaic; false when it has no tiles. */
  fitMosaic: (mosaic = 0) => {
    const shown = view?.fitMosaic(mosaic) ?? false;
    if (shown) rail.setStage("map");
    return shown;
  },
};
declare global {
  interface Window {
    nadir: typeof automation;
  }
}
window.nadir = Object.freeze(automation);
