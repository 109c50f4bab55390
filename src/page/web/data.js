"use strict";
// What src/page/frame_columns.cpp has packed: columns of all frames, and the records that they make.

/** The bits of `flags` of a contact, in the order in which frame_columns.cpp sets them. */
const FLAGS = ["source_is_b", "grazing", "reprojected", "of_sheet", "unknown_side"];
/** Found, as `--json` names it. */
const FOUND = ["full", "walk", "prediction", "self", "near", "crossing", "remembered", "tangled", "separation"];
const FOUND_TEXTS = {
  full: "found by a full ray",
  walk: "found by a walk from the last step's triangle",
  prediction: "found by a walk to a predicted triangle",
  self: "found by a ray from a vertex that is inside its own body",
  near: "closer than the margin, or than the sheet's thickness",
  crossing: "the two meet during the step",
  remembered: "the two met in an earlier step and are still on the wrong side of each other",
  tangled: "an edge runs through a triangle, and the step in which that began is unknown",
  separation: "measured along the direction in which the two separate soonest",
};
const NO_MESH = 0xffffffff;
const ARRAY_TYPES = { u8: Uint8Array, u16: Uint16Array, u32: Uint32Array, f32: Float32Array, f64: Float64Array };

/** The bytes of base64 text. */
function bytesOf(text) {
  const letters = atob(text);
  const bytes = new Uint8Array(letters.length);
  for (let i = 0; i < letters.length; ++i) bytes[i] = letters.charCodeAt(i);
  return bytes;
}

async function inflated(bytes) {
  if (typeof DecompressionStream === "undefined")
    throw new Error("this browser is too old: it has no DecompressionStream");
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** An array of the directory: bytes of equal rank lie together, and numbers are differences. */
function unpacked(bytes, entry) {
  const width = Number(entry.type.slice(1)) / 8, count = entry.count;
  const raw = new Uint8Array(count * width);
  for (let rank = 0; rank < width; ++rank) {
    const from = entry.offset + rank * count;
    for (let i = 0; i < count; ++i) raw[i * width + rank] = bytes[from + i];
  }
  if (entry.stride > 0) {
    const bits = new { 1: Uint8Array, 2: Uint16Array, 4: Uint32Array }[width](raw.buffer);
    for (let i = entry.stride; i < count; ++i) bits[i] += bits[i - entry.stride];
  }
  return new ARRAY_TYPES[entry.type](raw.buffer);
}

/** The scene: what the page was made with, meshes, bodies, and frames. */
class SceneData {
  static async read(text) {
    const bytes = await inflated(bytesOf(text));
    const size = new DataView(bytes.buffer).getUint32(0, true);
    const head = JSON.parse(new TextDecoder().decode(bytes.subarray(4, 4 + size)));
    return new SceneData(head, bytes.subarray(4 + size));
  }

  constructor(head, bytes) {
    Object.assign(this, head);
    this.columns = {};
    for (const [name, entry] of Object.entries(head.arrays)) this.columns[name] = unpacked(bytes, entry);
    this.frameCount = head.frame_count;
    this.meshes.forEach((mesh, m) => {
      mesh.vertices = this.columns[`mesh_vertices/${m}`];
      mesh.triangles = this.columns[`mesh_triangles/${m}`];
      mesh.patches = this.columns[`mesh_patches/${m}`];
    });
    this.bodies.forEach((body, b) => this.#placeBody(body, b));
  }

  #placeBody(body, b) {
    body.places = this.columns[`places/${b}`];
    if (body.motion !== "deforming") return;
    if (body.size !== undefined) {
      const values = new Float32Array(body.places.length);
      for (let i = 0; i < values.length; ++i) values[i] = body.lower + (body.places[i] / 65535) * body.size;
      body.places = values;
    }
    body.begins = [];
    let at = 0;
    for (let f = 0; f < this.frameCount; ++f) {
      body.begins.push(at);
      const mesh = this.meshOf(f, b);
      if (mesh) at += mesh.vertices.length;
    }
  }

  /** The mesh of a body in a frame; undefined if the body is not there. */
  meshOf(frame, body) {
    return this.meshes[this.columns.body_mesh[frame * this.bodies.length + body]];
  }
  /** True if a body's mesh has a vertex of that number in a frame. */
  hasVertex(frame, body, vertex) {
    const mesh = this.meshOf(frame, body);
    return mesh !== undefined && vertex < mesh.vertices.length / 3;
  }
  /** True if the step of a frame had no place for a body: it is not finite, or its world is not active. */
  isLeftOut(frame, body) {
    return this.columns.body_left_out[frame * this.bodies.length + body] === 1;
  }
  /** Seven numbers: position and quaternion x y z w. */
  poseOf(frame, body) {
    return this.bodies[body].places.subarray(7 * frame, 7 * frame + 7);
  }
  /** World positions of a deforming body's vertices. */
  positionsOf(frame, body) {
    const { places, begins } = this.bodies[body];
    return places.subarray(begins[frame], begins[frame] + this.meshOf(frame, body).vertices.length);
  }
  /** Adds `weight` times where a vertex is in the world to three numbers of `sum`. */
  addVertex(sum, at, frame, body, vertex, weight) {
    const { motion, places, begins } = this.bodies[body];
    if (motion === "deforming") {
      const from = begins[frame] + 3 * vertex;
      for (let k = 0; k < 3; ++k) sum[at + k] += weight * places[from + k];
    } else {
      addPlaced(sum, at, places, 7 * frame, this.meshOf(frame, body).vertices, 3 * vertex, weight);
    }
  }
  /** Where a vertex is in the world. */
  vertexAt(frame, body, vertex) {
    const point = [0, 0, 0];
    this.addVertex(point, 0, frame, body, vertex, 1);
    return point;
  }
  /** World positions of all vertices of a body, three numbers each. */
  verticesAt(frame, body) {
    if (this.bodies[body].motion === "deforming") return this.positionsOf(frame, body);
    const rest = this.meshOf(frame, body).vertices, result = new Float32Array(rest.length);
    for (let i = 0; i < rest.length; i += 3) addPlaced(result, i, this.bodies[body].places, 7 * frame, rest, i, 1);
    return result;
  }

  contactRange(frame) {
    return [this.columns.contact_begin[frame], this.columns.contact_begin[frame + 1]];
  }

  /** A contact by its place in its frame, as `pierce detect --json` writes it, and its age. */
  contact(frame, number) {
    const c = this.columns, i = c.contact_begin[frame] + number;
    const flags = c.contact_flags[i], is = Object.fromEntries(FLAGS.map((name, bit) => [name, (flags >> bit & 1) === 1]));
    const record = {
      a: c.contact_a[i], b: c.contact_b[i], source: is.source_is_b ? "b" : "a",
      vertex: c.contact_vertex[i], triangle: c.contact_triangle[i],
      barycentric: this.#barycentric(i), point_a: null, point_b: null, normal: this.contactNormal(i),
      distance: c.contact_distance[i], grazing: is.grazing, reprojected: is.reprojected,
      found: FOUND[c.contact_found[i]], age: c.contact_age[i],
    };
    if (is.unknown_side) record.unknown_side = true;
    if (c.contact_edge_end[i] > 0) {
      record.edge_end = c.contact_edge_end[i] - 1;
      record.along = this.rounded ? c.contact_along[i] / 65535 : c.contact_along[i];
    }
    const points = [0, 0, 0, 0, 0, 0];
    this.contactPoints(frame, i, points, 0);
    [record.point_a, record.point_b] = [points.slice(0, 3), points.slice(3)];
    return record;
  }

  /** Six numbers of `out`: the contact's points on body a and on body b; `i`: its place in the columns. */
  contactPoints(frame, i, out, at) {
    const c = this.columns;
    if (!this.rounded) {
      out[at] = c.contact_point_a_x[i];
      out[at + 1] = c.contact_point_a_y[i];
      out[at + 2] = c.contact_point_a_z[i];
      out[at + 3] = c.contact_point_b_x[i];
      out[at + 4] = c.contact_point_b_y[i];
      out[at + 5] = c.contact_point_b_z[i];
      return;
    }
    const reversed = (c.contact_flags[i] & 1) === 1, end = c.contact_edge_end[i];
    const [source, target] = reversed ? [c.contact_b[i], c.contact_a[i]] : [c.contact_a[i], c.contact_b[i]];
    const of = at + (reversed ? 3 : 0), against = at + (reversed ? 0 : 3);
    out.fill(0, at, at + 6);
    const along = end > 0 ? c.contact_along[i] / 65535 : 0;
    this.addVertex(out, of, frame, source, c.contact_vertex[i], 1 - along);
    if (end > 0) this.addVertex(out, of, frame, source, end - 1, along);
    const corners = this.meshOf(frame, target).triangles, triangle = 3 * c.contact_triangle[i];
    const u = c.contact_u[i] / 65535, v = c.contact_v[i] / 65535;
    this.addVertex(out, against, frame, target, corners[triangle], u);
    this.addVertex(out, against, frame, target, corners[triangle + 1], v);
    this.addVertex(out, against, frame, target, corners[triangle + 2], 1 - u - v);
  }
  /** The normal of a contact by its place in the columns, from a to b. */
  contactNormal(i) {
    const c = this.columns;
    if (!this.rounded) return [c.contact_normal_x[i], c.contact_normal_y[i], c.contact_normal_z[i]];
    return folded(c.contact_normal_u[i] / 65535, c.contact_normal_v[i] / 65535);
  }

  /** Why vertices of a body have no contact, in a frame: {other, text}. */
  reasonsOf(frame, body, vertex) {
    const c = this.columns, result = [];
    for (let i = c.reason_begin[frame]; i < c.reason_begin[frame + 1]; ++i)
      if (c.reason_body[i] === body && c.reason_vertex[i] === vertex)
        result.push({ other: c.reason_other[i], text: this.reason_texts[c.reason_text[i]] });
    return result;
  }

  #barycentric(i) {
    const c = this.columns;
    if (!this.rounded) return [c.contact_weight_0[i], c.contact_weight_1[i], c.contact_weight_2[i]];
    const u = c.contact_u[i] / 65535, v = c.contact_v[i] / 65535;
    return [u, v, 1 - u - v];
  }
}
