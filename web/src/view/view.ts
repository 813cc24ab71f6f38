// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import { Box3, Color, ColorManagement, LinearSRGBColorSpace, Raycaster, Scene, Vector2, Vector3, WebGLRenderer } from "three";
import type { DiveRecord, Pose, Vec3 } from "../wire/records";
import { Budget, QUALITIES, type Quality } from "./budget";
import { Cameras, forward, reach } from "./cameras";
import { CoarsePicture } from "./coarse_picture";
import { Coverage } from "./coverage";
import { Extent } from "./extent";
import { Eye, type Look, type Margins } from "./eye";
import { footprint } from "./footprint";
import { Ground, type Ray, type Sight } from "./ground";
import { Mosaics } from "./mosaics";
import { Origin } from "./origin";
import { Pace } from "./pace";
import { Planes, pointOf, type PlaneStyle } from "./planes";
import { Rounds } from "./rounds";
import { Strokes } from "./strokes";
import { listenForTaps } from "./taps";
import { TiePointCloud } from "./tie_points";

// Pictures reach the screen as they are: nothing is converted on the way in or out.
ColorManagement.enabled = false;

export interface Layers {
  mosaic: boolean;
  planes: PlaneStyle | "off";
  tiePoints: boolean;
  cameras: boolean;
  coverage: boolean;
  plan: boolean;
}

/** What lies under a finger. */
export interface Pick {
  point: Vec3;
  /** Images that show it, the nearest camera first. */
  sights: Sight[];
}

export interface Counts {
  cameras: number;
  tiePoints: number;
  planes: number;
  mosaicTiles: number;
}

/** What the eye keeps in sight: everything, the vehicle, or what the viewer chose. */
export type Framing = "all" | "follow" | "free";

const BACKGROUND = 0x0b1418;
const VEHICLE_PX = 44;
/** Where style.css puts the cards over the map. */
const LANDSCAPE: Margins = { left: 24, top: 24, right: 24, bottom: 120 };
const PORTRAIT: Margins = { left: 24, top: 24, right: 24, bottom: 220 };
/** The eye goes no further after a pause than after this. */
const LONGEST_STEP_S = 0.25;

/** The dive in three dimensions. Draws only when something has changed. */
export class View {
  readonly layers: Record<Look, Layers> = {
    scene: { mosaic: true, planes: "quads", tiePoints: true, cameras: true, coverage: false, plan: false },
    map: { mosaic: true, planes: "off", tiePoints: false, cameras: true, coverage: true, plan: true },
  };
  /** Told when the viewer's own hand ended a framing. */
  onFraming: (framing: Framing) => void = () => undefined;
  /** Told after each picture drawn. */
  onDrawn: () => void = () => undefined;
  /** Told where the map was tapped, CSS px from the canvas's upper left corner. */
  onTap: (x: number, y: number) => void = () => undefined;
  readonly eye: Eye;
  readonly pace: Pace;
  private readonly origin = new Origin();
  readonly cameras = new Cameras(this.origin);
  private readonly mosaics = new Mosaics(this.origin);
  private readonly planes = new Planes(this.origin);
  private readonly tiePoints = new TiePointCloud(this.origin);
  private readonly coverage = new Coverage(this.origin);
  private readonly strokes = new Strokes(this.origin);
  private readonly ground = new Ground();
  private readonly budget = new Budget();
  private quality: Quality = QUALITIES[0];
  private readonly scene = new Scene();
  private readonly renderer: WebGLRenderer;
  private readonly coarsePicture: CoarsePicture;
  private readonly extent = new Extent(this.origin);
  private framing: Framing = "all";
  private footprintIsStale = false;
  private readonly refinements = new Rounds(() => void this.refine());
  private jumps = false;

  /** Throws where the browser cannot draw in 3D. */
  constructor(private readonly canvas: HTMLCanvasElement) {
    this.renderer = new WebGLRenderer({ canvas, antialias: true, powerPreference: "low-power" });
    this.renderer.debug.checkShaderErrors = import.meta.env.DEV;  // asking for them waits for the compiler
    this.renderer.outputColorSpace = LinearSRGBColorSpace;
    this.coarsePicture = new CoarsePicture(this.renderer);
    this.planes.isCatchingUp = () => this.pace.isCatchingUp();
    this.pace = new Pace(this.renderer.getContext() as WebGL2RenderingContext, (now, seconds) => this.render(now, seconds));
    this.scene.background = new Color(BACKGROUND);
    this.scene.add(
      this.mosaics.object,
      this.planes.object,
      this.tiePoints.object,
      this.cameras.object,
      this.cameras.vehicle,
      this.coverage.object,
      this.strokes.plan,
      this.strokes.footprint,
      this.strokes.tools,
    );
    listenForTaps(canvas, (x, y) => {
      this.onTap(x, y);
    });
    this.applyLayersOf("scene");
    this.eye = new Eye(canvas);
    this.eye.onMoved = (how) => {
      const isChosen = how === "panned" || (how === "zoomed" && this.framing === "all");
      if (isChosen && !this.extent.box.isEmpty()) this.setFraming("free");
      this.draw();
    };
    this.budget.onRest = () => {
      this.draw();
    };
    new ResizeObserver(() => {
      this.resize();
    }).observe(canvas);  // and now
  }

  get counts(): Counts {
    return {
      cameras: this.cameras.count,
      tiePoints: this.tiePoints.count,
      planes: this.planes.count,
      mosaicTiles: this.mosaics.count,
    };
  }

  /** Planes that are drawn cell by cell. */
  get finePlanes(): number {
    return this.planes.fineCount;
  }

  hasPlane(image: number): boolean {
    return this.planes.has(image);
  }

  /** Rejects when a picture in the record cannot be decoded. */
  async show(record: DiveRecord): Promise<void> {
    switch (record.type) {
      case "camera":
        this.cameras.setCamera(record);
        this.footprintIsStale = true;
        break;
      case "pose":
        this.cameras.setPose(record);
        if (this.cameras.newest !== null) this.strokes.setVehicle(this.cameras.newest.position);
        this.footprintIsStale = true;
        this.extent.include(record.position);
        this.extent.include(reach(record.position, forward(record), this.extent.range));
        break;
      case "tie_points":
        this.tiePoints.set(record);
        break;
      case "plane_grid": {
        this.ground.set(record);
        this.footprintIsStale = true;
        const centre = pointOf(record, record.columns / 2, record.rows / 2);
        if (centre !== null) this.extent.measure(record.camera, centre);
        this.coverage.setHeight(this.extent.groundHeight ?? 0);
        await this.planes.setGrid(record);
        break;
      }
      case "plane_colour":
        await this.planes.setColour(record);
        break;
      case "mosaic":
        this.mosaics.setMosaic(record);
        break;
      case "mosaic_tile":
        this.mosaics.cornersOf(record).forEach((corner) => { this.extent.include(corner); });
        await this.mosaics.setTile(record);
        break;
      case "mosaic_overview":
        await this.mosaics.setOverview(record);
        break;
      case "coverage_tile":
        await this.coverage.setTile(record);
        break;
      case "guidance":
        this.strokes.setGuidance(record, this.extent.groundHeight ?? 0);
        if (this.extent.groundHeight !== null) for (const [x, y] of record.plan) this.extent.include([x, y, this.extent.groundHeight]);
        break;
      case "state":
        this.cameras.setLost(record.tracking === "lost" && !record.finished);
        this.footprintIsStale = true;
        break;
      default:
        return;
    }
    this.pace.drawNews();
  }

  clear(): void {
    for (const part of [this.mosaics, this.planes, this.tiePoints, this.cameras, this.coverage, this.strokes, this.ground, this.extent]) part.clear();
    this.origin.forget();
    if (this.framing === "free") this.setFraming("all");  // what it looked at is gone
    this.draw();
  }

  setLook(look: Look): void {
    this.eye.setLook(look);
    this.applyLayers();
  }

  setFraming(framing: Framing): void {
    this.framing = framing;
    if (framing === "follow") this.eye.zoomTo(4 * (this.extent.range || 1));
    this.onFraming(framing);
    this.draw();
  }

  applyLayers(): void {
    this.applyLayersOf(this.eye.look);
    this.draw();
  }

  private applyLayersOf(look: Look): void {
    const layers = this.layers[look];
    this.mosaics.object.visible = layers.mosaic;
    this.planes.object.visible = layers.planes !== "off";
    if (layers.planes !== "off") this.planes.setStyle(layers.planes);
    this.tiePoints.object.visible = layers.tiePoints;
    this.cameras.object.visible = this.cameras.vehicle.visible = layers.cameras;
    this.cameras.setPyramids(look === "scene");
    this.coverage.object.visible = layers.coverage;
    this.strokes.plan.visible = layers.plan;
    this.strokes.footprint.visible = layers.cameras;
  }

  /** Looks straight down on what is in sight. */
  lookDown(): void {
    this.eye.lookDown();
    this.draw();
  }

  setBackground(colour: string): void {
    (this.scene.background as Color).setStyle(colour);
    this.draw();
  }

  setRuler(ends: readonly Vec3[]): void {
    this.strokes.setRuler(ends);
    this.draw();
  }

  /** The ground at a place of the canvas, CSS px from its upper left corner; null where there is none. */
  pick(x: number, y: number): Pick | null {
    const ray = this.rayThrough(x, y);
    const sights = this.ground.sights(ray);
    if (sights.length === 0) {
      const point = this.mosaics.meet(ray);
      return point === null ? null : { point, sights };
    }
    const first = sights.reduce((one, other) => (other.along < one.along ? other : one));
    sights.sort((one, other) => one.distance - other.distance);
    const best = this.eye.look === "map" ? sights[0] : first;
    return { point: (best ?? first).point, sights };
  }

  /** What the canvas shows, as a PNG file. */
  async screenshot(): Promise<Blob | null> {
    this.setQuality(QUALITIES[0]);
    this.renderer.render(this.scene, this.eye.camera);
    return new Promise((resolve) => {
      this.canvas.toBlob(resolve, "image/png");
    });
  }

  /** The ground that a camera looks at. */
  below(pose: Pose): Vec3 {
    const direction = forward(pose);
    const sights = this.ground.sights({ from: pose.position, direction });
    const first = sights.sort((one, other) => one.along - other.along)[0];
    return first?.point ?? reach(pose.position, direction, this.extent.range);
  }

  /** Shows the whole of one mosaic from above. False: it has no tiles yet. */
  fitMosaic(mosaic: number): boolean {
    const box = new Box3();
    for (const corner of this.mosaics.corners(mosaic)) box.expandByPoint(this.vector(corner));
    if (box.isEmpty()) return false;
    this.setLook("map");
    this.setFraming("free");
    this.eye.fit(box, 0);
    this.draw();
    return true;
  }

  /** Canvas position, CSS px from its upper left corner, of a survey point; null behind the eye. */
  screenOf(x: number, y: number, z: number): { x: number; y: number } | null {
    const at = this.vector([x, y, z]).project(this.eye.camera);
    if (Math.abs(at.z) > 1) return null;
    return { x: (0.5 + at.x / 2) * this.canvas.clientWidth, y: (0.5 - at.y / 2) * this.canvas.clientHeight };
  }

  draw(): void {
    this.pace.draw();
  }

  /** All that was told at once is here. */
  arrive(): void {
    this.jumps = true;
    this.draw();
  }

  /** True while the eye is on its way. */
  private render(now: number, seconds: number): boolean {
    if (!this.pace.isCatchingUp()) this.setQuality(this.budget.begin(now));
    this.cameras.update();
    this.drawFootprint();
    this.cameras.setSize(0.2 * (this.extent.range || 1));
    // While much is told, the eye jumps: what it would pass on its way is drawn for nothing.
    const moving = this.frame(this.jumps || this.pace.isCatchingUp() ? 0 : Math.min(LONGEST_STEP_S, seconds));
    this.jumps = false;
    this.eye.setScene(this.extent.box, this.extent.range);
    const vehicle = this.cameras.vehicle;
    vehicle.scale.setScalar(this.cameras.newest === null ? 0 : VEHICLE_PX * this.eye.sizeOfPixel(vehicle.position));
    if (this.quality.resolution < 1) this.coarsePicture.render(this.scene, this.eye.camera, this.quality.resolution);
    else this.renderer.render(this.scene, this.eye.camera);
    this.onDrawn();
    if (this.pace.isCatchingUp()) this.refinements.hold();
    else this.refinements.soon(now);
    return moving;
  }

  private async refine(): Promise<void> {
    const refined = [];
    if (this.planes.object.visible) refined.push(this.planes.refine(this.eye.target));
    if (this.mosaics.object.visible) refined.push(this.mosaics.refine(this.eye.sizer()));
    const changed = await Promise.all(refined).catch(() => [false]);
    if (changed.includes(true)) this.pace.drawNews();
  }

  private setQuality(quality: Quality): void {
    this.quality = quality;
    this.planes.setCoarseness(quality.stride);
  }

  /** Steers towards what is to be in sight; true while on the way. */
  private frame(seconds: number): boolean {
    if (this.framing === "follow" && this.cameras.newest !== null) {
      return this.eye.follow(this.cameras.vehicle.position, seconds);
    }
    if (this.framing === "all" && !this.extent.box.isEmpty()) return this.eye.fit(this.extent.box, seconds);
    return false;
  }

  private rayThrough(x: number, y: number): Ray {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const caster = new Raycaster();
    caster.setFromCamera(new Vector2((2 * x) / width - 1, 1 - (2 * y) / height), this.eye.camera);
    const { origin, direction } = caster.ray;
    const at = this.origin.point;
    return { from: [origin.x + at[0], origin.y + at[1], origin.z + at[2]], direction: [direction.x, direction.y, direction.z] };
  }

  /** What the vehicle's camera sees of the newest ground that was found. */
  private drawFootprint(): void {
    if (!this.footprintIsStale) return;
    this.footprintIsStale = false;
    const { newest, camera } = this.cameras;
    const ground = this.ground.newest;
    const isKnown = newest !== null && !this.cameras.isLost && ground?.submap === newest.submap;
    const corners = isKnown && camera !== null ? footprint(newest, camera, ground) : [];
    corners.forEach((corner) => { this.extent.include(corner); });
    this.strokes.setFootprint(corners);
  }

  private vector(inSurvey: Vec3): Vector3 {
    return new Vector3(...this.origin.toScene(inSurvey));
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (width === 0 || height === 0) return;
    const ratio = Math.min(devicePixelRatio, 2);
    if (ratio !== this.renderer.getPixelRatio()) this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(width, height, false);
    this.eye.resize(width, height, width > height ? LANDSCAPE : PORTRAIT);
    this.draw();
  }
}
