"use strict";
// The posture of least receptance that has the tool in a place: descents along what leaves it there.
const Descent = (() => {
  const ROUNDS = 60;
  const STEP = 1e-5; // of the differences along joints
  const WIDEST = 0.3; // a joint's change in one step [rad, m]
  const NEAR = 1e-8; // a posture holds its place when no more than this is missing [m]
  const SETTLED = 1e-5; // slope of ln|α| along the way, per radian, below which nothing is left to gain

  // Numbers from 0 to 1 that are always the same: Marsaglia's xorshift of 32 bits.
  function chance(seed) {
    let x = seed | 0 || 1;
    return () => {
      x ^= x << 13;
      x ^= x >>> 17;
      x ^= x << 5;
      return (x >>> 0) / 4294967296;
    };
  }

  // Joints anywhere in their ranges, one turn at most; what only gives way stays at 0.
  function anywhere(robot, next) {
    const { joints, commanded } = robot.numbers;
    const q = joints.map(() => 0);
    for (const place of commanded) {
      const { lower, upper, turns } = joints[place];
      const half = turns ? Math.min((upper - lower) / 2, Math.PI) : (upper - lower) / 2;
      const middle = Math.min(Math.max(0, lower + half), upper - half); // as near to 0 as that leaves the range whole
      q[place] = middle + (2 * next() - 1) * half;
    }
    return q;
  }

  const bring = (robot, q, point, position, without = []) => {
    const met = Hold.reach(robot, q, point, { position, turn: null }, { rounds: 30, damping: 1e-6, without });
    return met.left < NEAR ? met.q : null;
  };

  // Joints that move, and the direction downhill among them: a joint at its limit that would leave it stands still.
  function downhill(robot, q, point, slope) {
    const { joints, commanded } = robot.numbers;
    let free = commanded.map((_, k) => k);
    for (;;) {
      const places = free.map((k) => commanded[k]);
      if (!places.length) return { along: [], without: [...commanded] };
      const rows = Hold.rows(robot, robot.at(q), point, false, places);
      const part = Hold.project(rows, free.map((k) => -slope[k]));
      const stuck = free.filter((k, i) => {
        const { lower, upper } = joints[commanded[k]];
        return (q[commanded[k]] <= lower + 1e-12 && part[i] < 0) || (q[commanded[k]] >= upper - 1e-12 && part[i] > 0);
      });
      if (!stuck.length) {
        const along = commanded.map(() => 0);
        free.forEach((k, i) => { along[k] = part[i]; });
        return { along, without: commanded.filter((_, k) => !free.includes(k)) };
      }
      free = free.filter((k) => !stuck.includes(k));
    }
  }

  // From a posture that has the point in its place down to where ln(value) falls no more: { q, value }.
  // Steps along the gradient without what moves the point, as long as the last two points suggest
  // (Barzilai and Borwein, IMA J. Numer. Anal. 8, 1988), halved until the value falls.
  function descend(robot, start, point, value, rounds = ROUNDS) {
    const { commanded, joints } = robot.numbers;
    const cost = (q) => Math.log(Math.max(value(robot.at(q)), 1e-300));
    const position = robot.at(start).position(point);
    let q = start;
    let now = cost(q);
    let before = null;
    for (let round = 0; round < rounds; round++) {
      const slope = commanded.map((place) => {
        const [up, down] = [1, -1].map((sign) => { const moved = [...q]; moved[place] += sign * STEP; return cost(moved); });
        return (up - down) / (2 * STEP);
      });
      const { along, without } = downhill(robot, q, point, slope);
      const size = Math.hypot(...along);
      if (!(size > SETTLED)) break;
      let length = 0.1 / size;
      if (before) {
        const s = commanded.map((place, k) => q[place] - before.q[place]);
        const y = along.map((part, k) => before.along[k] - part);
        const bend = s.reduce((sum, part, k) => sum + part * y[k], 0);
        if (bend > 0) length = s.reduce((sum, part) => sum + part * part, 0) / bend;
      }
      length = Math.min(length, WIDEST / Math.max(...along.map(Math.abs)));
      let better = null;
      for (let half = 0; half < 25 && better === null; half++, length /= 2) {
        const next = [...q];
        commanded.forEach((place, k) => { next[place] = Math.min(Math.max(next[place] + length * along[k], joints[place].lower), joints[place].upper); });
        const met = bring(robot, next, point, position, without);
        const there = met === null ? Infinity : cost(met);
        if (there < now - 1e-4 * length * size * size) better = { q: met, cost: there };
      }
      if (better === null) break;
      before = { q, along };
      q = better.q;
      now = better.cost;
    }
    return { q, value: Math.exp(now) };
  }

  return { chance, anywhere, bring, descend };
})();
