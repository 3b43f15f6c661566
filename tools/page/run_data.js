// The runs of one scene, unpacked: bones, the muscle's triangles, positions, depths and pressures of each node at each moment.
import { BufferAttribute, BufferGeometry } from "three";

import { placeVertices, summed, unpackSteps, unpackTriangles, unpackWords } from "./unpack.js";

const bones = new Map(); // meshes that scenes share

export async function sceneData(told, meshes) {
  const corners = await unpackTriangles(told.corners);
  const order = summed(await unpackWords(told.order, 32), told.vertices);
  const attached = await unpackWords(told.attached, 8);
  const runs = await Promise.all(told.runs.map((run) => runData(run, told.vertices)));
  const skeleton = await Promise.all(told.bones.map(async (bone) => ({ name: bone.name, ...(await boneData(bone.mesh, meshes)) })));
  const frames = [...new Set(told.runs.flatMap((run) => run.frames))].sort((a, b) => a - b);
  return { told, corners, order, attached, runs, bones: skeleton, frames };
}

function boneData(key, meshes) {
  if (!bones.has(key)) bones.set(key, unpackBone(meshes[key]));
  return bones.get(key);
}

async function unpackBone(mesh) {
  const positions = placeVertices(new Float32Array(3 * mesh.vertices), await unpackSteps(mesh.positions, mesh.vertices), 0, mesh.vertices, mesh);
  const corners = await unpackTriangles(mesh.corners);
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(positions, 3));
  geometry.setIndex(new BufferAttribute(corners, 1));
  geometry.computeVertexNormals();
  return { positions, corners, geometry };
}

async function runData(told, vertices) {
  const kinds = Object.entries(told.depths);
  const [steps, ...words] = await Promise.all([
    unpackSteps(told.positions, vertices),
    ...kinds.map(([, { text }]) => unpackWords(text, 16).then((differences) => summed(differences, vertices))),
  ]);
  const values = kinds.map(([kind, { step_m: step }], i) => [kind, { step: kind === "pressure" ? step : 1e3 * step, words: words[i] }]);
  return { told, steps, values: Object.fromEntries(values) };
}

// `kind`: depth (mm) of the node or of the deepest point of the surface around it, or pressure (Pa) on the node. NaN where the
// run did not keep it.
export function valueAt(run, kind, moment, node, vertices) {
  const values = run.values[kind];
  return values ? values.step * values.words[moment * vertices + node] : NaN;
}

export function largestAt(run, kind, moment, vertices) {
  let most = run.values[kind] ? 0 : NaN;
  for (let node = 0; node < vertices; ++node) most = Math.max(most, valueAt(run, kind, moment, node, vertices));
  return most;
}
