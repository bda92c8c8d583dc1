"use strict";
// Inverse kinematics: a point held or moved, and the motion of the arm that leaves it where it is.
const Hold = (() => {
  const STEP = 0.02; // along a self-motion, in the norm of the joints [rad, m]
  const FARTHEST = 3.2;
  const NEAR = 1e-10;
  const FLAT = 1e-6; // singular values of the held rows below this part of the largest hold nothing

  const clamp = (value, low, high) => Math.min(Math.max(value, low), high);

  // Rows that are held, over the joints that may be set: 0 to 2 the place, 3 to 5 the turn.
  function rows(robot, posed, point, turned, places = robot.numbers.commanded) {
    const whole = posed.jacobian(point);
    return (turned ? whole : whole.slice(0, 3)).map((row) => places.map((place) => row[place]));
  }

  // What is missing of the target, in the world's axes; of the turn, the vector of the rotation left.
  function missing(posed, point, target) {
    const left = Chain.minus(target.position, posed.position(point));
    if (!target.turn) return left;
    const r = Chain.product(target.turn, Chain.transpose(posed.turned(point)));
    const sine = [(r[7] - r[5]) / 2, (r[2] - r[6]) / 2, (r[3] - r[1]) / 2];
    const size = Math.hypot(...sine);
    const angle = Math.atan2(size, (r[0] + r[4] + r[8] - 1) / 2);
    return [...left, ...(size > 1e-12 ? Chain.times(angle / size, sine) : sine)];
  }

  // JJᵀ as eigenvalues and vectors, which give least-norm solutions and the null space.
  function spectrum(j) {
    const m = j.length;
    const gram = new Float64Array(m * m);
    for (let a = 0; a < m; a++) for (let b = 0; b < m; b++) gram[a * m + b] = j[a].reduce((sum, value, k) => sum + value * j[b][k], 0);
    return Symmetric.eigen(gram, m);
  }

  // The step of least norm with J dq = e; directions nearly out of reach are damped.
  function leastNorm(j, e, damping) {
    const { values, vectors } = spectrum(j);
    const largest = Math.max(...values, 1e-300);
    const step = new Array(j[0].length).fill(0);
    values.forEach((value, i) => {
      if (value <= FLAT ** 2 * largest) return;
      const part = vectors[i].reduce((sum, x, a) => sum + x * e[a], 0) / (value + damping * largest);
      vectors[i].forEach((x, a) => j[a].forEach((entry, k) => { step[k] += part * x * entry; }));
    });
    return step;
  }

  // A vector without what moves the held rows.
  function project(j, v) {
    const moved = j.map((row) => row.reduce((sum, value, k) => sum + value * v[k], 0));
    const back = leastNorm(j, moved, 0);
    return v.map((value, k) => value - back[k]);
  }

  // How many joints are left to choose.
  function freedom(robot, posed, point, turned) {
    const j = rows(robot, posed, point, turned);
    const { values } = spectrum(j);
    const largest = Math.max(...values);
    return robot.numbers.commanded.length - values.filter((value) => value > 1e-10 * largest).length;
  }

  // Joints that bring the point to the target, from q, within the limits; `left` is what is missing [m, rad].
  // The joints `without` stay where they are.
  function reach(robot, q, point, target, { rounds = 40, damping = 1e-4, without = [] } = {}) {
    const { joints } = robot.numbers;
    const free = robot.numbers.commanded.filter((place) => !without.includes(place));
    let best = { q: [...q], left: Infinity };
    let now = [...q];
    for (let round = 0; round < rounds; round++) {
      const posed = robot.at(now);
      const e = missing(posed, point, target);
      const left = Math.hypot(...e);
      if (left < best.left) best = { q: [...now], left };
      if (left < NEAR) break;
      let step = leastNorm(rows(robot, posed, point, Boolean(target.turn), free), e, left < 1e-3 ? 0 : damping);
      const size = Math.max(...step.map(Math.abs));
      if (size > 0.3) step = step.map((value) => (0.3 * value) / size);
      now = [...now];
      free.forEach((place, k) => { now[place] = clamp(now[place] + step[k], joints[place].lower, joints[place].upper); });
    }
    return best;
  }

  // Postures that leave the point where it is, on both sides of q, each as far as limits and geometry let it:
  // [{ s, q }], s the length of the way from q in the norm of the joints. `downhill` gives the first direction.
  function selfMotion(robot, q, point, turned, downhill) {
    const { commanded, joints } = robot.numbers;
    const start = robot.at(q);
    const target = { position: start.position(point), turn: turned ? start.turned(point) : null };
    const first = project(rows(robot, start, point, turned), downhill);
    const size = Math.hypot(...first);
    if (freedom(robot, start, point, turned) < 1 || !(size > 1e-9 * Math.hypot(...downhill))) return [{ s: 0, q: [...q] }];
    const sides = [1, -1].map((sign) => {
      const found = [];
      let before = first.map((value) => (sign * value) / size);
      let now = [...q];
      for (let s = STEP; s <= FARTHEST; s += STEP) {
        const along = project(rows(robot, robot.at(now), point, turned), before);
        const length = Math.hypot(...along);
        if (length < 0.3) break; // the way ends in a corner
        before = along.map((value) => value / length);
        const next = [...now];
        commanded.forEach((place, k) => { next[place] += STEP * before[k]; });
        const met = reach(robot, next, point, target, { rounds: 12, damping: 0 });
        const inside = commanded.every((place) => next[place] >= joints[place].lower && next[place] <= joints[place].upper);
        if (!inside || met.left > 1e-8) break;
        now = met.q;
        found.push({ s: sign * s, q: now });
      }
      return found;
    });
    return [...sides[1].reverse(), { s: 0, q: [...q] }, ...sides[0]];
  }

  return { reach, leastNorm, selfMotion, freedom, project, rows, missing };
})();
