// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from "vitest";
import { footprint } from "../src/view/footprint";
import type { CameraInfo, PlaneGrid, Pose } from "../src/wire/records";
import { POSE } from "./pose";

const CAMERA: CameraInfo = { type: "camera", width: 400, height: 300, fx: 200, fy: 200, cx: 200, cy: 150 };
/** 2 above the ground. */
const ABOVE: Pose = { ...POSE, position: [1e6, 2e6, 5] };

/** Cells of a metre on the plane z = 3 + slope x, x from the camera. */
function ground(slope: number): PlaneGrid {
  const [x, y] = [1e6 - 5, 2e6 - 5];
  const surveyFromGrid = new Float64Array([1, 0, x, 0, 1, y, slope, 0, 3 - 5 * slope, 0, 0, 1]);
  return { type: "plane_grid", image: 0, submap: 0, columns: 10, rows: 10, surveyFromGrid, camera: [0, 0, 0], maxRange: 10 };
}

describe("the footprint", () => {
  it("is the image as large as the ground is far", () => {
    const corners = footprint(ABOVE, CAMERA, ground(0));
    const wanted = [[-2, 1.5], [2, 1.5], [2, -1.5], [-2, -1.5]];
    expect(corners).toHaveLength(4);
    corners.forEach(([x, y, z], i) => {
      expect(x - 1e6).toBeCloseTo(wanted[i]?.[0] ?? NaN, 6);
      expect(y - 2e6).toBeCloseTo(wanted[i]?.[1] ?? NaN, 6);
      expect(z).toBeCloseTo(3, 6);
    });
  });

  it("reaches farther where the ground falls away", () => {
    const xs = footprint(ABOVE, CAMERA, ground(-0.5)).map(([x]) => x - 1e6);
    // The rays of slope 1 to the right and left meet 2 - 0.5 x and 2 + 0.5 x below the camera.
    expect(Math.max(...xs)).toBeCloseTo(4, 6);
    expect(Math.min(...xs)).toBeCloseTo(-4 / 3, 6);
  });

  it("is none where the camera looks past the ground, or far along it", () => {
    expect(footprint({ ...ABOVE, rotation: [0, 0, 0, 1] }, CAMERA, ground(0))).toEqual([]);
    const tilt = (50 * Math.PI) / 180;
    // 50 degrees up from straight down: the upper corners look 3 degrees below the horizon.
    const rotation = [Math.cos(tilt / 2), 0, 0, -Math.sin(tilt / 2)] as const;
    expect(footprint({ ...ABOVE, rotation: [...rotation] }, CAMERA, ground(0))).toEqual([]);
  });
});
