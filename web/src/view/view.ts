// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import { Box3, Color, ColorManagement, LinearSRGBColorSpace, Scene, Vector3, WebGLRenderer } from "three";
import type { DiveRecord, Vec3 } from "../wire/records";
import { Cameras, forward } from "./cameras";
import { Eye, type Look, type Margins } from "./eye";
import { Mosaics } from "./mosaics";
import { Origin } from "./origin";
import { Planes, pointOf, type PlaneStyle } from "./planes";
import { TiePointCloud } from "./tie_points";

// Pictures reach the screen as they are: nothing is converted on the way in or out.
ColorManagement.enabled = false;

export interface Layers {
  mosaic: boolean;
  planes: PlaneStyle | "off";
  tiePoints: boolean;
  cameras: boolean;
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
const VEHICLE_PX = 34;
/** Where style.css puts the page's cards. */
const LANDSCAPE: Margins = { left: 388, top: 16, right: 104, bottom: 96 };
const PORTRAIT: Margins = { left: 16, top: 190, right: 104, bottom: 100 };

/** The dive in three dimensions. Draws only when something has changed. */
export class View {
  readonly layers: Record<Look, Layers> = {
    scene: { mosaic: true, planes: "quads", tiePoints: true, cameras: true },
    map: { mosaic: true, planes: "off", tiePoints: false, cameras: true },
  };
  /** Told when the viewer's own hand ended a framing. */
  onFraming: (framing: Framing) => void = () => undefined;
  /** Told after each picture drawn. */
  onDrawn: () => void = () => undefined;
  readonly eye: Eye;
  private readonly origin = new Origin();
  private readonly mosaics = new Mosaics(this.origin);
  private readonly planes = new Planes(this.origin);
  private readonly tiePoints = new TiePointCloud(this.origin);
  private readonly cameras = new Cameras(this.origin);
  private readonly scene = new Scene();
  private readonly renderer: WebGLRenderer;
  /** Distance from the camera to the ground of late, metres. */
  private range = 0;
  private bounds = new Box3();
  private framing: Framing = "all";
  private asked = false;
  private drawnAt = 0;

  /** Throws where the browser cannot draw in 3D. */
  constructor(private readonly canvas: HTMLCanvasElement) {
    this.renderer = new WebGLRenderer({ canvas, antialias: true, powerPreference: "low-power" });
    this.renderer.outputColorSpace = LinearSRGBColorSpace;
    this.scene.background = new Color(BACKGROUND);
    this.scene.add(
      this.mosaics.object,
      this.planes.object,
      this.tiePoints.object,
      this.cameras.object,
      this.cameras.vehicle,
    );
    this.eye = new Eye(canvas);
    this.eye.onMoved = (how) => {
      if (how === "panned" || (how === "zoomed" && this.framing === "all")) this.setFraming("free");
      this.draw();
    };
    new ResizeObserver(() => {
      this.resize();
    }).observe(canvas);
    this.resize();
  }

  get counts(): Counts {
    return {
      cameras: this.cameras.count,
      tiePoints: this.tiePoints.count,
      planes: this.planes.count,
      mosaicTiles: this.mosaics.count,
    };
  }

  /** Rejects when a picture in the record cannot be decoded. */
  async show(record: DiveRecord): Promise<void> {
    switch (record.type) {
      case "camera":
        this.cameras.setShape(record);
        break;
      case "pose":
        this.cameras.setPose(record);
        this.include(record.position);
        this.include(reach(record.position, forward(record), this.range));
        break;
      case "tie_points":
        this.tiePoints.set(record);
        break;
      case "plane_grid": {
        this.planes.setGrid(record);
        const centre = pointOf(record, record.columns / 2, record.rows / 2);
        if (centre !== null) this.measureRange(record.camera, centre);
        break;
      }
      case "plane_colour":
        await this.planes.setColour(record);
        break;
      case "mosaic":
        this.mosaics.setMosaic(record);
        break;
      case "mosaic_tile":
        await this.mosaics.setTile(record);
        break;
      case "state":
        this.cameras.setLost(record.tracking === "lost" && !record.finished);
        break;
      default:
        return;
    }
    this.draw();
  }

  clear(): void {
    for (const part of [this.mosaics, this.planes, this.tiePoints, this.cameras]) part.clear();
    this.origin.forget();
    this.bounds = new Box3();
    this.range = 0;
    this.draw();
  }

  setLook(look: Look): void {
    this.eye.setLook(look);
    this.applyLayers();
  }

  setFraming(framing: Framing): void {
    this.framing = framing;
    if (framing === "follow") this.eye.zoomTo(4 * (this.range || 1));
    this.onFraming(framing);
    this.draw();
  }

  applyLayers(): void {
    const layers = this.layers[this.eye.look];
    this.mosaics.object.visible = layers.mosaic;
    this.planes.object.visible = layers.planes !== "off";
    if (layers.planes !== "off") this.planes.setStyle(layers.planes);
    this.tiePoints.object.visible = layers.tiePoints;
    this.cameras.object.visible = this.cameras.vehicle.visible = layers.cameras;
    this.cameras.setPyramids(this.eye.look === "scene");
    this.draw();
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

  /** Where an image was taken from, survey; null when it has no camera. */
  placeOf(image: number): Vec3 | null {
    return this.cameras.poses.get(image)?.position ?? null;
  }

  /** Canvas position, CSS px from its upper left corner, of a survey point; null behind the eye. */
  screenOf(x: number, y: number, z: number): { x: number; y: number } | null {
    const at = this.vector([x, y, z]).project(this.eye.camera);
    if (Math.abs(at.z) > 1) return null;
    return { x: (0.5 + at.x / 2) * this.canvas.clientWidth, y: (0.5 - at.y / 2) * this.canvas.clientHeight };
  }

  draw(): void {
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame((now) => {
      this.render(now);
    });
  }

  private render(now: number): void {
    this.asked = false;
    const seconds = Math.min(0.25, (now - this.drawnAt) / 1000);
    this.drawnAt = now;
    this.cameras.update();
    this.cameras.setSize(0.2 * (this.range || 1));
    const moving = this.frame(seconds);
    this.eye.clip(this.bounds);
    const vehicle = this.cameras.vehicle;
    vehicle.scale.setScalar(this.cameras.newest === null ? 0 : VEHICLE_PX * this.eye.sizeOfPixel(vehicle.position));
    this.renderer.render(this.scene, this.eye.camera);
    this.onDrawn();
    if (moving) this.draw();
  }

  /** Steers towards what is to be in sight; true while on the way. */
  private frame(seconds: number): boolean {
    if (this.framing === "follow" && this.cameras.newest !== null) {
      return this.eye.follow(this.cameras.vehicle.position, seconds);
    }
    if (this.framing === "all" && !this.bounds.isEmpty()) return this.eye.fit(this.bounds, seconds);
    return false;
  }

  private include(point: Vec3): void {
    this.bounds.expandByPoint(this.vector(point));
  }

  private measureRange(camera: Vec3, ground: Vec3): void {
    const range = Math.hypot(camera[0] - ground[0], camera[1] - ground[1], camera[2] - ground[2]);
    this.range = this.range === 0 ? range : 0.9 * this.range + 0.1 * range;
    this.include(ground);
  }

  private vector(inSurvey: Vec3): Vector3 {
    return new Vector3(...this.origin.toScene(inSurvey));
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (width === 0 || height === 0) return;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.eye.resize(width, height, width > height ? LANDSCAPE : PORTRAIT);
    this.draw();
  }
}

function reach(from: Vec3, direction: Vec3, distance: number): Vec3 {
  return [
    from[0] + distance * direction[0],
    from[1] + distance * direction[1],
    from[2] + distance * direction[2],
  ];
}
