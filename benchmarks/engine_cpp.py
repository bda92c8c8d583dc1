"""A C++ reference compiled on the spot: the same elimination, and the core's fused-multiply-add peak."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np

SOURCE = r"""
#include <chrono>
#include <cmath>

constexpr int N = 6, W = 32;

// LDLᵀ without pivoting for W frequencies at a time; K and B diagonal, M packed by rows, one row j.
extern "C" void receptance(const double* mass, const double* k, const double* b, const double* j,
                           const double* omega, int lines, double* out) {
  for (int start = 0; start < lines; start += W) {
    double re[N][N + 1][W], im[N][N + 1][W], sum_re[W] = {}, sum_im[W] = {};
    const double* w = omega + start;
    int e = 0;
    for (int r = 0; r < N; ++r) {
      for (int c = r; c < N; ++c, ++e)
        for (int p = 0; p < W; ++p) {
          re[r][c][p] = (r == c ? k[r] : 0.0) - w[p] * w[p] * mass[e];
          im[r][c][p] = r == c ? w[p] * b[r] : 0.0;
        }
      for (int p = 0; p < W; ++p) re[r][N][p] = j[r], im[r][N][p] = 0.0;
    }
#pragma GCC unroll 6
    for (int m = 0; m < N; ++m) {
      double ir[W], ii[W];
      for (int p = 0; p < W; ++p) {
        double s = 1.0 / (re[m][m][p] * re[m][m][p] + im[m][m][p] * im[m][m][p]);
        ir[p] = re[m][m][p] * s, ii[p] = -im[m][m][p] * s;
        double x = re[m][N][p], y = im[m][N][p], tr = x * ir[p] - y * ii[p], ti = x * ii[p] + y * ir[p];
        sum_re[p] += tr * x - ti * y, sum_im[p] += tr * y + ti * x;
      }
      for (int r = m + 1; r < N; ++r) {
        double fr[W], fi[W];
        for (int p = 0; p < W; ++p) {
          fr[p] = re[m][r][p] * ir[p] - im[m][r][p] * ii[p];
          fi[p] = re[m][r][p] * ii[p] + im[m][r][p] * ir[p];
        }
        for (int c = r; c <= N; ++c)
          for (int p = 0; p < W; ++p) {
            re[r][c][p] -= fr[p] * re[m][c][p] - fi[p] * im[m][c][p];
            im[r][c][p] -= fr[p] * im[m][c][p] + fi[p] * re[m][c][p];
          }
      }
    }
    for (int p = 0; p < W && start + p < lines; ++p)
      out[2 * (start + p)] = sum_re[p], out[2 * (start + p) + 1] = sum_im[p];
  }
}

template <class V> static double peak_of(long rounds) {
  V a[12], x, y;
  constexpr int lanes = sizeof(V) / 8;
  for (int i = 0; i < 12; ++i) for (int l = 0; l < lanes; ++l) a[i][l] = i + l;
  for (int l = 0; l < lanes; ++l) x[l] = 0.999, y[l] = 1e-3;
  auto start = std::chrono::steady_clock::now();
  for (long r = 0; r < rounds; ++r) {
    for (int i = 0; i < 12; ++i) a[i] = a[i] * x + y;
    asm volatile("" : "+x"(a[0]));
  }
  double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), sum = 0;
  for (int i = 0; i < 12; ++i) for (int l = 0; l < lanes; ++l) sum += a[i][l];
  return std::isfinite(sum) ? rounds * 12.0 * lanes * 2 / seconds : 0;
}
typedef double v4 __attribute__((vector_size(32)));
typedef double v8 __attribute__((vector_size(64)));
extern "C" double peak(int wide, long rounds) { return wide ? peak_of<v8>(rounds) : peak_of<v4>(rounds); }
"""


class Reference:
    """The compiled library."""

    def __init__(self) -> None:
        compiler = shutil.which("g++") or shutil.which("clang++")
        if compiler is None:
            raise FileNotFoundError("no C++ compiler")
        folder = Path(tempfile.mkdtemp(prefix="engine_cpp_"))
        (folder / "reference.cpp").write_text(SOURCE, encoding="utf-8")
        subprocess.run(
            [
                compiler, "-O3", "-march=native", "-shared", "-fPIC", "-std=c++17",
                str(folder / "reference.cpp"), "-o", str(folder / "reference.so"),
            ],
            check=True,
            capture_output=True,
        )  # fmt: skip
        self._library = ctypes.CDLL(str(folder / "reference.so"))
        self._library.peak.restype = ctypes.c_double

    def peak(self, *, wide: bool, rounds: int = 300_000) -> float:
        """Fused multiply-adds as floating-point operations a second, on 256- or 512-bit vectors."""
        return float(self._library.peak(int(wide), ctypes.c_long(rounds)))

    def receptance(
        self, mass: np.ndarray, k: np.ndarray, b: np.ndarray, row: np.ndarray, omega: np.ndarray
    ) -> np.ndarray:
        """Drive-point receptance of one system of six coordinates; `omega` a multiple of 32 long."""
        out = np.empty(len(omega), dtype=complex)
        doubles = [np.ascontiguousarray(part, dtype=float) for part in (mass, k, b, row, omega)]
        pointers = [part.ctypes.data_as(ctypes.c_void_p) for part in doubles]
        self._library.receptance(*pointers, len(omega), out.ctypes.data_as(ctypes.c_void_p))
        return out
