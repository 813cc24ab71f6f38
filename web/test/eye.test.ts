// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import { Box3, Vector3 } from "three";
import { describe, expect, it } from "vitest";
import { Eye } from "../src/view/eye";

const MARGINS = { left: 0, top: 0, right: 0, bottom: 0 };

/** Before a canvas that nobody touches. */
function newEye(): Eye {
  const canvas = Object.assign(new EventTarget(), { style: {}, clientWidth: 800, clientHeight: 600, getRootNode: () => new EventTarget(), ownerDocument: new EventTarget() });
  const eye = new Eye(canvas as unknown as HTMLCanvasElement);
  eye.resize(800, 600, MARGINS);
  return eye;
}

/** Steers towards the box until it is seen, at most for so many pictures; how many it took. */
function look(eye: Eye, box: Box3, range: number): number {
  for (let pictures = 1; pictures < 1000; ++pictures) {
    const moving = eye.fit(box, 0.02);
    eye.setScene(box, range);
    if (!moving) return pictures;
  }
  return Infinity;
}

describe("the eye", () => {
  it("comes to rest before a single place, and sees what is told next", () => {
    for (const how of ["map", "scene"] as const) {
      const eye = newEye();
      eye.setLook(how);
      const box = new Box3(new Vector3(1, 2, 3), new Vector3(1, 2, 3));
      expect(look(eye, box, 0)).toBeLessThan(1000);
      expect(eye.span).toBeGreaterThan(0);
      box.expandByPoint(new Vector3(5, 2, 3));
      expect(look(eye, box, 0)).toBeLessThan(1000);
      expect(eye.target.x).toBeCloseTo(3, 1);
      expect(eye.span).toBeGreaterThan(3);
      expect(eye.span).toBeLessThan(8);
    }
  });

  it("zooms neither into a pixel nor out of the scene", () => {
    const eye = newEye();
    eye.setLook("map");
    eye.setScene(new Box3(new Vector3(0, 0, 0), new Vector3(30, 40, 0)), 2);
    for (let i = 0; i < 100; ++i) eye.zoomBy(1.4);
    expect(eye.span).toBeCloseTo(0.02, 6);
    for (let i = 0; i < 200; ++i) eye.zoomBy(1 / 1.4);
    expect(eye.span).toBeCloseTo(20 * 52, 6);
  });
});
