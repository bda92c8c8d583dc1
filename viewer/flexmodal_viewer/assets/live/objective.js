"use strict";
// What a search judged postures by, computed as flexmodal's objectives do: receptance over some directions and
// frequencies, stiffness [Hearne 3.17], mobility [3.18], or the distance from the poles.
const Objective = (() => {
  // Largest singular value of a complex matrix a[i][j] = [re, im]: root of the largest eigenvalue of AᴴA, which is
  // that of the real symmetric matrix [[X, −Y], [Y, X]] for AᴴA = X + iY.
  function largest(a) {
    const n = a.length;
    const twice = new Float64Array(4 * n * n);
    for (let i = 0; i < n; i++) {
      for (let j = 0; j < n; j++) {
        let [x, y] = [0, 0];
        for (let k = 0; k < n; k++) {
          x += a[k][i][0] * a[k][j][0] + a[k][i][1] * a[k][j][1];
          y += a[k][i][0] * a[k][j][1] - a[k][i][1] * a[k][j][0];
        }
        twice[i * 2 * n + j] = twice[(i + n) * 2 * n + j + n] = x;
        twice[i * 2 * n + j + n] = -y;
        twice[(i + n) * 2 * n + j] = y;
      }
    }
    return Math.sqrt(Math.max(...Symmetric.eigen(twice, 2 * n).values, 0));
  }

  // ξ_K = uᵀ J⁺ᵀ K J⁺ u; the rows of the task and u in them come from Python.
  function stiffness(told, posed) {
    const six = posed.flexible(told.point);
    const j = told.rows.map((row) => six[0].map((_, k) => row.reduce((sum, part, axis) => sum + part * six[axis][k], 0)));
    const u = Hold.leastNorm(j.map((row) => [...row]), told.along, 0);
    const { n, stiffness: k } = posed.system;
    return u.reduce((sum, x, i) => sum + x * u.reduce((inner, y, l) => inner + k[i * n + l] * y, 0), 0);
  }

  // Least distance of the poles from iω, or of those that vibrate from one another, over 2π [Hz].
  function separation(told, posed) {
    const poles = posed.modes().map(({ pole }) => pole);
    const omega = told.frequency === null ? null : 2 * Math.PI * told.frequency;
    const vibrating = poles.filter(([, im]) => im !== 0);
    const gaps = omega === null
      ? vibrating.flatMap((one, i) => vibrating.slice(i + 1).map((other) => Complex.size(Complex.minus(one, other))))
      : poles.map(([re, im]) => Math.hypot(re, im - omega));
    return Math.min(...gaps) / (2 * Math.PI);
  }

  function make(robot, told) {
    if (told.kind === "stiffness") return (posed) => stiffness(told, posed);
    if (told.kind === "mobility") return (posed) => posed.row(robot.direction(told.direction)).reduce((sum, part) => sum + part * part, 0);
    if (told.kind === "separation") return (posed) => separation(told, posed);
    return receptance(robot, told);
  }

  // told: { directions, frequencies, combine, weights, toward, over, shares } as Python has them.
  function receptance(robot, told) {
    const ways = told.directions.map(robot.direction);
    function size(posed, rows, hertz) {
      const columns = rows.map((row) => Pencil.deflection(posed.system, row, hertz));
      if (columns.some((column) => column === null)) return Infinity; // an undamped mode at its own frequency
      const alpha = rows.map((row) => columns.map((column) => Pencil.seen(row, column)));
      if (told.combine === "worst" && rows.length > 1) return largest(alpha);
      const motion = alpha.map((row) => [0, 1].map((part) => row.reduce((sum, entry, j) => sum + entry[part] * told.weights[j], 0)));
      if (told.combine === "force") return Math.hypot(...motion.flat());
      return Math.hypot(...[0, 1].map((part) => motion.reduce((sum, entry, i) => sum + entry[part] * told.toward[i], 0)));
    }
    return (posed) => {
      const rows = ways.map((way) => posed.row(way));
      const sizes = told.frequencies.map((hertz, line) => told.shares[line] * size(posed, rows, hertz));
      return told.over === "largest" ? Math.max(...sizes) : sizes.reduce((sum, one) => sum + one, 0) / sizes.length;
    };
  }

  return { make };
})();
