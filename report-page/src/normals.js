// Normals of a surface: smooth, but for edges.

/** Cosine of the angle between faces that meet in an edge. */
const EDGE = Math.cos((42 * Math.PI) / 180);

/** Returns the normals of the faces, with their areas as lengths, and the areas. */
function faceNormals(positions, triangles) {
  const normals = new Float32Array(triangles.length);
  const areas = new Float32Array(triangles.length / 3);
  for (let f = 0; f < areas.length; f += 1) {
    const [a, b, c] = [0, 1, 2].map((corner) => 3 * triangles[3 * f + corner]);
    const u = [0, 1, 2].map((k) => positions[b + k] - positions[a + k]);
    const v = [0, 1, 2].map((k) => positions[c + k] - positions[a + k]);
    const normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    normals.set(normal, 3 * f);
    areas[f] = Math.hypot(...normal);
  }
  return { normals, areas };
}

/** Returns the faces around each point: those of point i stand from `first[i]` up to `first[i + 1]`. */
function facesAround(points, triangles) {
  const first = new Uint32Array(points + 1);
  triangles.forEach((point) => {
    first[point + 1] += 1;
  });
  for (let i = 0; i < points; i += 1) {
    first[i + 1] += first[i];
  }
  const [next, faces] = [first.slice(), new Uint32Array(triangles.length)];
  triangles.forEach((point, corner) => {
    faces[next[point]] = Math.floor(corner / 3);
    next[point] += 1;
  });
  return { first, faces };
}

/**
 * Returns a shape whose triangles share no corners: the normal of a corner is the mean over the faces around it that lie
 * within the angle of an edge, by their areas.
 */
export function creased(shape) {
  const { positions, triangles, sources } = shape;
  const { normals: ofFaces, areas } = faceNormals(positions, triangles);
  const { first, faces } = facesAround(sources.length, triangles);
  const [places, normals] = [new Float32Array(3 * triangles.length), new Float32Array(3 * triangles.length)];
  for (let corner = 0; corner < triangles.length; corner += 1) {
    const [point, own] = [triangles[corner], Math.floor(corner / 3)];
    const [x, y, z] = [ofFaces[3 * own], ofFaces[3 * own + 1], ofFaces[3 * own + 2]];
    let [nx, ny, nz] = [0, 0, 0];
    for (let i = first[point]; i < first[point + 1]; i += 1) {
      const face = faces[i];
      const [fx, fy, fz] = [ofFaces[3 * face], ofFaces[3 * face + 1], ofFaces[3 * face + 2]];
      const dot = x * fx + y * fy + z * fz;
      if (Math.abs(dot) >= EDGE * areas[own] * areas[face]) {
        const side = dot < 0 ? -1 : 1;
        nx += side * fx;
        ny += side * fy;
        nz += side * fz;
      }
    }
    const length = Math.hypot(nx, ny, nz) || 1;
    normals.set([nx / length, ny / length, nz / length], 3 * corner);
    places.set(positions.subarray(3 * point, 3 * point + 3), 3 * corner);
  }
  return {
    ...shape,
    positions: places,
    normals,
    triangles: Uint32Array.from({ length: triangles.length }, (_, i) => i),
    sources: Uint32Array.from(triangles, (point) => sources[point]),
  };
}
