// Undoes tools/musclebench/page/packed.py: base64, deflate, bytes by weight, differences.

export async function unpackBytes(text) {
  const letters = atob(text);
  const packed = new Uint8Array(letters.length);
  for (let i = 0; i < letters.length; ++i) packed[i] = letters.charCodeAt(i);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

export async function unpackText(text) {
  return new TextDecoder().decode(await unpackBytes(text));
}

export async function unpackWords(text, bits) {
  const planes = await unpackBytes(text);
  const bytes = bits / 8;
  const words = new { 8: Uint8Array, 16: Uint16Array, 32: Uint32Array }[bits](planes.length / bytes);
  for (let plane = 0; plane < bytes; ++plane) {
    for (let i = 0; i < words.length; ++i) words[i] |= planes[plane * words.length + i] << (8 * plane);
  }
  // 0, 1, 2, 3 stand for 0, -1, 1, -2.
  for (let i = 0; i < words.length; ++i) words[i] = (words[i] >>> 1) ^ -(words[i] & 1);
  return words;
}

// Sums up differences along each row, in place; as the array's type wraps round, so do the differences.
export function summed(words, rowLength) {
  for (let row = 0; row < words.length; row += rowLength) {
    for (let i = row + 1; i < row + rowLength; ++i) words[i] += words[i - 1];
  }
  return words;
}

// Positions as (moments, 3, vertices) whole numbers of steps.
export async function unpackSteps(text, vertices) {
  const words = summed(await unpackWords(text, 16), vertices);
  const moment = 3 * vertices;
  for (let i = moment; i < words.length; ++i) words[i] += words[i - moment];
  return words;
}

// Fills `out` with x, y, z of each vertex, in metres.
export function placeVertices(out, steps, moment, vertices, shape) {
  for (let axis = 0; axis < 3; ++axis) {
    const from = (3 * moment + axis) * vertices;
    for (let i = 0; i < vertices; ++i) out[3 * i + axis] = shape.origin_m[axis] + shape.step_m * steps[from + i];
  }
  return out;
}

export async function unpackTriangles(text) {
  const words = await unpackWords(text, 32);
  return summed(words, words.length);
}
