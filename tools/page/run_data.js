// The runs of one scene, unpacked: bones and the pressure on them, the muscle's triangles, positions, depths and pressures of
// each node at each moment.
import { BufferAttribute, BufferGeometry } from "three";

import { placeVertices, summed, unpackSteps, unpackTriangles, unpackWords } from "./unpack.js";

export const ON_BONES = "bone_pressure"; // a kind of colour: pressure on the bones, without the muscle
const bones = new Map(); // meshes that scenes share

export async function sceneData(told, meshes) {
  const corners = await unpackTriangles(told.corners);
  const order = summed(await unpackWords(told.order, 32), told.vertices);
  const attached = await unpackWords(told.attached, 8);
  const runs = await Promise.all(told.runs.map((run) => runData(run, told, meshes)));
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

async function runData(told, { vertices, bones: skeleton }, meshes) {
  const onBones = await Promise.all((told.bone_pressures ?? []).map(async ({ bone, step_pa: step, text }) => {
    const count = meshes[skeleton[bone].mesh].vertices;
    return { bone, step, count, words: summed(await unpackWords(text, 16), count) };
  }));
  const kinds = Object.entries(told.depths);
  const [steps, ...words] = await Promise.all([
    unpackSteps(told.positions, vertices),
    ...kinds.map(([, { text }]) => unpackWords(text, 16).then((differences) => summed(differences, vertices))),
  ]);
  const values = kinds.map(([kind, { step_m: step }], i) => [kind, { step: kind === "pressure" ? step : 1e3 * step, words: words[i] }]);
  return { told, steps, onBones, values: Object.fromEntries(values) };
}

// `kind`: depth (mm) of the node or of the deepest point of the surface around it, or pressure (Pa) on the node. NaN where the
// run did not keep it.
export function valueAt(run, kind, moment, node, vertices) {
  const values = run.values[kind];
  return values ? values.step * values.words[moment * vertices + node] : NaN;
}

// `kind`: what `valueAt` takes, or what bones are coloured by.
export const hasKind = (run, kind) => (kind === ON_BONES ? run.told.tells_bones : Boolean(run.values[kind]));

// Calls `visit` with a bone, a vertex of it and its pressure (Pa).
export function pressuresOnBones(run, moment, visit) {
  for (const { bone, step, count, words } of run.onBones) {
    for (let vertex = 0; vertex < count; ++vertex) visit(bone, vertex, step * words[moment * count + vertex]);
  }
}

export function largestAt(run, kind, moment, vertices) {
  let onBones = 0;
  if (kind === ON_BONES) {
    pressuresOnBones(run, moment, (bone, vertex, pressure) => { onBones = Math.max(onBones, pressure); });
    return onBones;
  }
  let most = run.values[kind] ? 0 : NaN;
  for (let node = 0; node < vertices; ++node) most = Math.max(most, valueAt(run, kind, moment, node, vertices));
  return most;
}
