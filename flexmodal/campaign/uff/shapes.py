"""Modes of a universal file (dataset 55) as rows of a mode table.

A real mode φ of modal mass m has the residue A_rf = φ_r φ_f / (2iω_d m), a complex one of modal a
A_rf = φ_r φ_f / a; the table holds A′ = 2iω_d A (`ModeTable`). Dataset 55 names no force: f is the node that
moves most. Without m or a, which are 0 then, shapes are right and sizes are not.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Complex, Int

from flexmodal.campaign.mode_table import ModeTable
from flexmodal.campaign.uff.nodal import MODES, key_of, read_nodal
from flexmodal.campaign.uff.scan import SHAPE, UffContent
from flexmodal.text.words import FaultList

UP = 2
"""Column of z, along which a mode table has its amplitudes."""
NEGLIGIBLE = 0.1
"""Part of the shapes' root sum of squares that may lie in the other directions unsaid."""


@dataclass(frozen=True, eq=False)
class Shape:
    """One mode."""

    case: int
    """Load case; 0 where none is stated."""
    number: int
    frequency: float
    """Natural, undamped [Hz]."""
    damping_ratio: float
    """NaN where none is stated."""
    nodes: Int[np.ndarray, " node"]
    value: Complex[np.ndarray, "node 3"]
    scale: complex
    """A′_rf over φ_r φ_f; 1 where modal mass or modal a are not stated."""
    is_scaled: bool


def shapes_of(content: UffContent, faults: FaultList, warnings: list[str]) -> list[Shape]:
    """Modes among the datasets of a file.

    Args:
        content: of the file.
        faults: where faults go.
        warnings: where sentences on what is left out go.
    """
    found: list[Shape] = []
    for other in (one for one in content.others if one.kind == SHAPE):
        key, table = key_of(other), read_nodal(other, faults)
        if table is None:
            continue
        if table["analysis_type"] not in MODES:
            kind = table["analysis_type"]
            warnings.append(f"{faults.file}: {key} left out: analysis type {kind} is no mode")
            continue
        number, case = int(table["mode_n"]), int(table["load_case"])
        frequency, ratio, scale = _scaled(table)
        if not frequency > 0:
            faults.add(key, f"a natural frequency of {frequency:g} Hz", "one above 0")
        elif number < 1 or case < 0:
            faults.add(
                key, f"mode {number} of load case {case}", "numbers from 1; load case 0 for the only one"
            )
        elif any((one.case, one.number) == (case, number) for one in found):
            faults.add(key, f"mode {number} of load case {case} again", "each mode once")
        else:
            value = np.stack([np.asarray(table[name], dtype=complex) for name in ("r1", "r2", "r3")], axis=1)
            nodes = np.asarray(table["node_nums"], dtype=int)
            found.append(
                Shape(case, number, frequency, ratio, nodes, value, scale or 1.0 + 0.0j, scale is not None)
            )
    return found


def _scaled(table: dict[str, Any]) -> tuple[float, float, complex | None]:
    """Natural frequency [Hz], damping ratio, and A′ over the product of two components."""
    if "eig" not in table:
        mass, viscous = float(table["modal_m"]), float(table["modal_damp_vis"])
        loss = float(table["modal_damp_his"])
        ratio = viscous if viscous > 0 else loss / 2 if loss > 0 else float("nan")
        return float(table["freq"]), ratio, complex(1 / mass) if mass > 0 else None
    pole, a = complex(table["eig"]), complex(table["modal_a"])
    size = abs(pole)
    ratio = -pole.real / size if size > 0 else float("nan")
    return size / (2 * np.pi), ratio, 2j * abs(pole.imag) / a if a != 0 else None


def mode_table(shapes: list[Shape], warnings: list[str], file: object) -> ModeTable | None:
    """The modes as a table, a row for each node; None without modes.

    Args:
        shapes: of one file.
        warnings: where sentences on what a table cannot hold go.
        file: for these.
    """
    if not shapes:
        return None
    total = np.sqrt(np.sum([np.sum(np.abs(one.value) ** 2, axis=0) for one in shapes], axis=0))
    beside = float(np.hypot(total[0], total[1]))
    upright = bool(total[UP] > beside)
    if not upright:
        warnings.append(f"{file}: the shapes of datasets 55 are not along z: frequencies and damping alone")
    elif beside > NEGLIGIBLE * float(np.linalg.norm(total)):
        warnings.append(f"{file}: of the shapes of datasets 55 the components along z alone")
    if upright and not all(one.is_scaled for one in shapes):
        warnings.append(f"{file}: datasets 55 without modal mass or modal a: shapes are right, sizes are not")
    rows, amplitude = [], []
    for one in shapes:
        along = one.value[:, UP]
        first = int(np.argmax(np.abs(along)))
        for node, part in zip(one.nodes.tolist(), along.tolist(), strict=True):
            rows.append((max(one.case, 1), node, int(one.nodes[first]), one.number))
            amplitude.append(one.scale * part * along[first] if upright else complex("nan+nanj"))
    posture, response, reference, mode = np.array(rows, dtype=int).T
    counts = [len(one.nodes) for one in shapes]
    return ModeTable(
        posture, response, reference, mode, np.repeat([one.frequency for one in shapes], counts),
        np.repeat([one.damping_ratio for one in shapes], counts), np.array(amplitude, dtype=complex),
        ("",) * len(rows),
    )  # fmt: skip
