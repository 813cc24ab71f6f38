// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Which images show a place, by the planes they were projected onto.
import { Matrix3, Vector3 } from "three";
import type { PlaneGrid, Vec3 } from "../wire/records";

/** From a point in a direction of any length; survey. */
export interface Ray {
  from: Vec3;
  direction: Vec3;
}

export interface Sight {
  image: number;
  point: Vec3;
  /** Of the point from the camera. */
  distance: number;
  /** Along the ray, in lengths of its direction. */
  along: number;
}

export class Ground {
  /** Of the newest image that has one. */
  newest: PlaneGrid | null = null;
  private readonly grids = new Map<number, PlaneGrid>();

  set(grid: PlaneGrid): void {
    this.grids.set(grid.image, grid);
    if (this.newest === null || grid.image >= this.newest.image) this.newest = grid;
  }

  clear(): void {
    this.grids.clear();
    this.newest = null;
  }

  /** Every image whose plane the ray meets within the picture, in no order. */
  sights(ray: Ray): Sight[] {
    const all: Sight[] = [];
    for (const grid of this.grids.values()) {
      const sight = meet(grid, ray);
      if (sight !== null) all.push(sight);
    }
    return all;
  }
}

/** With H the grid's matrix, h its last row and q a cell (column, row, 1) times any number: the upper rows of H q are
 *  h.q (from + t direction), so (upper - from h) q = h.q t direction. */
export function meet(grid: PlaneGrid, { from, direction }: Ray): Sight | null {
  const h = (row: number, column: number) => grid.surveyFromGrid[3 * row + column] ?? 0;
  const m = (row: number, column: number) => h(row, column) - (from[row] ?? 0) * h(3, column);
  const matrix = new Matrix3(m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), m(2, 0), m(2, 1), m(2, 2));
  if (matrix.determinant() === 0) return null;
  const cell = new Vector3(...direction).applyMatrix3(matrix.invert());
  const [column, row] = [cell.x / cell.z, cell.y / cell.z];
  const weight = h(3, 0) * column + h(3, 1) * row + h(3, 2);
  const along = 1 / (weight * cell.z);
  const inside = column >= -0.5 && column <= grid.columns - 0.5 && row >= -0.5 && row <= grid.rows - 0.5;
  if (!inside || !(weight > 0) || !(along > 0) || !Number.isFinite(along)) return null;
  const point: Vec3 = [from[0] + along * direction[0], from[1] + along * direction[1], from[2] + along * direction[2]];
  const distance = Math.hypot(point[0] - grid.camera[0], point[1] - grid.camera[1], point[2] - grid.camera[2]);
  return distance > grid.maxRange ? null : { image: grid.image, point, distance, along };
}
