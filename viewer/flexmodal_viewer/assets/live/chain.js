"use strict";
// A chain or tree of joints in a posture: where they are, its mass matrix, its Jacobians. World axes, SI units.
// Every joint stands behind its parent in the list; the base is −1.
const Chain = (() => {
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const plus = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
  const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
  const times = (s, a) => [s * a[0], s * a[1], s * a[2]];
  // 3 × 3 matrices are flat, row by row.
  const turn = (r, a) => [dot(r.slice(0, 3), a), dot(r.slice(3, 6), a), dot(r.slice(6, 9), a)];
  function product(a, b) {
    const c = new Array(9).fill(0);
    for (let i = 0; i < 3; i++) for (let j = 0; j < 3; j++) for (let k = 0; k < 3; k++) c[3 * i + j] += a[3 * i + k] * b[3 * k + j];
    return c;
  }
  const transpose = (a) => [a[0], a[3], a[6], a[1], a[4], a[7], a[2], a[5], a[8]];

  // Rotation by an angle about a unit axis (Rodrigues).
  function rotation(axis, angle) {
    const [x, y, z] = axis;
    const c = Math.cos(angle);
    const s = Math.sin(angle);
    const d = 1 - c;
    return [
      c + d * x * x, d * x * y - s * z, d * x * z + s * y,
      d * x * y + s * z, c + d * y * y, d * y * z - s * x,
      d * x * z - s * y, d * y * z + s * x, c + d * z * z,
    ];
  }

  // Frame and axis of each joint in the world, the joints at q.
  const BASE = { r: [1, 0, 0, 0, 1, 0, 0, 0, 1], p: [0, 0, 0] };
  function frames(joints, q) {
    const found = [];
    joints.forEach((joint, i) => {
      const below = joint.parent < 0 ? BASE : found[joint.parent];
      let p = plus(below.p, turn(below.r, joint.offset));
      let r = product(below.r, joint.rotation);
      const axis = turn(r, joint.axis);
      if (joint.turns) r = product(r, rotation(joint.axis, q[i]));
      else p = plus(p, times(q[i], axis));
      found.push({ r, p, axis, turns: joint.turns, parent: joint.parent });
    });
    return found;
  }

  // Mass matrix by composite bodies: what moves with joint j, its momentum about the origin for a unit velocity
  // of j, seen by every joint before it (Featherstone, Rigid Body Dynamics Algorithms, 6.2).
  function mass(joints, placed) {
    const n = joints.length;
    const found = new Float64Array(n * n);
    const total = new Float64Array(n);
    const moment = joints.map(() => [0, 0, 0]);
    const inertia = joints.map(() => new Array(9).fill(0));
    const motion = placed.map((f) => (f.turns ? [f.axis, cross(f.p, f.axis)] : [[0, 0, 0], f.axis]));
    for (let j = n - 1; j >= 0; j--) {
      const { mass: m, centre, inertia: own, parent } = joints[j];
      const { r, p } = placed[j];
      const c = plus(p, turn(r, centre));
      const about = product(product(r, own), transpose(r));
      for (let a = 0; a < 3; a++) for (let b = 0; b < 3; b++) about[3 * a + b] += m * ((a === b ? dot(c, c) : 0) - c[a] * c[b]);
      total[j] += m;
      moment[j] = plus(moment[j], times(m, c));
      inertia[j] = inertia[j].map((value, k) => value + about[k]);
      if (parent >= 0) { // what moves with this joint moves with the one it stands on
        total[parent] += total[j];
        moment[parent] = plus(moment[parent], moment[j]);
        inertia[parent] = inertia[parent].map((value, k) => value + inertia[j][k]);
      }
      const [w, v] = motion[j];
      const linear = plus(times(total[j], v), cross(w, moment[j]));
      const angular = plus(turn(inertia[j], w), cross(moment[j], v));
      for (let i = j; i >= 0; i = joints[i].parent) {
        const value = dot(motion[i][0], angular) + dot(motion[i][1], linear);
        found[i * n + j] = value;
        found[j * n + i] = value;
      }
      found[j * n + j] += joints[j].rotor;
    }
    return found;
  }

  // World position of a point { joint, offset }; joint −1 is the base.
  const position = (placed, point) =>
    point.joint < 0 ? [...point.offset] : plus(placed[point.joint].p, turn(placed[point.joint].r, point.offset));

  // Six rows x, y, z, rx, ry, rz over all joints.
  function jacobian(placed, point) {
    const n = placed.length;
    const rows = Array.from({ length: 6 }, () => new Float64Array(n));
    const x = position(placed, point);
    for (let j = point.joint; j >= 0; j = placed[j].parent) {
      const { axis, p, turns } = placed[j];
      const linear = turns ? cross(axis, minus(x, p)) : axis;
      for (let k = 0; k < 3; k++) {
        rows[k][j] = linear[k];
        rows[3 + k][j] = turns ? axis[k] : 0;
      }
    }
    return rows;
  }

  return { frames, mass, position, jacobian, rotation, product, transpose, turn, cross, dot, plus, minus, times };
})();
