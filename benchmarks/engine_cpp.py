"""A C++ reference compiled on the spot: the same elimination, and the core's fused-multiply-add peak."""

from __future__ import annotations

import ctypes
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from flexmodal.frf.kernels.factor import Shape, write_kernel

SOURCE = r"""
#include <cmath>
#include <ctime>

// Processor time of this thread: the machine may be shared.
static double now() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return t.tv_sec + 1e-9 * t.tv_nsec;
}

constexpr int N = 6, W = 32, ENTRIES = 1 + N * (N + 1) / 2 + 3 * N;

// The generated elimination of one tile, line by line as numba gets it.
static void kernel(const double* __restrict tile, const double* __restrict rows, double* __restrict out) {
  for (int p = 0; p < W; ++p) {
BODY
  }
}

extern "C" void receptance(const double* mass, const double* k, const double* b, const double* j,
                           const double* omega, int lines, double* out) {
  double tile[ENTRIES * W] = {}, rows[N * W], result[3 * W];
  for (int p = 0; p < W; ++p) {
    for (int e = 0; e < N * (N + 1) / 2; ++e) tile[(1 + e) * W + p] = mass[e];
    for (int i = 0; i < N; ++i) {
      tile[(1 + N * (N + 1) / 2 + i) * W + p] = k[i];
      tile[(1 + N * (N + 1) / 2 + N + i) * W + p] = b[i];
      rows[i * W + p] = j[i];
    }
  }
  for (int start = 0; start < lines; start += W) {
    for (int p = 0; p < W; ++p) tile[p] = omega[start + p];
    kernel(tile, rows, result);
    for (int p = 0; p < W; ++p) out[2 * (start + p)] = result[p], out[2 * (start + p) + 1] = result[W + p];
  }
}

template <class V> static double peak_of(long rounds) {
  V a[12], x, y;
  constexpr int lanes = sizeof(V) / 8;
  for (int i = 0; i < 12; ++i) for (int l = 0; l < lanes; ++l) a[i][l] = i + l;
  for (int l = 0; l < lanes; ++l) x[l] = 0.999, y[l] = 1e-3;
  double start = now();
  for (long r = 0; r < rounds; ++r) {
#pragma GCC unroll 12
    for (int i = 0; i < 12; ++i) a[i] = a[i] * x + y;  // twelve chains: enough to fill two units of latency 4
  }
  double seconds = now() - start, sum = 0;
  for (int i = 0; i < 12; ++i) for (int l = 0; l < lanes; ++l) sum += a[i][l];
  return std::isfinite(sum) ? rounds * 12.0 * lanes * 2 / seconds : 0;
}
typedef double v4 __attribute__((vector_size(32)));
typedef double v8 __attribute__((vector_size(64)));
extern "C" double peak(int wide, long rounds) { return wide ? peak_of<v8>(rounds) : peak_of<v4>(rounds); }
"""


def _body() -> str:
    """The lines of the kernel's loop, as C++."""
    source, _ = write_kernel(Shape(6, ((0, 0),), diagonal=True))
    lines = [line.strip() for line in source.splitlines()[2:]]
    lines = [re.sub(r"= (\S+) if (\S+) < (\S+) else (\S+)$", r"= \2 < \3 ? \1 : \4", line) for line in lines]
    return "\n".join(f"    {line if line.startswith('out') else f'double {line}'};" for line in lines)


class Reference:
    """The compiled library."""

    def __init__(self) -> None:
        compiler = shutil.which("g++") or shutil.which("clang++")
        if compiler is None:
            raise FileNotFoundError("no C++ compiler")
        folder = Path(tempfile.mkdtemp(prefix="engine_cpp_"))
        (folder / "reference.cpp").write_text(SOURCE.replace("BODY", _body()), encoding="utf-8")
        subprocess.run(
            [
                compiler, "-O3", "-march=native", "-fno-trapping-math", "-shared", "-fPIC", "-std=c++17",
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
