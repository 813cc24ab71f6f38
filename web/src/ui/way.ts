// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import type { Pose, Vec2 } from "../wire/records";

/** Which way to swim, clockwise from the top of the image, and how far. */
export function wayTo(vehicle: Pose, target: Vec2): { turn: number; distance: number } {
  const [x, y, z, w] = vehicle.rotation;
  // The image's top is the camera's -y.
  const ahead: Vec2 = [-2 * (x * y - w * z), -(1 - 2 * (x * x + z * z))];
  const to: Vec2 = [target[0] - vehicle.position[0], target[1] - vehicle.position[1]];
  const turn = Math.atan2(ahead[1], ahead[0]) - Math.atan2(to[1], to[0]);
  return { turn: Math.atan2(Math.sin(turn), Math.cos(turn)), distance: Math.hypot(...to) };
}
