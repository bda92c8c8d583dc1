"use strict";
// Real symmetric matrices as flat arrays, row by row.
const Symmetric = (() => {
  // L with A = L Lᵀ; null where A is not positive definite.
  function cholesky(a, n) {
    const l = new Float64Array(n * n);
    for (let i = 0; i < n; i++) {
      for (let j = 0; j <= i; j++) {
        let sum = a[i * n + j];
        for (let k = 0; k < j; k++) sum -= l[i * n + k] * l[j * n + k];
        if (i !== j) l[i * n + j] = sum / l[j * n + j];
        else if (sum > 0) l[i * n + i] = Math.sqrt(sum);
        else return null;
      }
    }
    return l;
  }

  // The inverse of a lower triangle.
  function inverse(l, n) {
    const x = new Float64Array(n * n);
    for (let j = 0; j < n; j++) {
      for (let i = j; i < n; i++) {
        let sum = i === j ? 1 : 0;
        for (let k = j; k < i; k++) sum -= l[i * n + k] * x[k * n + j];
        x[i * n + j] = sum / l[i * n + i];
      }
    }
    return x;
  }

  // W A Wᵀ for a square W.
  function congruent(w, a, n) {
    const half = new Float64Array(n * n);
    const full = new Float64Array(n * n);
    for (let i = 0; i < n; i++) {
      for (let j = 0; j < n; j++) {
        for (let k = 0; k < n; k++) half[i * n + j] += w[i * n + k] * a[k * n + j];
      }
    }
    for (let i = 0; i < n; i++) {
      for (let j = 0; j < n; j++) {
        for (let k = 0; k < n; k++) full[i * n + j] += half[i * n + k] * w[j * n + k];
      }
    }
    return full;
  }

  // Eigenvalues, ascending, and eigenvectors as rows, by Jacobi's rotations (Golub and Van Loan, 8.5).
  function eigen(given, n) {
    const a = Float64Array.from(given);
    const v = new Float64Array(n * n);
    for (let i = 0; i < n; i++) v[i * n + i] = 1;
    for (let sweep = 0; sweep < 60; sweep++) {
      let turned = false;
      for (let p = 0; p < n - 1; p++) {
        for (let q = p + 1; q < n; q++) {
          const off = a[p * n + q];
          if (off === 0 || Math.abs(off) <= 1e-17 * Math.sqrt(Math.abs(a[p * n + p] * a[q * n + q]))) continue;
          turned = true;
          const theta = (a[q * n + q] - a[p * n + p]) / (2 * off);
          const t = (theta >= 0 ? 1 : -1) / (Math.abs(theta) + Math.hypot(theta, 1));
          const c = 1 / Math.hypot(t, 1);
          const s = t * c;
          for (let k = 0; k < n; k++) {
            const x = a[k * n + p];
            const y = a[k * n + q];
            a[k * n + p] = c * x - s * y;
            a[k * n + q] = s * x + c * y;
          }
          for (let k = 0; k < n; k++) {
            const x = a[p * n + k];
            const y = a[q * n + k];
            a[p * n + k] = c * x - s * y;
            a[q * n + k] = s * x + c * y;
            const d = v[p * n + k];
            const e = v[q * n + k];
            v[p * n + k] = c * d - s * e;
            v[q * n + k] = s * d + c * e;
          }
          a[p * n + q] = 0;
          a[q * n + p] = 0;
        }
      }
      if (!turned) break;
    }
    const order = [...Array(n).keys()].sort((i, j) => a[i * n + i] - a[j * n + j]);
    return {
      values: order.map((i) => a[i * n + i]),
      vectors: order.map((i) => v.slice(i * n, (i + 1) * n)),
    };
  }

  return { cholesky, inverse, congruent, eigen };
})();
