// SPDX-FileCopyrightText: nadir contributors
// SPDX-License-Identifier: Apache-2.0
// A cloud as most viewers draw it: one buffer of places and colours.
import { BufferGeometry, Float32BufferAttribute, PerspectiveCamera, Points, PointsMaterial, Scene, Uint8BufferAttribute, WebGLRenderer } from "three";

/** Median milliseconds from picture to picture while the camera turns. */
window.draw = async (count, turns) => {
  const canvas = document.getElementById("canvas");
  const renderer = new WebGLRenderer({ canvas, antialias: true });
  renderer.setSize(canvas.clientWidth, canvas.clientHeight, false);
  const places = new Float32Array(3 * count);
  const colours = new Uint8Array(3 * count);
  const across = Math.ceil(Math.sqrt(count));
  for (let i = 0; i < count; ++i) {
    places.set([(100 * (i % across)) / across - 50, (100 * Math.floor(i / across)) / across - 50, 0], 3 * i);
    colours.set([i & 255, (i >> 8) & 255, 128], 3 * i);
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new Float32BufferAttribute(places, 3));
  geometry.setAttribute("color", new Uint8BufferAttribute(colours, 3, true));
  const scene = new Scene();
  scene.add(new Points(geometry, new PointsMaterial({ size: 2, sizeAttenuation: false, vertexColors: true })));
  const camera = new PerspectiveCamera(45, canvas.clientWidth / canvas.clientHeight, 0.1, 1000);
  camera.up.set(0, 0, 1);
  const times = [];
  return new Promise((resolve) => {
    const step = (now) => {
      times.push(now);
      const angle = 0.02 * times.length;
      camera.position.set(90 * Math.cos(angle), 90 * Math.sin(angle), 60);
      camera.lookAt(0, 0, 0);
      renderer.render(scene, camera);
      if (times.length <= turns) requestAnimationFrame(step);
      else resolve(times.slice(1).map((time, i) => time - times[i]).sort((one, other) => one - other)[Math.floor(turns / 2)]);
    };
    requestAnimationFrame(step);
  });
};
