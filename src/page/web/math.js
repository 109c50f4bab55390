"use strict";
// Points and directions are arrays of three numbers.

const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const scaled = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
const mix = (a, b, share) => add(scaled(a, 1 - share), scaled(b, share));
const size = (a) => Math.sqrt(dot(a, a));

/**
 * Adds `weight` times a point of a mesh in the world to three numbers of `sum`: three numbers of `points` from `p` on, at
 * the pose in seven numbers of `poses` from `q` on, a position and a quaternion x y z w of any length.
 */
function addPlaced(sum, at, poses, q, points, p, weight) {
  const x = points[p], y = points[p + 1], z = points[p + 2];
  const i = poses[q + 3], j = poses[q + 4], k = poses[q + 5], w = poses[q + 6];
  const s = 2 / (i * i + j * j + k * k + w * w);
  const u = j * z - k * y, v = k * x - i * z, t = i * y - j * x;
  sum[at] += weight * (x + s * (w * u + j * t - k * v) + poses[q]);
  sum[at + 1] += weight * (y + s * (w * v + k * u - i * t) + poses[q + 1]);
  sum[at + 2] += weight * (z + s * (w * t + i * v - j * u) + poses[q + 2]);
}

/** The unit vector that frame_columns.cpp has unfolded into a square. */
function folded(u, v) {
  let x = 2 * u - 1, y = 2 * v - 1;
  const z = 1 - Math.abs(x) - Math.abs(y);
  if (z < 0) [x, y] = [Math.sign(x) * (1 - Math.abs(y)), Math.sign(y) * (1 - Math.abs(x))];
  return scaled([x, y, z], 1 / size([x, y, z]));
}

/** Where a ray meets a triangle, as a distance along the ray; Infinity if nowhere. */
function meeting(origin, direction, a, b, c) {
  const u = minus(b, a), v = minus(c, a), p = cross(direction, v), area = dot(u, p);
  if (area === 0) return Infinity;
  const from = minus(origin, a), s = dot(from, p) / area;
  if (s < 0 || s > 1) return Infinity;
  const q = cross(from, u), t = dot(direction, q) / area;
  if (t < 0 || s + t > 1) return Infinity;
  const distance = dot(v, q) / area;
  return distance > 0 ? distance : Infinity;
}

/** True if a ray meets a box [lower, upper]. */
function meetsBox(origin, direction, [lower, upper]) {
  let near = 0, far = Infinity;
  for (let k = 0; k < 3; ++k) {
    const one = (lower[k] - origin[k]) / direction[k], two = (upper[k] - origin[k]) / direction[k];
    if (direction[k] === 0) {
      if (origin[k] < lower[k] || origin[k] > upper[k]) return false;
      continue;
    }
    near = Math.max(near, Math.min(one, two));
    far = Math.min(far, Math.max(one, two));
  }
  return near <= far;
}

/** The box around points, three numbers each. */
function boxAround(points) {
  const lower = [Infinity, Infinity, Infinity], upper = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < points.length; i += 3)
    for (let k = 0; k < 3; ++k) {
      lower[k] = Math.min(lower[k], points[i + k]);
      upper[k] = Math.max(upper[k], points[i + k]);
    }
  return [lower, upper];
}
