// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// Lines drawn over everything: the plan and its lanes, the way to the nearest gap, what the camera sees, the ruler.
import { Group } from "three";
import { LineMaterial } from "three/addons/lines/LineMaterial.js";
import { LineSegments2 } from "three/addons/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/addons/lines/LineSegmentsGeometry.js";
import type { Guidance, Vec2, Vec3 } from "../wire/records";
import type { Origin } from "./origin";

type Segment = readonly [Vec3, Vec3];

/** Segments of one colour and width. */
class Stroke {
  readonly object: LineSegments2;

  constructor(
    private readonly origin: Origin,
    color: number,
    linewidth: number,
    dashed = false,
  ) {
    const material = new LineMaterial({ color, linewidth, dashed, dashSize: 0.3, gapSize: 0.2, depthTest: false, transparent: true });
    this.object = new LineSegments2(new LineSegmentsGeometry(), material);
    this.object.frustumCulled = this.object.visible = false;
    this.object.renderOrder = 8;
  }

  draw(segments: readonly Segment[]): void {
    this.object.visible = segments.length > 0;
    if (segments.length === 0) return;
    this.object.geometry.dispose();
    this.object.geometry = new LineSegmentsGeometry().setPositions(segments.flatMap((ends) => ends.flatMap((end) => this.origin.toScene(end))));
    this.object.computeLineDistances();
  }
}

export class Strokes {
  readonly plan = new Group();
  readonly tools = new Group();
  readonly footprint = new Group();
  private readonly outline: Stroke;
  private readonly lanes: Stroke;
  private readonly lane: Stroke;
  private readonly wayRim: Stroke;
  private readonly way: Stroke;
  private readonly footprintRim: Stroke;
  private readonly footprintEdge: Stroke;
  private readonly rulerRim: Stroke;
  private readonly ruler: Stroke;
  private guidance: Guidance | null = null;
  private vehicle: Vec3 | null = null;
  private height = 0;

  constructor(origin: Origin) {
    this.outline = new Stroke(origin, 0xffffff, 3);
    this.lanes = new Stroke(origin, 0xffffff, 1.5);
    this.lane = new Stroke(origin, 0x56c8f0, 5);
    this.wayRim = new Stroke(origin, 0x000000, 8, true);  // gaps are of the way's colour
    this.way = new Stroke(origin, 0xff6a3d, 4, true);
    this.footprintRim = new Stroke(origin, 0x000000, 5);
    this.footprintEdge = new Stroke(origin, 0xffffff, 2.5);
    this.rulerRim = new Stroke(origin, 0x000000, 7);
    this.ruler = new Stroke(origin, 0xffe14d, 4);
    this.plan.add(this.outline.object, this.lanes.object, this.lane.object, this.wayRim.object, this.way.object);
    this.footprint.add(this.footprintRim.object, this.footprintEdge.object);
    this.tools.add(this.rulerRim.object, this.ruler.object);
  }

  setGuidance(guidance: Guidance, height: number): void {
    this.guidance = guidance;
    this.height = height;
    const at = ([x, y]: Vec2): Vec3 => [x, y, height];
    const { plan, lanes, lane } = guidance;
    this.outline.draw(closed(plan.map(at)));
    const drawn = lanes.map(({ from, to }): Segment => [at(from), at(to)]);
    this.lanes.draw(drawn.filter((_, i) => i !== lane));
    this.lane.draw(drawn.filter((_, i) => i === lane));
    this.drawWay();
  }

  setVehicle(position: Vec3): void {
    this.vehicle = position;
    this.drawWay();
  }

  /** Corners in turn. */
  setFootprint(corners: readonly Vec3[]): void {
    const edges = closed(corners);
    this.footprintRim.draw(edges);
    this.footprintEdge.draw(edges);
  }

  setRuler(ends: readonly Vec3[]): void {
    const [from, to] = ends;
    const segments: Segment[] = from === undefined || to === undefined ? [] : [[from, to]];
    this.rulerRim.draw(segments);
    this.ruler.draw(segments);
  }

  clear(): void {
    this.guidance = this.vehicle = null;
    this.setFootprint([]);
    for (const stroke of [this.outline, this.lanes, this.lane, this.wayRim, this.way, this.rulerRim, this.ruler]) stroke.draw([]);
  }

  private drawWay(): void {
    const nearest = this.guidance?.gaps[0];
    const { vehicle, height } = this;
    const segments: Segment[] = nearest === undefined || vehicle === null ? [] : [[[vehicle[0], vehicle[1], height], [...nearest.centre, height]]];
    this.wayRim.draw(segments);
    this.way.draw(segments);
  }
}

function closed(corners: readonly Vec3[]): Segment[] {
  return corners.map((corner, i): Segment => [corner, corners[(i + 1) % corners.length] ?? corner]);
}
