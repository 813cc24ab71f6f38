// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import { Box3, Frustum, Matrix4, MOUSE, OrthographicCamera, PerspectiveCamera, Sphere, TOUCH, Vector3 } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

/** In perspective from anywhere, or the map: straight down, north up, true to scale. */
export type Look = "scene" | "map";
export type Movement = "turned" | "zoomed" | "panned";

const FIELD_OF_VIEW = 45; // degrees, vertical
const FIT_MARGIN = 1.15;
const EASE_SECONDS = 0.35;
/** Of the cameras' distance from the ground: some ten pixels of an image fill the screen. */
const CLOSEST = 100;
/** Of what there is to be seen. */
const FARTHEST = 20;
const FIRST_DIRECTION = new Vector3(-0.55, -0.75, 0.75);

/** CSS px along the canvas's edges that lie behind the page's cards. */
export interface Margins {
  left: number;
  top: number;
  right: number;
  bottom: number;
}

/** From where, and how, the scene is looked at. Both cameras look at one target; what the map shows is as
 *  high as the perspective view at the target. */
export class Eye {
  look: Look = "scene";
  onMoved: (how: Movement) => void = () => undefined;
  private readonly perspective = new PerspectiveCamera(FIELD_OF_VIEW);
  private readonly orthographic = new OrthographicCamera();
  private readonly controls: OrbitControls;
  private width = 1;
  private height = 1;
  private free: Margins = { left: 0, top: 0, right: 0, bottom: 0 };
  private held = false;
  /** Of the span. */
  private limits = { least: 0, most: Infinity };
  /** Target and span as last set or told of. */
  private known = { target: new Vector3(), span: 1 };

  constructor(canvas: HTMLCanvasElement) {
    for (const camera of [this.perspective, this.orthographic]) camera.up.set(0, 0, 1);
    this.perspective.position.copy(FIRST_DIRECTION).multiplyScalar(8);
    this.orthographic.position.set(0, 0, 100);
    this.controls = new OrbitControls(this.perspective, canvas);
    this.controls.enableDamping = false;
    this.controls.screenSpacePanning = false;
    this.controls.maxPolarAngle = 0.49 * Math.PI;
    this.controls.listenToKeyEvents(canvas);
    this.controls.addEventListener("start", () => (this.held = true));
    this.controls.addEventListener("end", () => (this.held = false));
    this.controls.addEventListener("change", () => {
      this.tell();
    });
    this.setLook("scene");
  }

  get camera(): PerspectiveCamera | OrthographicCamera {
    return this.look === "map" ? this.orthographic : this.perspective;
  }

  /** Survey height of what is seen at the target. */
  get span(): number {
    if (this.look === "map") return this.height / this.orthographic.zoom;
    return this.perspective.position.distanceTo(this.controls.target) * heightPerDistance();
  }

  /** Survey units a CSS pixel covers at the target. */
  get unitsPerPixel(): number {
    return this.span / this.height;
  }

  /** Scene point that is looked at. */
  get target(): Vector3 {
    return this.controls.target;
  }

  /** Measures lengths on the screen, in CSS px: 0 when they are out of sight. */
  sizer(): (at: Vector3, length: number) => number {
    const { camera } = this;
    const seen = new Frustum().setFromProjectionMatrix(new Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse));
    return (at, length) => (seen.intersectsSphere(new Sphere(at, length)) ? length / this.sizeOfPixel(at) : 0);
  }

  setLook(look: Look): void {
    const { span } = this.known;
    this.look = look;
    const map = look === "map";
    this.controls.object = this.camera;
    this.controls.enableRotate = !map;
    this.controls.screenSpacePanning = map;
    this.controls.mouseButtons.LEFT = map ? MOUSE.PAN : MOUSE.ROTATE;
    this.controls.touches.ONE = map ? TOUCH.PAN : TOUCH.ROTATE;
    this.controls.touches.TWO = TOUCH.DOLLY_PAN;
    this.controls.minPolarAngle = 0;
    this.put(this.controls.target, span);
  }

  /** The target is kept in the middle of what the margins leave free. */
  resize(width: number, height: number, margins: Margins): void {
    const { span } = this.known;
    this.width = width;
    this.height = height;
    this.free = margins;
    const x = (margins.right - margins.left) / 2;
    const y = (margins.bottom - margins.top) / 2;
    this.perspective.setViewOffset(width, height, x, y, width, height);
    this.orthographic.setViewOffset(width, height, x, y, width, height);
    this.perspective.aspect = width / height;
    this.orthographic.left = -width / 2;
    this.orthographic.right = width / 2;
    this.orthographic.top = height / 2;
    this.orthographic.bottom = -height / 2;
    this.put(this.controls.target, span);
  }

  /** Turns the perspective view straight down, north up. */
  lookDown(): void {
    const { target } = this.controls;
    const distance = this.perspective.position.distanceTo(target);
    // Not quite straight, or which way is up on the screen would be undefined.
    this.perspective.position.copy(target).add(new Vector3(0, -1e-4 * distance, distance));
    this.put(target, this.span);
  }

  zoomTo(span: number): void {
    this.put(this.controls.target, span);
  }

  zoomBy(factor: number): void {
    this.put(this.controls.target, this.span / factor);
    this.onMoved("zoomed");
  }

  /** Moves towards seeing the whole box, at once when seconds is 0; true while not there yet. */
  fit(box: Box3, seconds: number): boolean {
    const centre = box.getCenter(new Vector3());
    return this.approach(centre, this.spanOf(box), seconds);
  }

  follow(target: Vector3, seconds: number): boolean {
    return this.approach(target, this.span, seconds);
  }

  /** What there is to be seen, and from how far the cameras see it: neither is left by a zoom. */
  setScene(box: Box3, range: number): void {
    const radius = box.getSize(new Vector3()).length() || 10;  // of one place, too
    this.limits = { least: (range || radius) / CLOSEST, most: FARTHEST * (radius + range) };
    this.controls.minDistance = this.limits.least / heightPerDistance();
    this.controls.maxDistance = this.limits.most / heightPerDistance();
    this.controls.minZoom = this.height / this.limits.most;
    this.controls.maxZoom = this.height / this.limits.least;
    const distance = this.camera.position.distanceTo(this.controls.target);
    this.camera.near = this.look === "map" ? -4 * (radius + distance) : distance / 200;
    this.camera.far = 4 * (radius + distance);
    this.camera.updateProjectionMatrix();
    this.camera.updateMatrixWorld();
  }

  /** Survey units a CSS pixel covers at a point. */
  sizeOfPixel(at: Vector3): number {
    if (this.look === "map") return 1 / this.orthographic.zoom;
    return (this.perspective.position.distanceTo(at) * heightPerDistance()) / this.height;
  }

  /** Of the whole canvas, so that the box fits in its free part. */
  private spanOf(box: Box3): number {
    const size = box.getSize(new Vector3());
    const across = this.width - this.free.left - this.free.right;
    const down = this.height - this.free.top - this.free.bottom;
    const perPixel =
      this.look === "map" ? Math.max(size.x / across, size.y / down) : size.length() / Math.min(across, 1.6 * down);
    return FIT_MARGIN * this.height * Math.max(perPixel, 1e-6);
  }

  private approach(target: Vector3, span: number, seconds: number): boolean {
    if (this.held) return false;
    const share = seconds === 0 ? 1 : 1 - Math.exp(-seconds / EASE_SECONDS);
    const to = this.controls.target.clone().lerp(target, share);
    const end = this.within(span);
    this.put(to, this.span * (end / this.span) ** share);
    return to.distanceTo(target) > 1e-3 * end || Math.abs(this.span - end) > 1e-3 * end;
  }

  private within(span: number): number {
    return Math.min(this.limits.most, Math.max(this.limits.least, span));
  }

  /** Keeps the direction. */
  private put(target: Vector3, wanted: number): void {
    const span = this.within(wanted);
    const direction = this.perspective.position.clone().sub(this.controls.target).normalize();
    this.controls.target.copy(target);
    this.perspective.position.copy(target).addScaledVector(direction, span / heightPerDistance());
    this.perspective.lookAt(target);
    this.orthographic.position.copy(target).setZ(target.z + 100);
    this.orthographic.rotation.set(0, 0, 0);
    this.orthographic.zoom = this.height / span;
    this.perspective.updateProjectionMatrix();
    this.orthographic.updateProjectionMatrix();
    this.known = { target: target.clone(), span };
  }

  /** What the viewer's hand did since last told. */
  private tell(): void {
    const { target } = this.controls;
    if (!Number.isFinite(target.lengthSq() + this.span)) {  // a hand on a canvas without height
      const { target: last, span } = this.known;
      target.copy(last);
      this.perspective.position.copy(last).add(FIRST_DIRECTION);
      this.put(last, span);
      return;
    }
    const moved = target.clone().sub(this.known.target);
    if (this.look === "map") this.perspective.position.add(moved);
    const tolerance = 1e-6 * this.known.span;
    const zoomed = Math.abs(this.span - this.known.span) > tolerance;
    this.known = { target: target.clone(), span: this.span };
    this.onMoved(moved.length() > tolerance ? "panned" : zoomed ? "zoomed" : "turned");
  }
}

function heightPerDistance(): number {
  return 2 * Math.tan((FIELD_OF_VIEW * Math.PI) / 360);
}
