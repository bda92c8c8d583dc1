"""Poles and participation factors of poly-reference LSCF beside pyOMA2's, in simulated campaigns.

A third route stands beside the two: the residues of least squares, each FRF's own, which fill a matrix for
each mode; where that is of rank one its right singular vector is the participation of the references.
`python benchmarks/ema_participation.py` makes docs/tables/ema_participation.md.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from ema_peaks import ARMS, FRESH, Case, rig_cases
from ema_peers import pyoma_poles

from flexmodal.ema import stabilise
from flexmodal.modal import mac

ORDER = 20
NEAR = 0.25
"""Both have the mode that have a pole within this part of its half-power bandwidth."""


def distances(case: Case) -> list[tuple[float, float, float, float]]:
    """Of each mode that both have: relative distance in frequency and damping, and the two MACs."""
    measured = case.ours.modes.measured
    matrix = measured.matrix
    if matrix is None:
        return []
    diagram = stabilise(measured, highest=ORDER)
    ours = np.flatnonzero(diagram.order == ORDER)
    poles, theirs = pyoma_poles(case.axis, case.matrix, ORDER)[-1]
    found = []
    for mode in case.ours.modes:
        one = ours[np.argmin(np.abs(diagram.pole[ours] - mode.pole))]
        other = int(np.argmin(np.abs(poles - mode.pole)))
        reach = NEAR * 2 * mode.damping_ratio * abs(mode.pole)
        if max(abs(diagram.pole[one] - mode.pole), abs(poles[other] - mode.pole)) > reach:
            continue
        damping = -poles[other].real / abs(poles[other]) / diagram.damping_ratio[one]
        factor = diagram.participation[:, [one]]
        side = np.linalg.svd(mode.residue[matrix])[2][0].conj()
        found.append((
            abs(abs(poles[other]) / abs(diagram.pole[one]) - 1), abs(damping - 1),
            float(mac(factor, theirs[:, [other]])[0, 0]), float(mac(factor, side.conj()[:, None])[0, 0]),
        ))  # fmt: skip
    return found


def row_of(name: str, found: Sequence[tuple[float, float, float, float]]) -> list[str]:
    """Medians, and of the MAC also the tenth that is lowest."""
    frequency, damping, peer, residues = np.array(found).T
    return [
        name,
        str(len(found)),
        f"{100 * np.median(frequency):.3f}",
        f"{100 * np.median(damping):.2f}",
        *(f"{np.median(some):.5f} ({np.quantile(some, 0.1):.3f})" for some in (peer, residues)),
    ]


def main() -> None:
    from tables import write

    rows, everything = [], []
    for arm in ARMS:
        found = [one for seed in FRESH for case in rig_cases(arm, seed) for one in distances(case)]
        everything += found
        rows.append(row_of(str(arm), found))
    rows.append(row_of("all", everything))
    header = ["arm, hidden", "modes", "frequency [%]", "damping [%]", "MAC with pyOMA2", "MAC with residues"]
    write("ema_participation", "Participation factors by three routes", LEAD.replace("\n", " "), header, rows)


LEAD = f"""\
Made by `benchmarks/ema_participation.py`: the fresh campaigns of [ema_peaks](ema_peaks.md), FRFs of two
hammer positions. Poly-reference LSCF of order {ORDER}, ours and pyOMA2's, neither refined: median distance of
the poles of modes that both have, and MAC of their participation factors, median and in brackets the lowest
tenth. The two bases differ (complex on the whole circle here, real on half of it there), so that noise biases
them differently. Residues: the right singular vector of a mode's residues, found by least squares for each
FRF by itself."""


if __name__ == "__main__":
    main()
