// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import { Box3, Vector3 } from "three";
import type { Vec3 } from "../wire/records";
import type { Origin } from "./origin";

/** Of what is new in means of late. */
const NEW = 0.1;

/** How far what was told of reaches, and how far below the cameras the ground is. */
export class Extent {
  /** Of the scene; it only grows. */
  box = new Box3();
  /** Distance from the camera to the ground of late, survey units; 0 while unknown. */
  range = 0;
  /** Survey height of the ground of late. */
  groundHeight: number | null = null;

  constructor(private readonly origin: Origin) {}

  include(point: Vec3): void {
    this.box.expandByPoint(new Vector3(...this.origin.toScene(point)));
  }

  /** A place of the ground that a camera sees. */
  measure(camera: Vec3, ground: Vec3): void {
    const range = Math.hypot(camera[0] - ground[0], camera[1] - ground[1], camera[2] - ground[2]);
    this.range = this.range === 0 ? range : (1 - NEW) * this.range + NEW * range;
    this.groundHeight = this.groundHeight === null ? ground[2] : (1 - NEW) * this.groundHeight + NEW * ground[2];
    this.include(ground);
  }

  clear(): void {
    this.box = new Box3();
    this.range = 0;
    this.groundHeight = null;
  }
}
