"use strict";
// What is shown on demand: boxes of bodies, patches of vertices, and what is selected.

const BOX_EDGES = [[0, 1], [2, 3], [4, 5], [6, 7], [0, 2], [1, 3], [4, 6], [5, 7], [0, 4], [1, 5], [2, 6], [3, 7]];

class Overlays {
  constructor(data, scene) {
    this.data = data;
    this.scene = scene;
    this.showBoxes = false;
    this.showPatches = false;
    this.lines = new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ color: 0x7f7f7f }));
    this.dots = new THREE.Points(new THREE.BufferGeometry(),
      flatMaterial(POINT_VERTEX, ROUND_FRAGMENT, { pixels: { value: 5 } }));
    this.mark = new THREE.Points(new THREE.BufferGeometry(),
      flatMaterial(POINT_VERTEX, ROUND_FRAGMENT, { pixels: { value: 13 } }));
    this.dots.material.depthTest = true;
    [this.lines, this.dots, this.mark].forEach((object, order) => {
      object.frustumCulled = false;
      object.renderOrder = 8 + 8 * order;
      scene.add(object);
    });
  }

  /** `body`: the one whose patches are shown; of none, those of all bodies. `vertex`: of it, selected. */
  show(frame, body, vertex) {
    const lines = [], dots = [], shades = [];
    this.data.bodies.forEach((_, b) => {
      const mesh = this.data.meshOf(frame, b);
      if (!mesh || !(this.showBoxes || (this.showPatches && (body === undefined || b === body)))) return;
      const points = this.data.verticesAt(frame, b);
      if (this.showBoxes) lines.push(...this.#boxLines(boxAround(points)));
      if (this.showPatches && (body === undefined || b === body))
        for (let v = 0; v < mesh.patches.length; ++v) {
          dots.push(points[3 * v], points[3 * v + 1], points[3 * v + 2]);
          shades.push(...channels(KINDS[mesh.patches[v] % KINDS.length]));
        }
    });
    this.#fill(this.lines, lines);
    this.#fill(this.dots, dots, shades);
    const there = vertex !== undefined && this.data.hasVertex(frame, body, vertex);
    this.#fill(this.mark, there ? this.data.vertexAt(frame, body, vertex) : [], SELECTED);
  }

  #boxLines([lower, upper]) {
    const corner = (k) => [0, 1, 2].map((axis) => (k >> axis & 1 ? upper : lower)[axis]);
    return BOX_EDGES.flatMap(([a, b]) => [...corner(a), ...corner(b)]);
  }

  #fill(object, positions, shades) {
    object.visible = positions.length > 0;
    if (!object.visible) return;
    object.geometry.setAttribute("position", new THREE.Float32BufferAttribute(positions, 3));
    if (shades) object.geometry.setAttribute("shade", new THREE.Float32BufferAttribute(shades, 3));
  }
}
