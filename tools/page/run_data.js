// The runs of one scene, unpacked: bones, the muscle's triangles, positions and depths of each node at each moment.
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
  const [steps, depths] = await Promise.all([
    unpackSteps(told.positions, vertices),
    unpackWords(told.depths, 16).then((words) => summed(words, vertices)),
  ]);
  return { told, steps, depths };
}

export function depthMm(run, moment, node, vertices) {
  return 1e3 * run.told.depth_step_m * run.depths[moment * vertices + node];
}

export function deepestMm(run, moment, vertices) {
  let most = 0;
  for (let i = moment * vertices; i < (moment + 1) * vertices; ++i) if (run.depths[i] > most) most = run.depths[i];
  return 1e3 * run.told.depth_step_m * most;
}
