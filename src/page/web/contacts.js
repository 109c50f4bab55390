"use strict";
// Contacts in the scene: a point in the middle of each contact's two points, and a needle along its normal.

const NEEDLE_VERTEX = `
attribute vec3 shade;
varying vec3 color;
void main() {
  color = shade;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}`;
const POINT_VERTEX = `
attribute vec3 shade;
uniform float pixels;
varying vec3 color;
void main() {
  color = shade;
  gl_PointSize = pixels;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}`;
const FLAT_FRAGMENT = `
varying vec3 color;
void main() { gl_FragColor = vec4(color, 1.0); }`;
const ROUND_FRAGMENT = `
varying vec3 color;
void main() {
  float away = length(gl_PointCoord - 0.5);
  if (away > 0.5) discard;
  gl_FragColor = vec4(away > 0.36 ? vec3(0.1) : color, 1.0);
}`;
// A needle is a pyramid of three sides. Browsers that draw by software draw one large mesh much
// faster than many copies of a small one.
const NEEDLE_CORNERS = 4;
const NEEDLE_SIDES = [0, 1, 2, 0, 2, 3, 0, 3, 1];
const SLIMNESS = 0.2;  // the base's radius is at most this part of the length

/** Writes the corners of a needle: its point, and its base of a radius around `from`. */
function needleCorners(from, way, radius, out, at) {
  out.set(from, at);
  for (let k = 1; k < NEEDLE_CORNERS; ++k) out.set(from, at + 3 * k);
  const long = size(way);
  if (long === 0) return;
  const z = scaled(way, 1 / long), side = cross(z, Math.abs(z[0]) < 0.7 ? [1, 0, 0] : [0, 1, 0]);
  const x = scaled(side, Math.min(radius, SLIMNESS * long) / size(side)), y = cross(z, x);
  for (let axis = 0; axis < 3; ++axis) {
    out[at + axis] += way[axis];
    out[at + 3 + axis] += x[axis];
    out[at + 6 + axis] += -0.5 * x[axis] + 0.866 * y[axis];
    out[at + 9 + axis] += -0.5 * x[axis] - 0.866 * y[axis];
  }
}

function flatMaterial(vertexShader, fragmentShader, uniforms) {
  return new THREE.ShaderMaterial({
    vertexShader, fragmentShader, uniforms, side: THREE.DoubleSide, depthTest: false, transparent: true, blending: THREE.NoBlending,
  });
}

class Contacts {
  constructor(data, scene, unit) {
    this.data = data;
    this.scene = scene;
    this.room = 0;
    this.arrowScale = 1;
    this.shown = [];
    this.radius = 0.014 * unit;
    this.needleMaterial = flatMaterial(NEEDLE_VERTEX, FLAT_FRAGMENT, {});
    this.pointMaterial = flatMaterial(POINT_VERTEX, ROUND_FRAGMENT, { pixels: { value: 6 } });
    this.rayMaterial = new THREE.LineBasicMaterial({ vertexColors: THREE.VertexColors ?? true, depthTest: false, transparent: true });
    this.showRays = false;
    this.showArrows = true;
    this.showPoints = true;
    this.#makeRoom(1);
  }

  set inFront(value) {
    for (const material of [this.needleMaterial, this.pointMaterial, this.rayMaterial]) material.depthTest = !value;
  }

  #makeRoom(count) {
    if (count <= this.room) return;
    this.room = Math.max(2 * this.room, count, 64);
    for (const object of [this.needles, this.points, this.rays]) if (object) this.scene.remove(object);
    const numbers = (copies = 1) => new Float32Array(3 * this.room * copies);
    this.place = numbers();
    this.shade = numbers();
    this.corners = numbers(NEEDLE_CORNERS);
    this.cornerShades = numbers(NEEDLE_CORNERS);
    this.ends = numbers(2);
    this.endShades = numbers(2);
    const needles = new THREE.BufferGeometry(), sides = new Uint32Array(NEEDLE_SIDES.length * this.room);
    for (let i = 0; i < sides.length; ++i)
      sides[i] = NEEDLE_SIDES[i % NEEDLE_SIDES.length] + NEEDLE_CORNERS * Math.floor(i / NEEDLE_SIDES.length);
    needles.setIndex(new THREE.BufferAttribute(sides, 1));
    needles.setAttribute("position", new THREE.BufferAttribute(this.corners, 3));
    needles.setAttribute("shade", new THREE.BufferAttribute(this.cornerShades, 3));
    const points = new THREE.BufferGeometry();
    points.setAttribute("position", new THREE.BufferAttribute(this.place, 3));
    points.setAttribute("shade", new THREE.BufferAttribute(this.shade, 3));
    const rays = new THREE.BufferGeometry();
    rays.setAttribute("position", new THREE.BufferAttribute(this.ends, 3));
    rays.setAttribute("color", new THREE.BufferAttribute(this.endShades, 3));
    this.needles = new THREE.Mesh(needles, this.needleMaterial);
    this.points = new THREE.Points(points, this.pointMaterial);
    this.rays = new THREE.LineSegments(rays, this.rayMaterial);
    [this.rays, this.needles, this.points].forEach((object, order) => {
      object.frustumCulled = false;
      object.renderOrder = 10 + order;
      this.scene.add(object);
    });
  }

  /** Shows the contacts of a frame that `keeps` says yes to; the selected one in its own colour. */
  show(frame, keeps, colorOf, selected) {
    const [begin, end] = this.data.contactRange(frame);
    this.#makeRoom(end - begin);
    this.shown = [];
    for (let i = begin, shown = 0; i < end; ++i) {
      if (!keeps(i)) continue;
      this.data.contactPoints(frame, i, this.ends, 6 * shown);
      const e = this.ends.subarray(6 * shown, 6 * shown + 6);
      const at = [(e[0] + e[3]) / 2, (e[1] + e[4]) / 2, (e[2] + e[5]) / 2];
      const color = i - begin === selected ? SELECTED : colorOf(i);
      const reach = Math.abs(this.data.columns.contact_distance[i]) * this.arrowScale;
      this.place.set(at, 3 * shown);
      this.shade.set(color, 3 * shown);
      this.endShades.set(color, 6 * shown);
      this.endShades.set(color, 6 * shown + 3);
      needleCorners(at, scaled(this.data.contactNormal(i), reach), this.radius, this.corners, 3 * NEEDLE_CORNERS * shown);
      for (let k = 0; k < NEEDLE_CORNERS; ++k) this.cornerShades.set(color, 3 * (NEEDLE_CORNERS * shown + k));
      this.shown.push({ number: i - begin, at });
      ++shown;
    }
    const count = this.shown.length;
    this.needles.geometry.setDrawRange(0, NEEDLE_SIDES.length * count);
    this.points.geometry.setDrawRange(0, count);
    this.rays.geometry.setDrawRange(0, 2 * count);
    this.needles.visible = this.showArrows && count > 0;
    this.points.visible = this.showPoints && count > 0;
    this.rays.visible = this.showRays && count > 0;
    for (const object of [this.needles, this.points, this.rays].filter(({ visible }) => visible))
      for (const values of Object.values(object.geometry.attributes)) {
        values.updateRange = { offset: 0, count: values.itemSize * values.count * count / this.room };
        values.needsUpdate = true;
      }
  }
}
