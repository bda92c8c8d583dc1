"use strict";
// A robot from the numbers in the page, put in postures; what flexmodal's PosedRobot is in Python.
const Robot = (() => {
  const AXES = ["x", "y", "z", "rx", "ry", "rz"];

  function make(numbers) {
    const { joints, points } = numbers;
    const flexible = numbers.flexible; // places of the flexible joints among the moving ones
    const system = {
      n: flexible.length,
      damping: Float64Array.from(numbers.damping),
      stiffness: Float64Array.from(numbers.stiffness),
      hysteresis: numbers.hysteresis,
    };
    const fixed = flexible.every((place, i) => place === i) && flexible.length === joints.length;
    const pick = (values) => (fixed ? values : Float64Array.from(flexible, (place) => values[place]));

    // Such as "tool:+z"; a point's own name may hold colons.
    function direction(text) {
      const cut = text.lastIndexOf(":");
      const match = /^([+-]?)(r?[xyz])$/.exec(text.slice(cut + 1));
      const point = text.slice(0, cut);
      if (cut < 1 || match === null || !Object.hasOwn(points, point)) return null;
      return { point, row: AXES.indexOf(match[2]), sign: match[1] === "-" ? -1 : 1 };
    }

    function at(q) {
      const placed = Chain.frames(joints, q);
      const n = joints.length;
      const whole = Chain.mass(joints, placed);
      const mass = new Float64Array(system.n * system.n);
      flexible.forEach((row, i) => flexible.forEach((column, j) => { mass[i * system.n + j] = whole[row * n + column]; }));
      const own = { ...system, mass };
      const jacobian = (point) => Chain.jacobian(placed, points[point]);
      // The unit vector in the world that a direction stands for: a point may have axes of its own.
      function along({ point, row: axis, sign }) {
        const { axes, joint } = points[point];
        const own = axes ? axes.rows[axis % 3] : [0, 1, 2].map((k) => Number(k === axis % 3));
        return Chain.times(sign, axes && axes.turning && joint >= 0 ? Chain.turn(placed[joint].r, own) : own);
      }
      function row(way) {
        const whole = jacobian(way.point);
        const first = way.row < 3 ? 0 : 3;
        return pick(along(way).reduce((sum, part, k) => (part === 0 ? sum : sum.map((value, j) => value + part * whole[first + k][j])), new Float64Array(joints.length)));
      }
      return {
        q,
        placed,
        system: own,
        jacobian,
        flexible: (point) => jacobian(point).map(pick),
        row,
        along,
        position: (point) => Chain.position(placed, points[point]),
        turned: (point) => (points[point].joint < 0 ? points[point].turn : Chain.product(placed[points[point].joint].r, points[point].turn)),
        frf: (frequencies, response, reference) => Pencil.receptance(own, row(response), row(reference), frequencies),
        deflection: (reference, frequency) => Pencil.deflection(own, row(reference), frequency),
        modes: () => Modes.solve(own),
        shares: (u) => shares(own, u),
        ellipsoid: (point, frequency) => ellipsoid(own, jacobian(point).slice(0, 3).map(pick), frequency),
      };
    }
    return { numbers, direction, at };
  }

  // Part of the elastic energy uᴴKu in each joint; half of a coupling goes to either of its joints.
  function shares(system, u) {
    const { n, stiffness } = system;
    const found = Array.from({ length: n }, (_, i) => {
      let sum = 0;
      for (let j = 0; j < n; j++) sum += stiffness[i * n + j] * (u.re[i] * u.re[j] + u.im[i] * u.im[j]);
      return sum;
    });
    const total = found.reduce((a, b) => a + b, 0);
    return found.map((value) => (total > 0 ? value / total : 0));
  }

  // Directions of unit forces and how far the point goes under them: ‖αf‖² = fᵀ Re(αᴴα) f, α three by three.
  // The half axes are the roots of that matrix's eigenvalues [m/N], longest last; at 0 Hz those of the compliance.
  function ellipsoid(system, rows, frequency) {
    const columns = rows.map((row) => Pencil.deflection(system, row, frequency));
    if (columns.some((column) => column === null)) return null;
    const alpha = columns.map((column) => rows.map((row) => Pencil.seen(row, column))); // alpha[force][response]
    const gram = new Float64Array(9);
    for (let i = 0; i < 3; i++) {
      for (let j = 0; j < 3; j++) {
        for (let k = 0; k < 3; k++) gram[3 * i + j] += alpha[i][k][0] * alpha[j][k][0] + alpha[i][k][1] * alpha[j][k][1];
      }
    }
    const { values, vectors } = Symmetric.eigen(gram, 3);
    return { lengths: values.map((value) => Math.sqrt(Math.max(value, 0))), axes: vectors.map((v) => [...v]) };
  }

  return { make };
})();
