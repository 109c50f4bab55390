"use strict";
// Fewer triangles, for browsers that draw by software while they play.

const COARSE_CELLS = 9;  // along the longest side of a mesh

/**
 * The triangles of a mesh after all vertices of a cell became one of them; those that became a line or a point are left
 * out. The vertices stay as they are, so a mesh that deforms keeps its coarse triangles.
 */
function coarseTriangles({ vertices, triangles }) {
  const [lower, upper] = boxAround(vertices), cell = Math.max(...minus(upper, lower)) / COARSE_CELLS;
  const firsts = new Map(), first = new Uint32Array(vertices.length / 3);
  for (let v = 0; v < first.length; ++v) {
    const key = [0, 1, 2].map((k) => Math.floor((vertices[3 * v + k] - lower[k]) / cell)).join();
    if (!firsts.has(key)) firsts.set(key, v);
    first[v] = firsts.get(key);
  }
  const kept = [];
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = [first[triangles[t]], first[triangles[t + 1]], first[triangles[t + 2]]];
    if (a !== b && b !== c && c !== a) kept.push(a, b, c);
  }
  return Uint32Array.from(kept);
}
