// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import type { Pose } from "../src/wire/records";

/** Far from the origin, looking straight down, the image's top to the north. */
export const POSE: Pose = {
  type: "pose",
  image: 0,
  time: 0,
  position: [1e6, 2e6, 3],
  rotation: [1, 0, 0, 0],
  submap: 0,
  tiePoints: 9,
  rms: 0.5,
  sigma: 0,
  keyFrame: true,
};
