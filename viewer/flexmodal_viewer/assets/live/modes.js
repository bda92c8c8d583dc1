"use strict";
// Modes of a damped system: (s²M + sC + K + K_h(s)) u = 0 with uᵀ T′(s) u = 1, in the order of |s|.
const Modes = (() => {
  const ROUNDS = 80;

  // Coordinates in which the mass matrix is one and the stiffness diagonal: x = Wᵀ y, the rows of W in `basis`.
  function modal(system) {
    const { n } = system;
    const lower = Symmetric.cholesky(system.mass, n);
    if (lower === null) return null;
    const inverse = Symmetric.inverse(lower, n);
    const { values, vectors } = Symmetric.eigen(Symmetric.congruent(inverse, system.stiffness, n), n);
    const basis = new Float64Array(n * n);
    vectors.forEach((vector, i) => {
      for (let j = 0; j < n; j++) for (let k = 0; k < n; k++) basis[i * n + j] += vector[k] * inverse[k * n + j];
    });
    const unit = Math.sqrt(Math.max(...values.map(Math.abs))) || 1;
    const damping = Symmetric.congruent(basis, system.damping, n).map((value) => value / unit);
    return { n, unit, basis, square: values.map((value) => Math.max(value, 0) / unit ** 2), damping };
  }

  // s² + s C + diag(square), and what is left of hysteresis in these coordinates.
  function pencil(reduced, s) {
    const { n, square, damping } = reduced;
    const found = Complex.matrix(n);
    const twice = Complex.times(s, s);
    for (let k = 0; k < n * n; k++) {
      found.re[k] = s[0] * damping[k];
      found.im[k] = s[1] * damping[k];
    }
    for (let i = 0; i < n; i++) {
      found.re[i * n + i] += twice[0] + square[i];
      found.im[i * n + i] += twice[1];
    }
    return found;
  }

  // Both roots of s² + c s + ω² = 0, the small real one without cancellation.
  function oscillator(square, c) {
    const root = Complex.root([(c * c) / 4 - square, 0]);
    const first = [-c / 2 - root[0], -root[1]];
    const real = c * c >= 4 * square && first[0] !== 0;
    return [first, real ? [square / first[0], 0] : [-c / 2 + root[0], root[1]]];
  }

  // All 2n roots of det T at once: Newton's step on the determinant, the other roots divided out
  // (Ehrlich and Aberth, as in Bini and Noferini, Linear Algebra Appl. 439, 2013).
  function poles(reduced) {
    const { n, square, damping } = reduced;
    const found = square.flatMap((value, i) => oscillator(value, damping[i * n + i]));
    found.forEach((s, k) => { // apart from one another and off the axis, so that nothing is stuck there
      const nudge = 1e-4 * (Complex.size(s) || 1e-3) * (1 + k / 7);
      s[0] += nudge;
      s[1] += s[1] < 0 || (s[1] === 0 && k % 2) ? -nudge : nudge;
    });
    const done = found.map(() => false);
    for (let round = 0; round < ROUNDS && !done.every(Boolean); round++) {
      for (let k = 0; k < found.length; k++) {
        if (done[k]) continue;
        const t = pencil(reduced, found[k]);
        const order = Complex.factor(t);
        if (order === null) { done[k] = true; continue; }
        let sum = [0, 0]; // trace of T⁻¹T′
        for (let j = 0; j < n; j++) {
          const column = { re: new Float64Array(n), im: new Float64Array(n) };
          for (let i = 0; i < n; i++) column.re[i] = damping[i * n + j] + (i === j ? 2 * found[k][0] : 0);
          column.im[j] = 2 * found[k][1];
          const x = Complex.solve(t, order, column);
          sum = [sum[0] + x.re[j], sum[1] + x.im[j]];
        }
        for (let j = 0; j < found.length; j++) {
          if (j !== k) sum = Complex.minus(sum, Complex.over([1, 0], Complex.minus(found[k], found[j])));
        }
        const step = Complex.over([1, 0], sum);
        found[k] = Complex.minus(found[k], step);
        done[k] = Complex.size(step) <= 1e-14 * Complex.size(found[k]);
      }
    }
    return found;
  }

  const quadratic = (a, u) => { // uᵀ A u
    let re = 0;
    let im = 0;
    for (let i = 0; i < a.n; i++) {
      for (let j = 0; j < a.n; j++) {
        const k = i * a.n + j;
        const xr = u.re[i] * u.re[j] - u.im[i] * u.im[j];
        const xi = u.re[i] * u.im[j] + u.im[i] * u.re[j];
        re += a.re[k] * xr - a.im[k] * xi;
        im += a.re[k] * xi + a.im[k] * xr;
      }
    }
    return [re, im];
  };

  function unit(u) {
    const size = Math.hypot(...u.re, ...u.im);
    return { re: u.re.map((value) => value / size), im: u.im.map((value) => value / size) };
  }

  // A shape by inverse iteration and its pole by the quotient uᵀTu / uᵀT′u, in turns.
  function settle(value, derivative, s, start) {
    let u = start;
    for (let round = 0; round < ROUNDS; round++) {
      const t = value(s);
      const least = 1e-16 * Math.max(...t.re.map(Math.abs), ...t.im.map(Math.abs));
      const order = Complex.factor(t, least);
      for (let turn = 0; turn < 2; turn++) u = unit(Complex.solve(t, order, u));
      const step = Complex.over(quadratic(value(s), u), quadratic(derivative(s), u));
      s = Complex.minus(s, step);
      if (Complex.size(step) <= 1e-14 * Complex.size(s) || Complex.size(s) === 0) break;
    }
    return { s, u };
  }

  // Scaled to uᵀ T′ u = 1; the largest component towards −30°, as in flexmodal.modal.
  function scaled(derivative, { s, u }) {
    const size = Complex.root(quadratic(derivative(s), u));
    const parts = Array.from(u.re, (re, i) => Complex.over([re, u.im[i]], size));
    const sizes = parts.map(Complex.size);
    const largest = sizes.findIndex((value) => value >= (1 - 1e-6) * Math.max(...sizes));
    const towards = parts[largest][0] * Math.cos(Math.PI / 6) - parts[largest][1] * Math.sin(Math.PI / 6);
    const sign = towards < 0 ? -1 : 1;
    return { pole: s, shape: { re: parts.map((p) => sign * p[0]), im: parts.map((p) => sign * p[1]) } };
  }

  function back(reduced, u) { // from these coordinates to the joints
    const { n, basis } = reduced;
    const found = { re: new Float64Array(n), im: new Float64Array(n) };
    for (let i = 0; i < n; i++) {
      for (let j = 0; j < n; j++) {
        found.re[j] += basis[i * n + j] * u.re[i];
        found.im[j] += basis[i * n + j] * u.im[i];
      }
    }
    return found;
  }

  // Poles with their shapes in the reduced coordinates, viscous damping alone.
  function viscous(reduced) {
    const { n, square, damping } = reduced;
    const largest = Math.max(...damping.map(Math.abs));
    let spill = 0;
    for (let i = 0; i < n; i++) for (let j = 0; j < n; j++) if (i !== j) spill = Math.max(spill, Math.abs(damping[i * n + j]));
    const one = (i) => ({ re: Float64Array.from({ length: n }, (_, k) => Number(k === i)), im: new Float64Array(n) });
    if (spill <= 1e-12 * largest) {
      return square.flatMap((value, i) => oscillator(value, damping[i * n + i]).map((s) => ({ s, u: one(i) })));
    }
    const slope = (s) => {
      const found = Complex.matrix(n);
      for (let k = 0; k < n * n; k++) found.re[k] = damping[k];
      for (let i = 0; i < n; i++) { found.re[i * n + i] += 2 * s[0]; found.im[i * n + i] += 2 * s[1]; }
      return found;
    };
    const start = { re: Float64Array.from({ length: n }, (_, k) => 1 + 0.1 * Math.sin(k + 1)), im: new Float64Array(n) };
    return poles(reduced).map((s) => settle((x) => pencil(reduced, x), slope, s, start));
  }

  // The modes of a system; null where its mass matrix is not positive definite.
  function solve(system) {
    const reduced = modal(system);
    if (reduced === null) return null;
    const value = (s) => Pencil.at(system, s);
    const derivative = (s) => Pencil.slope(system, s);
    return viscous(reduced)
      .map(({ s, u }) => ({ s: Math.abs(s[1]) <= 1e-9 * Complex.size(s) ? [s[0], 0] : s, u }))
      .filter(({ s }) => s[1] >= 0)
      .map(({ s, u }) => ({ s: [s[0] * reduced.unit, s[1] * reduced.unit], u: unit(back(reduced, u)) }))
      .map((mode) => (system.hysteresis ? settle(value, derivative, mode.s, mode.u) : mode))
      .map((mode) => scaled(derivative, mode))
      .sort((a, b) => Complex.size(a.pole) - Complex.size(b.pole) || a.pole[0] - b.pole[0]);
  }

  const frequency = (mode) => Complex.size(mode.pole) / (2 * Math.PI);
  const ratio = (mode) => (Complex.size(mode.pole) > 0 ? -mode.pole[0] / Complex.size(mode.pole) : 0);

  return { solve, frequency, ratio };
})();
