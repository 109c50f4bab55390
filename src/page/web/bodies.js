"use strict";
// Bodies in the scene: one draw call for all rigid bodies of a mesh, and one for each deforming body.

const BODY_VERTEX = `
attribute vec3 place;
attribute vec4 turn;
attribute vec3 shade;
varying vec3 seen, color;
void main() {
  float s = 2.0 / dot(turn, turn);
  vec3 across = cross(turn.xyz, position);
  vec3 at = position + s * (turn.w * across + cross(turn.xyz, across)) + place;
  vec4 view = modelViewMatrix * vec4(at, 1.0);
  seen = view.xyz;
  color = shade;
  gl_Position = projectionMatrix * view;
}`;
const BODY_FRAGMENT = `
uniform float opacity;
varying vec3 seen, color;
void main() {
  vec3 normal = normalize(cross(dFdx(seen), dFdy(seen)));
  float light = 0.5 + 0.5 * abs(dot(normal, normalize(vec3(0.25, 0.45, 0.85))));
  gl_FragColor = vec4(color * light, opacity);
}`;

function bodyMaterial(opacity, side) {
  return new THREE.ShaderMaterial({
    vertexShader: BODY_VERTEX, fragmentShader: BODY_FRAGMENT, uniforms: { opacity: { value: opacity } },
    side, extensions: { derivatives: true },
  });
}

/** A mesh that is drawn once for each of its instances. */
class Instances {
  constructor(mesh, room, material) {
    const geometry = new THREE.InstancedBufferGeometry();
    this.fine = new THREE.BufferAttribute(mesh.triangles, 1);
    this.mesh = mesh;
    geometry.setIndex(this.fine);
    this.positions = new THREE.BufferAttribute(mesh.vertices, 3);
    geometry.setAttribute("position", this.positions);
    const attribute = (name, width) => {
      const values = new THREE.InstancedBufferAttribute(new Float32Array(room * width), width);
      values.setUsage ? values.setUsage(THREE.DynamicDrawUsage) : values.setDynamic(true);
      geometry.setAttribute(name, values);
      return values;
    };
    this.place = attribute("place", 3);
    this.turn = attribute("turn", 4);
    this.shade = attribute("shade", 3);
    this.object = new THREE.Mesh(geometry, material);
    this.object.frustumCulled = false;
    this.clear();
  }
  /** Draws fewer triangles, or all. */
  set coarse(is) {
    if (is) this.few ??= new THREE.BufferAttribute(coarseTriangles(this.mesh), 1);
    this.object.geometry.setIndex(is ? this.few : this.fine);
  }
  clear() { this.count = 0; }
  add(pose, color) {
    this.place.array.set(pose.subarray(0, 3), 3 * this.count);
    this.turn.array.set(pose.subarray(3, 7), 4 * this.count);
    this.shade.array.set(color, 3 * this.count);
    ++this.count;
  }
  finish() {
    this.object.geometry.maxInstancedCount = this.count;
    this.object.visible = this.count > 0;
    for (const values of [this.place, this.turn, this.shade]) values.needsUpdate = true;
  }
}

const AT_REST = new Float32Array([0, 0, 0, 0, 0, 0, 1]);
const GHOST_OPACITY = 0.25;

class Bodies {
  constructor(data, scene) {
    this.data = data;
    this.scene = scene;
    // Nobody sees the inner sides of closed meshes.
    this.materials = [bodyMaterial(1, THREE.DoubleSide), bodyMaterial(1, THREE.FrontSide)];
    this.ghostMaterial = bodyMaterial(GHOST_OPACITY, THREE.DoubleSide);
    Object.assign(this.ghostMaterial, { transparent: true, depthWrite: false });
    this.ofMesh = new Map();
    this.ofBody = new Map();
    this.ghosts = new Map();
    this.showGhosts = false;
    this.coarse = false;
  }

  set opacity(value) {
    for (const material of this.materials) {
      material.uniforms.opacity.value = value;
      material.transparent = value < 1;
      material.depthWrite = value === 1;
    }
  }

  /** Shows all bodies of a frame; `colorOf` gives a body's colour. */
  show(frame, colorOf) {
    for (const instances of this.ofMesh.values()) instances.clear();
    for (const map of [this.ofBody, this.ghosts]) for (const { object } of map.values()) object.visible = false;
    this.data.bodies.forEach((body, b) => {
      const mesh = this.data.meshOf(frame, b);
      if (!mesh) return;
      if (body.motion === "deforming") {
        this.#showDeformed(this.ofBody, this.#materialOf(mesh), frame, b, colorOf(b));
        if (this.showGhosts && body.sheet && frame > 0 && this.data.meshOf(frame - 1, b))
          this.#showDeformed(this.ghosts, this.ghostMaterial, frame - 1, b, PLAIN);
      } else {
        const pose = this.data.poseOf(frame, b);
        if (Number.isFinite(pose[0] + pose[1] + pose[2] + pose[3] + pose[6])) this.#instancesOf(mesh).add(pose, colorOf(b));
      }
    });
    for (const instances of this.ofMesh.values()) instances.finish();
    for (const map of [this.ofMesh, this.ofBody]) for (const drawn of map.values()) drawn.coarse = this.coarse;
  }

  #materialOf(mesh) { return this.materials[mesh.closed ? 1 : 0]; }

  #instancesOf(mesh) {
    if (!this.ofMesh.has(mesh)) {
      const instances = new Instances(mesh, this.data.bodies.length, this.#materialOf(mesh));
      this.ofMesh.set(mesh, instances);
      this.scene.add(instances.object);
    }
    return this.ofMesh.get(mesh);
  }

  #showDeformed(map, material, frame, b, color) {
    const mesh = this.data.meshOf(frame, b), positions = this.data.positionsOf(frame, b);
    let drawn = map.get(b);
    if (!drawn || drawn.of !== mesh) {
      if (drawn) this.scene.remove(drawn.object);
      drawn = new Instances({ triangles: mesh.triangles, vertices: new Float32Array(positions) }, 1, material);
      drawn.of = mesh;
      map.set(b, drawn);
      this.scene.add(drawn.object);
    }
    drawn.positions.array.set(positions);
    drawn.positions.needsUpdate = true;
    drawn.clear();
    drawn.add(AT_REST, color);
    drawn.finish();
  }

  /** The body, triangle and vertex that a ray meets first; null if it meets none. */
  pick(frame, origin, direction) {
    let best = null, nearest = Infinity;
    this.data.bodies.forEach((body, b) => {
      const mesh = this.data.meshOf(frame, b);
      if (!mesh) return;
      const points = this.data.verticesAt(frame, b);
      if (!meetsBox(origin, direction, boxAround(points))) return;
      const corner = (t, k) => Array.from(points.subarray(3 * mesh.triangles[3 * t + k], 3 * mesh.triangles[3 * t + k] + 3));
      for (let t = 0; t < mesh.triangles.length / 3; ++t) {
        const corners = [corner(t, 0), corner(t, 1), corner(t, 2)];
        const distance = meeting(origin, direction, ...corners);
        if (distance >= nearest) continue;
        nearest = distance;
        const at = add(origin, scaled(direction, distance));
        const away = corners.map((p) => size(minus(p, at)));
        best = { body: b, triangle: t, vertex: mesh.triangles[3 * t + away.indexOf(Math.min(...away))] };
      }
    });
    return best;
  }
}
