"use strict";
// Complex matrices as two flat arrays, row by row: { n, re, im }. A complex number is a pair [re, im].
const Complex = (() => {
  const times = (a, b) => [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]];
  const over = (a, b) => {
    const size = b[0] * b[0] + b[1] * b[1];
    return [(a[0] * b[0] + a[1] * b[1]) / size, (a[1] * b[0] - a[0] * b[1]) / size];
  };
  const minus = (a, b) => [a[0] - b[0], a[1] - b[1]];
  const size = (a) => Math.hypot(a[0], a[1]);
  function root(a) {
    const half = Math.sqrt((size(a) + Math.abs(a[0])) / 2);
    if (half === 0) return [0, 0];
    const other = a[1] / (2 * half);
    return a[0] >= 0 ? [half, other] : [Math.abs(other), a[1] < 0 ? -half : half];
  }

  const matrix = (n) => ({ n, re: new Float64Array(n * n), im: new Float64Array(n * n) });

  // LU factors with partial pivoting, in place. A pivot smaller than `least` is replaced by it, for inverse
  // iteration; without it a singular matrix gives null instead of the order of the rows.
  function factor(a, least = 0) {
    const { n, re, im } = a;
    const order = new Int32Array(n);
    for (let k = 0; k < n; k++) order[k] = k;
    for (let k = 0; k < n; k++) {
      let best = k;
      let largest = -1;
      for (let i = k; i < n; i++) {
        const found = re[i * n + k] * re[i * n + k] + im[i * n + k] * im[i * n + k];
        if (found > largest) { largest = found; best = i; }
      }
      if (best !== k) {
        [order[k], order[best]] = [order[best], order[k]];
        for (let j = 0; j < n; j++) {
          [re[k * n + j], re[best * n + j]] = [re[best * n + j], re[k * n + j]];
          [im[k * n + j], im[best * n + j]] = [im[best * n + j], im[k * n + j]];
        }
      }
      if (!(largest > least * least)) {
        if (least === 0) return null;
        re[k * n + k] = least;
        im[k * n + k] = 0;
        largest = least * least;
      }
      const pr = re[k * n + k] / largest;
      const pi = -im[k * n + k] / largest;
      for (let i = k + 1; i < n; i++) {
        const xr = re[i * n + k];
        const xi = im[i * n + k];
        const fr = xr * pr - xi * pi;
        const fi = xr * pi + xi * pr;
        re[i * n + k] = fr;
        im[i * n + k] = fi;
        for (let j = k + 1; j < n; j++) {
          re[i * n + j] -= fr * re[k * n + j] - fi * im[k * n + j];
          im[i * n + j] -= fr * im[k * n + j] + fi * re[k * n + j];
        }
      }
    }
    return order;
  }

  // x with A x = b from the factors; b is { re, im } and stays as it is.
  function solve(a, order, b) {
    const { n, re, im } = a;
    const x = { re: new Float64Array(n), im: new Float64Array(n) };
    for (let i = 0; i < n; i++) {
      let sr = b.re[order[i]];
      let si = b.im === undefined ? 0 : b.im[order[i]];
      for (let j = 0; j < i; j++) {
        sr -= re[i * n + j] * x.re[j] - im[i * n + j] * x.im[j];
        si -= re[i * n + j] * x.im[j] + im[i * n + j] * x.re[j];
      }
      x.re[i] = sr;
      x.im[i] = si;
    }
    for (let i = n - 1; i >= 0; i--) {
      let sr = x.re[i];
      let si = x.im[i];
      for (let j = i + 1; j < n; j++) {
        sr -= re[i * n + j] * x.re[j] - im[i * n + j] * x.im[j];
        si -= re[i * n + j] * x.im[j] + im[i * n + j] * x.re[j];
      }
      [x.re[i], x.im[i]] = over([sr, si], [re[i * n + i], im[i * n + i]]);
    }
    return x;
  }

  return { times, over, minus, size, root, matrix, factor, solve };
})();
