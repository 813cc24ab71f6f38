// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from "vitest";
import { roundDown } from "../src/ui/scale_bar";
import { Cameras, forward } from "../src/view/cameras";
import { tileCorners } from "../src/view/mosaics";
import { Origin } from "../src/view/origin";
import { inScene } from "../src/view/plane_chunk";
import { pointOf } from "../src/view/planes";
import { TiePointCloud } from "../src/view/tie_points";
import type { Mosaic, PlaneGrid, TiePoints } from "../src/wire/records";
import { POSE } from "./pose";

function block(indices: number[], number = 0): TiePoints {
  return {
    type: "tie_points",
    block: number,
    origin: [1e6, 2e6, 0],
    offsets: new Float32Array(indices.flatMap((index) => [index, 0, 0])),
    indices: new Uint16Array(indices),
    colours: new Uint8Array(3 * indices.length).fill(200),
  };
}

describe("Origin", () => {
  it("keeps a tenth of a millimetre a million metres away", () => {
    const origin = new Origin();
    origin.toScene([1e6, 2e6, 0]);
    expect(Math.fround(origin.toScene([1e6 + 0.0001, 2e6, 0])[0])).toBeCloseTo(0.0001, 7);
  });
});

describe("TiePointCloud", () => {
  it("counts a point once however often it comes", () => {
    const cloud = new TiePointCloud(new Origin());
    cloud.set(block([1, 5, 9]));
    cloud.set(block([1, 5, 9, 11]));
    cloud.set(block([1], 7));
    expect(cloud.count).toBe(5);
    expect(cloud.object.geometry.drawRange.count).toBe(5);
  });

  it("withdraws what a newer record of the block no longer holds, and takes it back", () => {
    const cloud = new TiePointCloud(new Origin());
    cloud.set(block([1, 5, 9]));
    cloud.set(block([5]));
    expect(cloud.count).toBe(1);
    cloud.set(block([1, 5]));
    expect(cloud.count).toBe(2);
    expect(cloud.object.geometry.drawRange.count).toBe(3);
  });

  it("keeps its points when its buffers grow", () => {
    const cloud = new TiePointCloud(new Origin());
    for (let number = 0; number < 5; ++number) cloud.set(block(Array.from({ length: 512 }, (_, i) => i), number));
    expect(cloud.count).toBe(2560);
    const position = cloud.object.geometry.getAttribute("position");
    expect(position.getX(511)).toBe(511);
    expect(position.getX(2559)).toBe(511);
  });

  it("starts empty after clear", () => {
    const cloud = new TiePointCloud(new Origin());
    cloud.set(block([1, 2]));
    cloud.clear();
    expect(cloud.count).toBe(0);
    cloud.set(block([1, 2, 3]));
    expect(cloud.count).toBe(3);
  });
});

describe("Cameras", () => {
  it("counts an image once, knows the newest, and looks where the camera looks", () => {
    const cameras = new Cameras(new Origin());
    cameras.setPose({ ...POSE, image: 3 });
    cameras.setPose({ ...POSE, image: 1 });
    cameras.setPose({ ...POSE, image: 3, position: [1e6 + 1, 2e6, 3] });
    expect(cameras.count).toBe(2);
    expect(cameras.newest?.image).toBe(3);
    expect(cameras.vehicle.position.toArray()).toEqual([1, 0, 0]);
    expect(forward(POSE)[2]).toBeCloseTo(-1, 12);
  });
});

describe("planes", () => {
  const grid: PlaneGrid = {
    type: "plane_grid",
    image: 0,
    submap: 0,
    columns: 150,
    rows: 100,
    surveyFromGrid: new Float64Array([1000, 2, 3e6, 1, 1000, 4e6, 0, 0.5, -9, 0.001, 0.002, 3]),
    camera: [1e6, 2e6, 0],
    maxRange: 10,
  };

  it("lie where the matrix says, seen from the scene's origin", () => {
    const origin = new Origin();
    const h = inScene(grid, origin);
    const at = (row: number) => (h[3 * row] ?? 0) * 70 + (h[3 * row + 1] ?? 0) * 30 + (h[3 * row + 2] ?? 0);
    const expected = pointOf(grid, 70, 30);
    if (expected === null) throw new Error("no point");
    [0, 1, 2].forEach((row) => {
      expect(at(row) / at(3)).toBeCloseTo((expected[row] ?? 0) - (origin.point[row] ?? 0), 6);
    });
  });

  it("have no point beyond the horizon", () => {
    const horizon = { ...grid, surveyFromGrid: new Float64Array([1, 0, 0, 0, 1, 0, 0, 0, 1, -1, 0, 50]) };
    expect(pointOf(horizon, 49, 0)).not.toBeNull();
    expect(pointOf(horizon, 51, 0)).toBeNull();
  });
});

describe("mosaic tiles", () => {
  it("reach from half a pixel before their first to half a pixel after their last, on their plane", () => {
    const mosaic: Mosaic = {
      type: "mosaic",
      mosaic: 0,
      submap: 0,
      groundSamplingDistance: 0.01,
      world: { a: 0.01, d: 0, b: 0, e: -0.01, c: 5, f: 7 },
      normal: [0.6, 0, 0.8],
      offset: -2,
    };
    const [upperLeft, upperRight, lowerLeft] = tileCorners(mosaic, -1, 2);
    expect(upperLeft?.[0]).toBeCloseTo(5 - 2.565, 9);
    expect(upperLeft?.[1]).toBeCloseTo(7 - 5.115, 9);
    expect(upperRight?.[0]).toBeCloseTo(5 - 0.005, 9);
    expect(lowerLeft?.[1]).toBeCloseTo(7 - 7.675, 9);
    for (const corner of [upperLeft, upperRight, lowerLeft]) {
      if (corner === undefined) throw new Error("no corner");
      expect(0.6 * corner[0] + 0.8 * corner[2]).toBeCloseTo(-2, 9);
    }
  });
});

describe("roundDown", () => {
  it("gives 1, 2 or 5 times a power of ten", () => {
    expect([0.0123, 0.3, 1, 3.9, 7, 99].map(roundDown).map((value) => Number(value.toPrecision(3)))).toEqual([
      0.01, 0.2, 1, 2, 5, 50,
    ]);
  });
});
