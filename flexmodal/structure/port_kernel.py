"""Loops over systems and lines for structures with ports, compiled by `port_solution`; formulas in `ports`.

Plain functions of numbers and arrays. The matrices are as small as there are motions of ports.
"""

from __future__ import annotations

from typing import no_type_check

import numpy as np


@no_type_check  # a checker's wrapper cannot be compiled
def eliminate(matrix, right):
    """Solve in place by elimination with pivoting; whether there was a pivot in every column.

    That of `frf.kernels.pivoted` takes matrices whose rows and columns are scaled alike and calls a small
    pivot singular. Here columns are of different units, compliances beside stiffnesses: any pivot will do.

    Args:
        matrix: [port, port]; its upper triangle is left.
        right: right-hand sides, [port, row]; what solves them is left there.
    """
    n, many = right.shape
    for k in range(n):
        best, size = k, -1.0
        for i in range(k, n):
            found = abs(matrix[i, k].real) + abs(matrix[i, k].imag)
            if found > size:
                best, size = i, found
        if not size > 0.0:
            return False
        if best != k:
            for j in range(k, n):
                matrix[k, j], matrix[best, j] = matrix[best, j], matrix[k, j]
            for j in range(many):
                right[k, j], right[best, j] = right[best, j], right[k, j]
        pivot = 1.0 / matrix[k, k]
        for i in range(k + 1, n):
            part = matrix[i, k] * pivot
            if part != 0.0:
                for j in range(k + 1, n):
                    matrix[i, j] -= part * matrix[k, j]
                for j in range(many):
                    right[i, j] -= part * right[k, j]
        for j in range(many):
            right[k, j] *= pivot
        for j in range(k + 1, n):
            matrix[k, j] *= pivot
    for k in range(n - 1, -1, -1):
        for i in range(k + 1, n):
            part = matrix[k, i]
            for j in range(many):
                right[k, j] -= part * right[i, j]
    return True


@no_type_check
def fill(values, pairs, small, held, s, m, c, a):
    """C and A of a system on a line.

    Args:
        values: z or c, [port, 1 or system, line].
        pairs: numbers of the coordinates that a compliance lies between, −1 for a stiffness, [port, 2].
        small: patterns of stiffness between the motions that span these, [port, system, motion, motion].
        held: k₀; 0 for stiffness, [system, motion].
        s: number of the system.
        m: number of the line.
        c: to be filled, [motion, motion].
        a: to be filled, [motion, motion].
    """
    n = len(c)
    first = 0
    for i in range(n):
        for j in range(n):
            c[i, j], a[i, j] = 0.0, 0.0
    for p in range(len(pairs)):
        value = values[p, min(s, values.shape[1] - 1), m]
        i, j = pairs[p]
        if i >= 0:
            first = max(first, i + 1, j + 1)
            c[i, j] += value
            if i != j:
                c[j, i] += value
        elif value != 0.0:
            for i in range(n):
                for j in range(n):
                    a[i, j] += value * small[p, s, i, j]
    for i in range(first, n):
        c[i, i] = 1.0
    for i in range(first):
        for j in range(first):
            a[i, j] -= c[i, j] * held[s, j]
        a[i, i] += 1.0


@no_type_check
def forces(values, pairs, small, held, pulled, begin, rows, out):
    """W Bᵀ y of rows from a number on; whether all of it is finite.

    Args:
        values: see `fill`.
        pairs: see `fill`.
        small: see `fill`.
        held: see `fill`.
        pulled: Bᵀ Z⁻¹ of every row, those of the ports last, [system, line, motion, row].
        begin: number of the first row.
        rows: how many there are without the ports'.
        out: [system, line, motion, row].
    """
    systems, lines, n = pulled.shape[:3]
    c, a = np.empty((n, n), dtype=np.complex128), np.empty((n, n), dtype=np.complex128)
    right = np.empty((n, rows - begin), dtype=np.complex128)
    for s in range(systems):
        for m in range(lines):
            fill(values, pairs, small, held, s, m, c, a)
            own = pulled[s, m]
            for i in range(n):
                for j in range(n):
                    total = c[i, j]
                    for k in range(n):
                        total += a[i, k] * own[k, rows + j]
                    c[i, j] = total
                for j in range(begin, rows):
                    total = 0j
                    for k in range(n):
                        total += a[i, k] * own[k, j]
                    right[i, j - begin] = total
            if not eliminate(c, right):
                return False
            for i in range(n):
                for j in range(begin, rows):
                    found = right[i, j - begin]
                    if not (np.isfinite(found.real) and np.isfinite(found.imag)):
                        return False
                    out[s, m, i, j] = found
    return True


@no_type_check
def receptances(table, shift, plain, pulled, force, rounding, out):
    """α′ of every entry; what is nothing but rounding is exactly zero.

    Args:
        table: system, response row and reference row of each entry, [entry, 3].
        shift: response rows there are.
        plain: α, [entry, line].
        pulled: see `forces`.
        force: as `forces` fills it for the references.
        rounding: part of what is subtracted that is none.
        out: [entry, line].
    """
    n = pulled.shape[2]
    for e in range(len(table)):
        s, u, v = table[e, 0], table[e, 1], table[e, 2] + shift
        for m in range(plain.shape[1]):
            taken = 0j
            for i in range(n):
                taken += pulled[s, m, i, u] * force[s, m, i, v]
            found = plain[e, m] - taken
            small = abs(found) <= rounding * (abs(plain[e, m]) + abs(taken))
            out[e, m] = 0.0 if small else found


@no_type_check
def left_over(pulled, force, rows, out):
    """y_b′: motion of the ports that is left under a force at each row.

    Args:
        pulled: see `forces`.
        force: as `forces` fills it for all rows.
        rows: see `forces`.
        out: [system, line, motion, row].
    """
    systems, lines, n = pulled.shape[:3]
    for s in range(systems):
        for m in range(lines):
            for i in range(n):
                for j in range(rows):
                    total = pulled[s, m, i, j]
                    for k in range(n):
                        total -= pulled[s, m, i, rows + k] * force[s, m, k, j]
                    out[s, m, i, j] = total


@no_type_check
def along(table, shift, pairs, small, held, force, left, out):
    """Derivatives of every entry along the value of every port.

    Args:
        table: see `receptances`.
        shift: see `receptances`.
        pairs: see `fill`.
        small: see `fill`.
        held: see `fill`.
        force: as `forces` fills it for all rows.
        left: as `left_over` fills it.
        out: [entry, line, port].
    """
    n = left.shape[2]
    for e in range(len(table)):
        s, u, v = table[e, 0], table[e, 1], table[e, 2] + shift
        for m in range(left.shape[1]):
            one, other = left[s, m], force[s, m]
            for p in range(len(pairs)):
                i, j = pairs[p]
                total = 0j
                if i < 0:
                    for k in range(n):
                        for q in range(n):
                            total -= one[k, u] * small[p, s, k, q] * one[q, v]
                else:
                    fi = other[i, u] + held[s, i] * one[i, u]
                    gj = other[j, v] + held[s, j] * one[j, v]
                    total += fi * gj
                    if i != j:
                        fj = other[j, u] + held[s, j] * one[j, u]
                        gi = other[i, v] + held[s, i] * one[i, v]
                        total += fj * gi
                out[e, m, p] = total
