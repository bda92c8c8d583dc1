"use strict";
// From complex amplitudes of the flexible joints to a motion that can be seen; as flexmodal_viewer/motion.py.
const Swing = (() => {
  const SHARE = 0.1; // how far the tool goes, as a part of the reach
  const WIDEST = 0.35; // how far a joint turns at most [rad]
  const CYCLE = 1.6; // [s]

  // Turned in phase so that a mode is as real as it can be, its largest entry at 1.
  function straight(shape) {
    let [re, im] = [0, 0];
    shape.re.forEach((x, i) => { re += x * x - shape.im[i] ** 2; im += 2 * x * shape.im[i]; });
    const angle = -Math.atan2(im, re) / 2;
    const turned = { re: [], im: [] };
    shape.re.forEach((x, i) => {
      turned.re.push(x * Math.cos(angle) - shape.im[i] * Math.sin(angle));
      turned.im.push(x * Math.sin(angle) + shape.im[i] * Math.cos(angle));
    });
    const sizes = turned.re.map((x, i) => Math.hypot(x, turned.im[i]));
    const most = sizes.indexOf(Math.max(...sizes));
    const largest = [turned.re[most], turned.im[most]];
    const parts = turned.re.map((x, i) => Complex.over([x, turned.im[i]], largest));
    return { re: parts.map((p) => p[0]), im: parts.map((p) => p[1]) };
  }

  // How far the tool goes at the phase where it is farthest out [m], and that phase.
  function farthest(rows, shape) {
    const moved = rows.map((row) => Pencil.seen(row, shape));
    let [re, im] = [0, 0];
    for (const [a, b] of moved) { re += a * a - b * b; im += 2 * a * b; }
    const phase = -Math.atan2(im, re) / 2;
    return { phase, length: Math.hypot(...moved.map(([a, b]) => a * Math.cos(phase) - b * Math.sin(phase))) };
  }

  // Factor that brings the tool to its share of the reach, or the widest joint to its bound.
  function scale(robot, rows, shape, reach) {
    const { length } = farthest(rows, shape);
    const bounds = length > 0 ? [(SHARE * reach) / length] : [];
    robot.numbers.flexible.forEach((place, i) => {
      const size = Math.hypot(shape.re[i], shape.im[i]);
      if (size > 0) bounds.push((WIDEST * (robot.numbers.joints[place].turns ? 1 : reach)) / size);
    });
    return bounds.length ? Math.min(...bounds) : 1;
  }

  // All joints at a phase: posture plus the scaled deflection.
  function joints(robot, q, shape, factor, phase) {
    const found = [...q];
    robot.numbers.flexible.forEach((place, i) => {
      found[place] += factor * (shape.re[i] * Math.cos(phase) - shape.im[i] * Math.sin(phase));
    });
    return found;
  }

  return { straight, farthest, scale, joints, CYCLE };
})();
