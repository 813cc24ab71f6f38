// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import { Plane, Quaternion, Ray, Vector3 } from "three";
import type { CameraInfo, PlaneGrid, Pose, Vec3 } from "../wire/records";
import { pointOf } from "./planes";

/** Corners in turn, from the image's upper left on, of what a camera sees of the plane of a grid; survey. None where it
 *  sees the plane not in all of them, or farther away than the grid reaches. */
export function footprint(pose: Pose, camera: CameraInfo, ground: PlaneGrid): Vec3[] {
  const onGround = [pointOf(ground, 0, 0), pointOf(ground, ground.columns, 0), pointOf(ground, 0, ground.rows)];
  const [a, b, c] = onGround.map((point) => (point === null ? null : relative(point, pose.position)));
  if (!a || !b || !c) return [];
  const plane = new Plane().setFromCoplanarPoints(a, b, c);
  const turn = new Quaternion(...pose.rotation);
  const corners = [[0, 0], [1, 0], [1, 1], [0, 1]].flatMap(([right = 0, down = 0]) => {
    const at = new Vector3((right * camera.width - camera.cx) / camera.fx, (down * camera.height - camera.cy) / camera.fy, 1);
    const met = new Ray(new Vector3(), at.applyQuaternion(turn)).intersectPlane(plane, new Vector3());
    return met === null || met.length() > ground.maxRange ? [] : [met];
  });
  if (corners.length < 4) return [];
  return corners.map(({ x, y, z }): Vec3 => [pose.position[0] + x, pose.position[1] + y, pose.position[2] + z]);
}

function relative(point: Vec3, to: Vec3): Vector3 {
  return new Vector3(point[0] - to[0], point[1] - to[1], point[2] - to[2]);
}
