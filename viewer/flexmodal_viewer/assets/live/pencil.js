"use strict";
// The dynamic stiffness T(s) = s²M + sC + K + K_h(s) of a system { n, mass, damping, stiffness, hysteresis }.
const Pencil = (() => {
  const HELD = 1e-3; // part of ω₀ below which hysteretic springs no longer change

  // What hysteretic springs add to the diagonal at s, and its derivative along s.
  function added(hysteresis, s) {
    const { stiffness, loss, frequency } = hysteresis;
    return stiffness.map((k, i) => {
      if (frequency === null) return { value: [0, k * loss[i]], slope: [0, 0] };
      const omega = 2 * Math.PI * frequency;
      const beta = (2 / Math.PI) * Math.atan(loss[i]);
      const size = Complex.size(s);
      const held = size <= HELD * omega;
      const phase = size === 0 ? Math.PI / 2 : Math.atan2(s[1], s[0]);
      const scale = Math.pow(Math.max(size, HELD * omega) / omega, beta) / Math.cos((beta * Math.PI) / 2);
      const power = [scale * Math.cos(beta * phase), scale * Math.sin(beta * phase)];
      const slope = held ? [0, 0] : Complex.over([k * beta * power[0], k * beta * power[1]], s);
      return { value: [k * (power[0] - 1), k * power[1]], slope };
    });
  }

  function at(system, s) {
    const { n, mass, damping, stiffness, hysteresis } = system;
    const found = Complex.matrix(n);
    const square = Complex.times(s, s);
    for (let k = 0; k < n * n; k++) {
      found.re[k] = stiffness[k] + square[0] * mass[k] + s[0] * damping[k];
      found.im[k] = square[1] * mass[k] + s[1] * damping[k];
    }
    if (hysteresis) {
      added(hysteresis, s).forEach(({ value }, i) => {
        found.re[i * n + i] += value[0];
        found.im[i * n + i] += value[1];
      });
    }
    return found;
  }

  // dT/ds = 2sM + C + dK_h/ds.
  function slope(system, s) {
    const { n, mass, damping, hysteresis } = system;
    const found = Complex.matrix(n);
    for (let k = 0; k < n * n; k++) {
      found.re[k] = 2 * s[0] * mass[k] + damping[k];
      found.im[k] = 2 * s[1] * mass[k];
    }
    if (hysteresis) {
      added(hysteresis, s).forEach((one, i) => {
        found.re[i * n + i] += one.slope[0];
        found.im[i * n + i] += one.slope[1];
      });
    }
    return found;
  }

  // Joint amplitudes per unit force along a row of a Jacobian, at a frequency [Hz]; null at an undamped pole.
  function deflection(system, row, frequency) {
    const z = at(system, [0, 2 * Math.PI * frequency]);
    const order = Complex.factor(z);
    return order === null ? null : Complex.solve(z, order, { re: row });
  }

  const seen = (row, x) => {
    let re = 0;
    let im = 0;
    for (let i = 0; i < row.length; i++) { re += row[i] * x.re[i]; im += row[i] * x.im[i]; }
    return [re, im];
  };

  // Receptance between two rows over frequencies [Hz], as { re, im }; not a number at an undamped pole.
  function receptance(system, response, reference, frequencies) {
    const re = new Float64Array(frequencies.length);
    const im = new Float64Array(frequencies.length);
    frequencies.forEach((frequency, line) => {
      const x = deflection(system, reference, frequency);
      [re[line], im[line]] = x === null ? [NaN, NaN] : seen(response, x);
    });
    return { re, im };
  }

  return { at, slope, added, deflection, receptance, seen };
})();
