// Closest points on triangles: which bone is nearest to a node, and how far its surface is (Ericson, Real-Time Collision
// Detection, 5.1.5).

export function closestDistance(point, positions, corners) {
  let best = Infinity;
  const a = [0, 0, 0], b = [0, 0, 0], c = [0, 0, 0];
  for (let i = 0; i < corners.length; i += 3) {
    for (let axis = 0; axis < 3; ++axis) {
      a[axis] = positions[3 * corners[i] + axis];
      b[axis] = positions[3 * corners[i + 1] + axis];
      c[axis] = positions[3 * corners[i + 2] + axis];
    }
    const squared = squaredDistance(point, a, b, c);
    if (squared < best) best = squared;
  }
  return Math.sqrt(best);
}

const dot = (u, v) => u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
const minus = (u, v) => [u[0] - v[0], u[1] - v[1], u[2] - v[2]];

function squaredDistance(p, a, b, c) {
  const ab = minus(b, a), ac = minus(c, a), ap = minus(p, a);
  const d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return dot(ap, ap);
  const bp = minus(p, b);
  const d3 = dot(ab, bp), d4 = dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return dot(bp, bp);
  const vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return along(ap, ab, d1 / (d1 - d3));
  const cp = minus(p, c);
  const d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return dot(cp, cp);
  const vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return along(ap, ac, d2 / (d2 - d6));
  const va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return along(bp, minus(c, b), (d4 - d3) / (d4 - d3 + d5 - d6));
  const share = 1 / (va + vb + vc), v = vb * share, w = vc * share;
  const off = [ap[0] - v * ab[0] - w * ac[0], ap[1] - v * ab[1] - w * ac[1], ap[2] - v * ab[2] - w * ac[2]];
  return dot(off, off);
}

function along(fromStart, edge, share) {
  const off = [fromStart[0] - share * edge[0], fromStart[1] - share * edge[1], fromStart[2] - share * edge[2]];
  return dot(off, off);
}

// A pose is a rotation by rows and a translation; this is where a point of space was in the bone's rest pose.
export function intoRestPose(point, pose) {
  const off = [point[0] - pose[9], point[1] - pose[10], point[2] - pose[11]];
  return [0, 1, 2].map((axis) => pose[axis] * off[0] + pose[3 + axis] * off[1] + pose[6 + axis] * off[2]);
}
