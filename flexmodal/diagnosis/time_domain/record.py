"""The FRF that a record of an integrated blow gives: the response's spectrum over the force's, as receptance.

Over a record of length T, under the window e^{−σt} and at s = iω + σ, coordinates that start at rest have

    Z(s) X = jᵀ F − Σ wᵀ T(s) − e^{−sT} [M ẋ(T) + (C + s M) x(T)],

X, F and T the spectra over the record. The bracket is what the record cuts off. It enters a displacement
sensor's spectrum as it is; those of velocity and acceleration have s X + e^{−sT} x(T) and
s² X + e^{−sT} [s x(T) + ẋ(T)], and a receptance is made of them by dividing by s and s².
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from jaxtyping import Complex, Int

from flexmodal.diagnosis.time_domain.integration import Steps, Struck, TimeResponse
from flexmodal.diagnosis.time_domain.law import Law
from flexmodal.diagnosis.time_domain.pulse import Pulse
from flexmodal.identification import Observations
from flexmodal.identification.layout import Part
from flexmodal.structure.structure import Axis, Structure


def record_receptance(
    struck: Struck,
    integrated: TimeResponse,
    steps: Steps,
    wanted: Int[np.ndarray, "wanted 2"],
    back: Complex[np.ndarray, "response dof line"],
) -> Complex[np.ndarray, "wanted line"]:
    """Receptances [m/N] as a record would give them; where `Axis.length` is 0, as if it never ended.

    Args:
        struck: what was integrated.
        integrated: by it.
        steps: of the integration.
        wanted: numbers of a row of `structure.response` and of a blow.
        back: Z⁻¹ of these rows, see `structure.solution.back_solved`.
    """
    structure, axis = struck.structure, struck.axis
    s, n = axis.s, structure.dof
    end = integrated.last if axis.length > 0 else np.zeros_like(integrated.last)
    x, v = end[:, :n], end[:, n:]
    cut = np.exp(-s * steps.length) / integrated.force  # blow, line
    rows = structure.reference[[row for row, _ in struck.blows]]
    laws = np.array([law.row for law in struck.laws]).reshape(-1, n)
    load = rows[:, None, :] - np.einsum("bkl,kd->bld", integrated.torque / integrated.force[:, None], laws)
    still = (v @ structure.mass + x @ structure.damping)[:, None] + s[:, None] * (x @ structure.mass)[:, None]
    load = load - cut[:, :, None] * still
    u, b = wanted[:, 0], wanted[:, 1]
    value = np.einsum("pdl,pld->pl", back[u], load[b])
    if axis.power >= 1:
        value += np.einsum("pd,pd->p", structure.response[u], x[b])[:, None] * cut[b] / s
    if axis.power == 2:
        value += np.einsum("pd,pd->p", structure.response[u], v[b])[:, None] * cut[b] / s**2
    return value


def struck_by(
    structure: Structure,
    part: Part,
    members: Int[np.ndarray, " some"],
    observations: Observations,
    pulses: Sequence[Pulse],
    axis: Axis,
    laws: tuple[Law, ...] = (),
) -> tuple[Struck, Int[np.ndarray, "some 2"]]:
    """Observations of one system as blows on its structure, and the row and the blow of each.

    Args:
        structure: of the system.
        part: that it belongs to.
        members: which observations of the part are of the system.
        observations: all of them.
        pulses: the hammer's, by kind of blow.
        axis: lines that are wanted.
        laws: torques that are not linear.
    """
    _, rows, references = part.entries.table[part.entry[members]].T
    table = np.stack([references, observations.level[part.observations[members]]], axis=1)
    blows, number = np.unique(table, axis=0, return_inverse=True)
    hit = tuple((int(row), pulses[int(kind)]) for row, kind in blows)
    return Struck(structure, laws, axis, hit), np.stack([rows, number.ravel()], axis=1)
