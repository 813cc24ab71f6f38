// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// The mosaics from afar: pictures of eight by eight tiles, with holes where a tile is shown in full. Most are kept small.
import { BufferGeometry, DoubleSide, Float32BufferAttribute, Mesh, ShaderMaterial, type Texture } from "three";
import { OVERVIEW_TILES } from "../wire/records";
import type { Kept } from "./store";

const VERTEX = `
  varying vec2 at;
  void main() {
    at = uv;
    gl_Position = projectionMatrix * viewMatrix * vec4(position, 1.0);
  }`;
const FRAGMENT = `
  uniform sampler2D colours;
  uniform uvec2 holes;
  varying vec2 at;
  void main() {
    ivec2 tile = min(ivec2(at * ${OVERVIEW_TILES}.0), ${OVERVIEW_TILES - 1});
    int bit = tile.y * ${OVERVIEW_TILES} + tile.x;
    if ((((bit < 32 ? holes.x : holes.y) >> uint(bit & 31)) & 1u) == 1u) discard;
    gl_FragColor = texture(colours, at);
  }`;

export class Overview {
  readonly mesh: Mesh<BufferGeometry, ShaderMaterial>;
  jpeg: Kept | null = null;
  mask: Kept | null = null;
  /** Of the colours. */
  sequence = -1;
  /** It shows all the pixels it has. */
  isFine = false;
  /** Its pixels are being unpacked, or could not be. */
  busy = false;
  broken: Kept | null = null;
  private readonly holes = new Uint32Array(2);

  constructor(
    readonly mosaic: number,
    readonly column: number,
    readonly row: number,
    renderOrder: number,
  ) {
    const geometry = new BufferGeometry();
    geometry.setAttribute("uv", new Float32BufferAttribute([0, 0, 1, 0, 0, 1, 1, 1], 2));
    geometry.setIndex([0, 2, 1, 1, 2, 3]);
    const material = new ShaderMaterial({
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      uniforms: { colours: { value: null }, holes: { value: this.holes } },
      side: DoubleSide,
      transparent: true,
      premultipliedAlpha: true,
      depthWrite: false,
    });
    this.mesh = new Mesh(geometry, material);
    this.mesh.renderOrder = renderOrder;
    this.show();
  }

  paint(colours: Texture, isFine: boolean): void {
    this.isFine = isFine;
    const { uniforms } = this.mesh.material;
    (uniforms["colours"]?.value as Texture | null)?.dispose();
    uniforms["colours"] = { value: colours };
    this.show();
  }

  /** Scene coordinates of its upper left, upper right, lower left and lower right corners. */
  place(corners: readonly (readonly number[])[]): void {
    this.mesh.geometry.setAttribute("position", new Float32BufferAttribute(corners.flat(), 3));
    this.mesh.geometry.computeBoundingSphere();
    this.show();
  }

  /** Whether one of the mosaic's tiles is left out. */
  setHole(column: number, row: number, left: boolean): void {
    const bit = OVERVIEW_TILES * (row - OVERVIEW_TILES * this.row) + column - OVERVIEW_TILES * this.column;
    const word = bit >> 5;
    const mask = 1 << (bit & 31);
    this.holes[word] = left ? (this.holes[word] ?? 0) | mask : (this.holes[word] ?? 0) & ~mask;
  }

  /** Once it has colours and a place. */
  private show(): void {
    this.mesh.visible = this.mesh.geometry.hasAttribute("position") && this.mesh.material.uniforms["colours"]?.value !== null;
  }

  dispose(): void {
    (this.mesh.material.uniforms["colours"]?.value as Texture | null)?.dispose();
    this.mesh.material.dispose();
    this.mesh.geometry.dispose();
  }
}
