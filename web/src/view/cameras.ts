// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Where the images were taken: a small pyramid for each, a line through them, and the vehicle at the newest.
import {
  BufferGeometry,
  DoubleSide,
  Float32BufferAttribute,
  Group,
  InstancedBufferGeometry,
  LineSegments,
  Mesh,
  MeshBasicMaterial,
  Quaternion,
  ShaderMaterial,
  Vector3,
} from "three";
import { LineMaterial } from "three/addons/lines/LineMaterial.js";
import { LineSegments2 } from "three/addons/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/addons/lines/LineSegmentsGeometry.js";
import type { CameraInfo, Pose, Vec3 } from "../wire/records";
import { GrowingAttribute } from "./growing";
import type { Origin } from "./origin";

/** Sub-maps take turns; safe for the colour-blind (Okabe and Ito). */
const SUBMAP_COLOURS = [0x56c8f0, 0xf0b440, 0x4fd8a8, 0xe08cc0, 0xf0e442, 0xe87838];
const VEHICLE = 0xffffff;
const VEHICLE_LOST = 0xff7a45;

const VERTEX = `
  attribute vec3 place;
  attribute vec4 turn;
  attribute vec4 tint;
  uniform float size;
  varying vec4 shade;
  void main() {
    vec3 p = position * size;
    p += 2.0 * cross(turn.xyz, cross(turn.xyz, p) + turn.w * p);
    shade = tint;
    gl_Position = projectionMatrix * viewMatrix * vec4(place + p, 1.0);
  }`;
const FRAGMENT = `
  varying vec4 shade;
  void main() { gl_FragColor = shade; }`;

export class Cameras {
  readonly object = new Group();
  readonly vehicle: Mesh<BufferGeometry, MeshBasicMaterial>;
  readonly poses = new Map<number, Pose>();
  newest: Pose | null = null;
  isLost = false;
  /** Of the undistorted images. */
  camera: CameraInfo | null = null;
  private slots = new Map<number, number>();
  private pathIsStale = false;
  private readonly frusta: LineSegments<InstancedBufferGeometry, ShaderMaterial>;
  private readonly path = new LineSegments2(
    new LineSegmentsGeometry(),
    new LineMaterial({ linewidth: 3, vertexColors: true }),
  );
  private readonly places = new GrowingAttribute((n) => new Float32Array(n), 3, { instanced: true });
  private readonly turns = new GrowingAttribute((n) => new Float32Array(n), 4, { instanced: true });
  private readonly tints = new GrowingAttribute((n) => new Uint8Array(n), 4, {
    instanced: true,
    normalized: true,
  });

  constructor(private readonly origin: Origin) {
    const material = new ShaderMaterial({
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      uniforms: { size: { value: 0.2 } },
      transparent: true,
      depthWrite: false,
    });
    this.frusta = new LineSegments(new InstancedBufferGeometry(), material);
    this.frusta.geometry.instanceCount = 0;
    this.setShape({ type: "camera", width: 4, height: 3, fx: 4, fy: 4, cx: 1.5, cy: 1 });
    this.attach();
    this.vehicle = new Mesh(arrow(), new MeshBasicMaterial({ side: DoubleSide, depthTest: false, transparent: true }));
    const rim = new Mesh(arrow(), new MeshBasicMaterial({ color: 0, side: DoubleSide, depthTest: false, transparent: true }));
    rim.scale.setScalar(1.3);
    rim.renderOrder = 9;
    rim.frustumCulled = false;
    this.vehicle.add(rim);
    this.vehicle.renderOrder = 10;
    this.path.visible = false;
    this.frusta.frustumCulled = this.path.frustumCulled = this.vehicle.frustumCulled = false;
    this.object.add(this.frusta, this.path);
  }

  get count(): number {
    return this.poses.size;
  }

  /** One sigma of the way between where two images were taken, survey units: the uncertainties of the poses of key frames
   *  between them add up, sub-maps apart. */
  sigmaBetween(one: number, other: number): number {
    const [from, to] = one < other ? [one, other] : [other, one];
    let variance = 0;
    for (const pose of this.poses.values()) {
      if (pose.image > from && pose.image <= to && (pose.keyFrame || pose.image === to)) variance += pose.sigma ** 2;
    }
    return Math.sqrt(variance);
  }

  /** Survey units that a pixel of the mapped images covers at a distance; 0 while the camera is not known. */
  pixelAt(distance: number): number {
    return this.camera === null ? 0 : (2 * distance) / (this.camera.fx + this.camera.fy);
  }

  setCamera(camera: CameraInfo): void {
    this.camera = camera;
    this.setShape(camera);
  }

  private setShape(camera: CameraInfo): void {
    this.frusta.geometry.setAttribute("position", new Float32BufferAttribute(pyramid(camera), 3));
  }

  /** Height of the pyramids, scene units. */
  setSize(size: number): void {
    this.frusta.material.uniforms["size"] = { value: size };
  }

  setPyramids(shown: boolean): void {
    this.frusta.visible = shown;
  }

  setLost(lost: boolean): void {
    this.isLost = lost;
    this.vehicle.material.color.set(lost ? VEHICLE_LOST : VEHICLE);
  }

  setPose(pose: Pose): void {
    const slot = this.slots.get(pose.image) ?? this.slots.size;
    this.slots.set(pose.image, slot);
    this.poses.set(pose.image, pose);
    this.reserve(slot + 1);
    this.places.set(slot, this.origin.toScene(pose.position));
    this.turns.set(slot, pose.rotation);
    this.tints.set(slot, [...rgb(pose.submap), pose.keyFrame ? 150 : 60]);
    this.frusta.geometry.instanceCount = this.slots.size;
    this.pathIsStale = true;
    if (this.newest === null || pose.image >= this.newest.image) this.setVehicle(pose);
  }

  /** Brings the line up to date; called once a drawn picture, not once a pose. */
  update(): void {
    if (!this.pathIsStale) return;
    this.pathIsStale = false;
    const ordered = [...this.poses.values()].sort((one, other) => one.image - other.image);
    const positions: number[] = [];
    const colours: number[] = [];
    ordered.forEach((pose, i) => {
      const next = ordered[i + 1];
      if (next?.submap !== pose.submap) return;
      positions.push(...this.origin.toScene(pose.position), ...this.origin.toScene(next.position));
      const colour = rgb(pose.submap).map((value) => value / 255);
      colours.push(...colour, ...colour);
    });
    this.path.visible = positions.length > 0;
    if (!this.path.visible) return;
    this.path.geometry.dispose();
    this.path.geometry = new LineSegmentsGeometry().setPositions(positions).setColors(colours);
  }

  clear(): void {
    this.poses.clear();
    this.slots = new Map();
    this.newest = null;
    this.frusta.geometry.instanceCount = 0;
    this.pathIsStale = true;
  }

  private setVehicle(pose: Pose): void {
    this.newest = pose;
    this.vehicle.position.fromArray(this.origin.toScene(pose.position));
    this.vehicle.quaternion.fromArray(pose.rotation);
  }

  private reserve(cameras: number): void {
    const moved = [this.places, this.turns, this.tints].map((attribute) => attribute.reserve(cameras));
    if (moved.includes(true)) this.attach();
  }

  private attach(): void {
    this.frusta.geometry.dispose();
    this.frusta.geometry.setAttribute("place", this.places.attribute);
    this.frusta.geometry.setAttribute("turn", this.turns.attribute);
    this.frusta.geometry.setAttribute("tint", this.tints.attribute);
  }
}

/** Where the camera looks; survey. */
export function forward(pose: Pose): Vec3 {
  const z = new Vector3(0, 0, 1).applyQuaternion(new Quaternion(...pose.rotation));
  return [z.x, z.y, z.z];
}

/** A distance on. */
export function reach(from: Vec3, direction: Vec3, distance: number): Vec3 {
  return [
    from[0] + distance * direction[0],
    from[1] + distance * direction[1],
    from[2] + distance * direction[2],
  ];
}

function rgb(submap: number): [number, number, number] {
  const colour = SUBMAP_COLOURS[submap % SUBMAP_COLOURS.length] ?? 0;
  return [colour >> 16, (colour >> 8) & 255, colour & 255];
}

/** Edges of the viewing pyramid of height 1 with a roof over the image's top edge. */
function pyramid({ width, height, fx, fy, cx, cy }: CameraInfo): number[] {
  const at = (u: number, v: number): Vec3 => [(u - cx) / fx, (v - cy) / fy, 1];
  const apex: Vec3 = [0, 0, 0];
  const topLeft = at(0, 0);
  const topRight = at(width, 0);
  const bottomLeft = at(0, height);
  const bottomRight = at(width, height);
  const roof = at(width / 2, -0.18 * height);
  const edges: [Vec3, Vec3][] = [
    [apex, topLeft],
    [apex, topRight],
    [apex, bottomLeft],
    [apex, bottomRight],
    [topLeft, topRight],
    [topRight, bottomRight],
    [bottomRight, bottomLeft],
    [bottomLeft, topLeft],
    [topLeft, roof],
    [roof, topRight],
  ];
  return edges.flat(2);
}

/** An arrow of length 1 in the image plane, towards the top of the image. */
function arrow(): BufferGeometry {
  const geometry = new BufferGeometry();
  geometry.setAttribute(
    "position",
    new Float32BufferAttribute([0, -0.6, 0, 0.42, 0.4, 0, 0, 0.18, 0, -0.42, 0.4, 0], 3),
  );
  geometry.setIndex([0, 1, 2, 0, 2, 3]);
  return geometry;
}
