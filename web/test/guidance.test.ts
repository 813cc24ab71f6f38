// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from "vitest";
import { wayTo } from "../src/ui/way";
import { colour, COVERAGE_COLOURS } from "../src/view/coverage";
import { meet, type Ray } from "../src/view/ground";
import type { PlaneGrid, Pose } from "../src/wire/records";

/** A camera at a height that looks straight down, the top of its image turned clockwise from y by an angle. */
function lookingDown(heading: number, position: [number, number, number]): Pose {
  // Half a turn about x looks down with the image's top along y; then turned about z.
  const half = -heading / 2;
  return {
    type: "pose",
    image: 0,
    time: 0,
    position,
    rotation: [Math.cos(half), Math.sin(half), 0, 0],
    submap: 0,
    tiePoints: 0,
    rms: 0,
    sigma: 0,
    keyFrame: true,
  };
}

describe("the way to a gap", () => {
  it("is ahead when the image's top points at it, and turns clockwise to the right", () => {
    const north = lookingDown(0, [10, 20, 2]);
    expect(wayTo(north, [10, 23])).toEqual({ turn: expect.closeTo(0, 9) as number, distance: 3 });
    expect(wayTo(north, [14, 20]).turn).toBeCloseTo(Math.PI / 2, 9);
    expect(wayTo(north, [7, 20]).turn).toBeCloseTo(-Math.PI / 2, 9);
    expect(Math.abs(wayTo(north, [10, 12]).turn)).toBeCloseTo(Math.PI, 9);
  });

  it("is seen from the vehicle, whichever way it heads", () => {
    for (let heading = -3; heading <= 3; heading += 0.5) {
      for (let bearing = -3; bearing <= 3; bearing += 0.5) {
        const way = wayTo(lookingDown(heading, [5, 5, 1]), [5 + 2 * Math.sin(bearing), 5 + 2 * Math.cos(bearing)]);
        const off = way.turn - (bearing - heading);
        expect(Math.cos(off)).toBeCloseTo(1, 9);
        expect(way.distance).toBeCloseTo(2, 9);
      }
    }
  });
});

describe("the ground under a finger", () => {
  // Cells of 2 cm on a slope z = 0.1 x, the camera 3 m above.
  const grid: PlaneGrid = {
    type: "plane_grid",
    image: 7,
    submap: 0,
    columns: 150,
    rows: 100,
    surveyFromGrid: new Float64Array([0.02, 0, -1.5, 0, -0.02, 1, 0.002, 0, -0.15, 0, 0, 1]),
    camera: [0, 0, 3],
    maxRange: 5,
  };
  const down = (x: number, y: number): Ray => ({ from: [x, y, 10], direction: [0, 0, -1] });

  it("is where the ray meets the plane within the picture", () => {
    const sight = meet(grid, down(0.5, -0.25));
    expect(sight?.image).toBe(7);
    sight?.point.forEach((value, k) => {
      expect(value).toBeCloseTo([0.5, -0.25, 0.05][k] ?? NaN, 9);
    });
    expect(sight?.distance).toBeCloseTo(Math.hypot(0.5, 0.25, 2.95), 9);
    expect(sight?.along).toBeCloseTo(9.95, 9);
  });

  it("is the same from any side and with a direction of any length", () => {
    const slanted = meet(grid, { from: [4, 3, 8], direction: [-7, -6.5, -15.9] });
    expect(slanted?.point[2]).toBeCloseTo(0.1 * (slanted?.point[0] ?? NaN), 9);
    expect(slanted?.point[0]).toBeCloseTo(0.5, 1);
  });

  it("is none beside the picture, behind the eye and out of range", () => {
    expect(meet(grid, down(1.6, 0))).toBeNull();
    expect(meet(grid, { from: [0, 0, -10], direction: [0, 0, -1] })).toBeNull();
    expect(meet({ ...grid, maxRange: 2 }, down(0, 0))).toBeNull();
  });
});

describe("coverage", () => {
  it("shows counts in their colours, gaps striped, and nothing where nothing is wanted", () => {
    const values = [0, 128, 129, 130, 131, 3, 255, 1];
    const data = new Uint8ClampedArray(values.flatMap((value) => [value, value, value, 255]));
    const gaps = colour({ data, width: 8, height: 1, colorSpace: "srgb" } as ImageData);
    expect(gaps).toBe(1);
    const shade = (cell: number) => [...data.slice(4 * cell, 4 * cell + 3)];
    expect(data[3]).toBe(0);
    expect([1, 2, 3, 4].map(shade)).toEqual(COVERAGE_COLOURS.map((colours) => colours.slice(0, 3)));
    expect(shade(5)).toEqual(COVERAGE_COLOURS[3].slice(0, 3));
    expect(shade(6)).toEqual(COVERAGE_COLOURS[3].slice(0, 3));
    expect(shade(7)).toEqual(COVERAGE_COLOURS[1].slice(0, 3));
    expect([...data.filter((_, i) => i % 4 === 3)].slice(1).every((alpha) => alpha >= 50)).toBe(true);
  });
});
