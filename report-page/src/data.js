// Data of the page: base64 of zlib bytes, and the frames of the view in them.

/** Returns the bytes of a text `base64,…` in the zlib format. */
export async function inflate(text) {
  const packed = Uint8Array.from(atob(text.slice(text.indexOf(",") + 1).trim()), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Undoes differences in place; the numbers wrap around as those of the writer. */
function accumulate(numbers) {
  for (let i = 1; i < numbers.length; i += 1) {
    numbers[i] += numbers[i - 1];
  }
  return numbers;
}

/** Reader of the numbers of a frame, one array after the other. */
class ArrayReader {
  constructor(bytes) {
    this.bytes = bytes;
    this.offset = 0;
  }

  take(Type, count) {
    const end = this.offset + count * Type.BYTES_PER_ELEMENT;
    const numbers = new Type(this.bytes.slice(this.offset, end).buffer);
    this.offset = end;
    return accumulate(numbers);
  }
}

/** Returns the positions of a part as x, y, z of each point, in metres. */
function positions(reader, { points, low, high }) {
  const result = new Float32Array(3 * points);
  for (let axis = 0; axis < 3; axis += 1) {
    const steps = reader.take(Uint16Array, points);
    const size = (high[axis] - low[axis]) / 65535;
    steps.forEach((step, i) => {
      result[3 * i + axis] = low[axis] + step * size;
    });
  }
  return result;
}

/** Returns a frame with the arrays of each of its parts. */
export async function decodeFrame({ time, plane, parts, bytes }) {
  const reader = new ArrayReader(await inflate(bytes));
  const decoded = parts.map((part) => {
    const at = positions(reader, part);
    const corners = reader.take(Uint32Array, 3 * part.triangles + 2 * part.edges);
    const values = part.ranges.map(() => reader.take(Uint8Array, part.points));
    return {
      kind: part.kind,
      positions: at,
      triangles: corners.subarray(0, 3 * part.triangles),
      edges: corners.subarray(3 * part.triangles),
      ranges: part.ranges,
      values,
    };
  });
  return { time, plane, parts: decoded };
}
