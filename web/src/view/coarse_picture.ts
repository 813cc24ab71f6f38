// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
import { Mesh, MeshBasicMaterial, OrthographicCamera, PlaneGeometry, Vector2, WebGLRenderTarget, type Camera, type Scene, type WebGLRenderer } from "three";

/** Draws with fewer pixels than the canvas has, edges as they come: it is for cards that are slow. To give the canvas
 *  itself fewer would make it anew, and the page stand still until the card has drawn all it was told before. */
export class CoarsePicture {
  private readonly target = new WebGLRenderTarget();
  private readonly sheet: Mesh<PlaneGeometry, MeshBasicMaterial>;
  private readonly camera = new OrthographicCamera(-0.5, 0.5, 0.5, -0.5, -1, 1);

  constructor(private readonly renderer: WebGLRenderer) {
    this.sheet = new Mesh(new PlaneGeometry(), new MeshBasicMaterial({ map: this.target.texture, depthTest: false, depthWrite: false }));
  }

  /** resolution: pixels along a side for one of the canvas. */
  render(scene: Scene, camera: Camera, resolution: number): void {
    const { x, y } = this.renderer.getDrawingBufferSize(new Vector2()).multiplyScalar(resolution).ceil();
    this.target.setSize(x, y);
    this.renderer.setRenderTarget(this.target);
    this.renderer.render(scene, camera);
    this.renderer.setRenderTarget(null);
    this.renderer.render(this.sheet, this.camera);
  }
}
