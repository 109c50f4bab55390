"use strict";
// Contacts in the scene: a point in the middle of each contact's two points, and a needle along its normal.

const NEEDLE_VERTEX = `
attribute vec3 place, way, shade;
uniform float thickness;
varying vec3 color;
void main() {
  float reach = length(way);
  vec3 z = reach > 0.0 ? way / reach : vec3(0.0, 0.0, 1.0);
  vec3 x = normalize(abs(z.x) < 0.7 ? cross(z, vec3(1.0, 0.0, 0.0)) : cross(z, vec3(0.0, 1.0, 0.0)));
  vec3 at = place + thickness * (position.x * x + position.y * cross(z, x)) + reach * position.z * z;
  color = shade;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(at, 1.0);
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
const NEEDLE_SIDES = 5;

/** A pyramid along z, 1 long, with a base of radius 1: positions and triangles. */
function needle() {
  const positions = [0, 0, 1], triangles = [];
  for (let k = 0; k < NEEDLE_SIDES; ++k) {
    const angle = (2 * Math.PI * k) / NEEDLE_SIDES;
    positions.push(Math.cos(angle), Math.sin(angle), 0);
    triangles.push(0, 1 + k, 1 + ((k + 1) % NEEDLE_SIDES));
  }
  return [new Float32Array(positions), new Uint16Array(triangles)];
}

function flatMaterial(vertexShader, fragmentShader, uniforms) {
  return new THREE.ShaderMaterial({
    vertexShader, fragmentShader, uniforms, side: THREE.DoubleSide, depthTest: false, transparent: true,
  });
}

class Contacts {
  constructor(data, scene, unit) {
    this.data = data;
    this.scene = scene;
    this.room = 0;
    this.arrowScale = 1;
    this.shown = [];
    const thickness = { value: unit * 0.012 }, pixels = { value: 6 };
    this.needleMaterial = flatMaterial(NEEDLE_VERTEX, FLAT_FRAGMENT, { thickness });
    this.pointMaterial = flatMaterial(POINT_VERTEX, ROUND_FRAGMENT, { pixels });
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
    const geometry = new THREE.InstancedBufferGeometry(), [positions, triangles] = needle();
    geometry.setIndex(new THREE.BufferAttribute(triangles, 1));
    geometry.setAttribute("position", new THREE.BufferAttribute(positions, 3));
    const numbers = (copies = 1) => new Float32Array(3 * this.room * copies);
    this.place = numbers();
    this.way = numbers();
    this.shade = numbers();
    this.ends = numbers(2);
    this.endShades = numbers(2);
    for (const name of ["place", "way", "shade"])
      geometry.setAttribute(name, new THREE.InstancedBufferAttribute(this[name], 3));
    const points = new THREE.BufferGeometry();
    points.setAttribute("position", new THREE.BufferAttribute(this.place, 3));
    points.setAttribute("shade", new THREE.BufferAttribute(this.shade, 3));
    const rays = new THREE.BufferGeometry();
    rays.setAttribute("position", new THREE.BufferAttribute(this.ends, 3));
    rays.setAttribute("color", new THREE.BufferAttribute(this.endShades, 3));
    this.needles = new THREE.Mesh(geometry, this.needleMaterial);
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
    for (let k = 0; k < end - begin; ++k) {
      if (!keeps(begin + k)) continue;
      const c = this.data.contact(frame, k), at = mix(c.point_a, c.point_b, 0.5), i = this.shown.length;
      const color = k === selected ? SELECTED : colorOf(begin + k, c);
      this.place.set(at, 3 * i);
      this.way.set(scaled(c.normal, Math.abs(c.distance) * this.arrowScale), 3 * i);
      this.shade.set(color, 3 * i);
      if (this.showRays) {
        this.ends.set([...c.point_a, ...c.point_b], 6 * i);
        this.endShades.set([...color, ...color], 6 * i);
      }
      this.shown.push({ number: k, at });
    }
    const count = this.shown.length;
    this.needles.geometry.maxInstancedCount = count;
    this.points.geometry.setDrawRange(0, count);
    this.rays.geometry.setDrawRange(0, 2 * count);
    this.needles.visible = this.showArrows && count > 0;
    this.points.visible = this.showPoints && count > 0;
    this.rays.visible = this.showRays && count > 0;
    for (const object of [this.needles, this.points, this.rays])
      for (const values of Object.values(object.geometry.attributes)) values.needsUpdate = true;
  }
}
