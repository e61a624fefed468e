// Shapes of a frame: mirrored halves and quarters, bodies of revolution, and slabs of plane scenes.

import { creased } from "./normals.js";

const SEGMENTS = 72;
/** Distance from a plane of symmetry within which a point lies on it, relative to the greatest coordinate. */
const ON_PLANE = 1e-4;

/** Shape under construction: points, triangles, and for each point its point in the part. */
class Shape {
  constructor(part) {
    this.part = part;
    this.points = [];
    this.triangles = [];
    this.sources = [];
  }

  add(source, x, y, z) {
    this.points.push(x, y, z);
    this.sources.push(source);
    return this.sources.length - 1;
  }

  finish() {
    return {
      part: this.part,
      positions: new Float32Array(this.points),
      triangles: new Uint32Array(this.triangles),
      sources: new Uint32Array(this.sources),
    };
  }
}

/** Returns the part once for each combination of mirror images in these axes; points on a plane of symmetry are shared. */
function mirrored(part, axes) {
  const shape = new Shape(part);
  const reach = part.positions.reduce((most, x) => Math.max(most, Math.abs(x)), 0);
  const signs = axes.reduce((all, axis) => all.flatMap((sign) => [sign, sign.map((one, k) => (k === axis ? -one : one))]), [[1, 1, 1]]);
  const known = new Map();
  for (const sign of signs) {
    const numbers = [];
    for (let i = 0; i < part.positions.length / 3; i += 1) {
      const at = part.positions.subarray(3 * i, 3 * i + 3);
      const side = sign.map((one, k) => (Math.abs(at[k]) <= ON_PLANE * reach ? 1 : one));
      const key = `${i},${side}`;
      if (!known.has(key)) {
        known.set(key, shape.add(i, sign[0] * at[0], sign[1] * at[1], sign[2] * at[2]));
      }
      numbers.push(known.get(key));
    }
    const isTurned = sign[0] * sign[1] * sign[2] < 0;
    for (let i = 0; i < part.triangles.length; i += 3) {
      const [a, b, c] = part.triangles.subarray(i, i + 3);
      shape.triangles.push(numbers[a], numbers[isTurned ? c : b], numbers[isTurned ? b : c]);
    }
  }
  return shape.finish();
}

/** Returns the surface of revolution of the edges of a part about the z axis. */
function revolved(part) {
  const shape = new Shape(part);
  const rings = new Map();
  const ring = (point) => {
    if (!rings.has(point)) {
      const [r, , z] = part.positions.subarray(3 * point, 3 * point + 3);
      rings.set(point, shape.sources.length);
      for (let k = 0; k < SEGMENTS; k += 1) {
        const angle = (2 * Math.PI * k) / SEGMENTS;
        shape.add(point, r * Math.cos(angle), r * Math.sin(angle), z);
      }
    }
    return rings.get(point);
  };
  for (let i = 0; i < part.edges.length; i += 2) {
    const [a, b] = [ring(part.edges[i]), ring(part.edges[i + 1])];
    for (let k = 0; k < SEGMENTS; k += 1) {
      const next = (k + 1) % SEGMENTS;
      shape.triangles.push(a + k, b + k, b + next, a + k, b + next, a + next);
    }
  }
  return shape.finish();
}

/** Returns the part at a height y. */
function laid(part, y) {
  const shape = new Shape(part);
  for (let i = 0; i < part.positions.length / 3; i += 1) {
    shape.add(i, part.positions[3 * i], y, part.positions[3 * i + 2]);
  }
  shape.triangles = Array.from(part.triangles);
  return shape.finish();
}

/** Returns the walls of a slab between two heights, and its face at the second. */
function walls(part, front, back) {
  const shape = new Shape(part);
  const points = part.positions.length / 3;
  for (const y of [front, back]) {
    for (let i = 0; i < points; i += 1) {
      shape.add(i, part.positions[3 * i], y, part.positions[3 * i + 2]);
    }
  }
  for (let i = 0; i < part.edges.length; i += 2) {
    const [a, b] = part.edges.subarray(i, i + 2);
    shape.triangles.push(a, b, points + b, a, points + b, points + a);
  }
  for (const corner of part.triangles) {
    shape.triangles.push(points + corner);
  }
  return shape.finish();
}

/** Returns the shapes of a part by role: surface, section or body. */
function shapesOf(part, { dimension, mirrored: axes }, thickness) {
  if (dimension === "planar") {
    const half = (part.kind === "body" ? 0.54 : 0.5) * thickness;
    const front = { role: part.kind, ...laid(part, -half) };
    return [front, { role: part.kind === "body" ? "body" : "surface", ...walls(part, -half, half) }];
  }
  if (part.kind === "body") {
    return [{ role: "body", ...mirrored(part, []) }];
  }
  if (dimension === "axisymmetric") {
    return [{ role: "section", ...mirrored(part, [0]) }, { role: "surface", ...revolved(part) }];
  }
  const within = part.kind === "section" ? axes.filter((axis) => axis !== 1) : axes;
  return [{ role: part.kind, ...mirrored(part, within) }];
}

/** Returns all shapes of a frame; surfaces are smooth but for their edges. */
export function shapes(frame, data, thickness) {
  const all = frame.parts.flatMap((part) => shapesOf(part, data, thickness));
  return all.map((shape) => (shape.role === "section" ? shape : creased(shape)));
}
