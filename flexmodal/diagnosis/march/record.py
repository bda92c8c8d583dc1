"""The FRF that a record of a marched blow gives: the response's spectrum over the force's, as receptance.

Over a record of length T, under the window e^{−σt} and at s = iω + σ, coordinates that start at rest have

    Z(s) X = jᵀ F − Σ wᵀ T(s) − e^{−sT} [M ẋ(T) + (C + s M) x(T)],

X, F and T the spectra over the record. The bracket is what the record cuts off. It enters a displacement
sensor's spectrum as it is; those of velocity and acceleration have s X + e^{−sT} x(T) and
s² X + e^{−sT} [s x(T) + ẋ(T)], and a receptance is made of them by dividing by s and s².
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from jaxtyping import Complex, Int

from flexmodal.campaign.blow import FORM_OF
from flexmodal.diagnosis.march.integrate import FINENESS, March, Steps, Struck, held, state_matrix
from flexmodal.diagnosis.march.law import Law
from flexmodal.diagnosis.march.pulse import Pulse
from flexmodal.diagnosis.march.spectrum import spectrum
from flexmodal.identification import Observations
from flexmodal.identification.model import Group

_PULSE = 64
"""Steps through a pulse."""
FORMS = {"receptance": 0, "mobility": 1, "inertance": 2}
"""Derivatives of displacement that a sensor measures."""


def record_receptance(
    struck: Struck,
    marched: March,
    steps: Steps,
    form: str,
    wanted: Int[np.ndarray, "wanted 2"],
) -> Complex[np.ndarray, "wanted line"]:
    """Receptances [m/N] as a record would give them.

    Args:
        struck: what was marched.
        marched: by it.
        steps: of the march.
        form: what the sensor measures per force: a name of `FORMS`.
        wanted: numbers of a row of `structure.response` and of a blow.
    """
    structure, axis = struck.structure, struck.axis
    s, n = axis.s, structure.dof
    x, v = marched.last[:, :n], marched.last[:, n:]
    cut = np.exp(-s * steps.length) / marched.force  # blow, line
    rows = structure.reference[[row for row, _ in struck.blows]]
    laws = np.array([law.row for law in struck.laws]).reshape(-1, n)
    load = rows[:, None, :] - np.einsum("bkl,kd->bld", marched.torque / marched.force[:, None], laws)
    still = (v @ structure.mass + x @ structure.damping)[:, None] + s[:, None] * (x @ structure.mass)[:, None]
    load = load - cut[:, :, None] * still
    back, _ = structure.solve(axis)  # line, dof, response
    u, b = wanted[:, 0], wanted[:, 1]
    value = np.einsum("lpd,pld->pl", np.swapaxes(back, 1, 2)[:, u], load[b])
    derivatives = FORMS[form]
    if derivatives:
        value += np.einsum("pd,pd->p", structure.response[u], x[b])[:, None] * cut[b] / s
    if derivatives == 2:
        value += np.einsum("pd,pd->p", structure.response[u], v[b])[:, None] * cut[b] / s**2
    return value


def coast(struck: Struck, steps: Steps) -> March:
    """The march of a structure without laws: nothing but the pulse has to be stepped through."""
    from scipy.linalg import expm

    structure, n = struck.structure, struck.structure.dof
    a = state_matrix(structure, struck.axis)[None]
    pushed = np.linalg.solve(structure.mass, structure.reference.T)
    columns = np.vstack([np.zeros_like(pushed), pushed])[None]
    force = np.zeros((len(struck.blows), len(struck.axis)), dtype=complex)
    last = np.zeros((len(struck.blows), 2 * n))
    for pulse in {pulse for _, pulse in struck.blows}:
        step = pulse.length / _PULSE
        sampled = pulse.force(np.arange(_PULSE + 1) * step)
        phi, early, late = held(a, columns, step)
        state = np.zeros((2 * n, len(structure.reference)))
        for first, second in pairwise(sampled):
            state = phi[0] @ state + first * early[0] + second * late[0]
        state = expm(a[0] * (steps.length - pulse.length)) @ state
        for number, (row, own) in enumerate(struck.blows):
            if own == pulse:
                force[number], last[number] = spectrum(sampled, struck.axis, step), state[:, row]
    return March(force, np.zeros((len(force), 0, force.shape[1]), dtype=complex), last)


def struck_by(
    group: Group,
    observations: Observations,
    pulses: Sequence[Pulse],
    lines: slice | Int[np.ndarray, " line"],
    laws: tuple[Law, ...] = (),
) -> tuple[Struck, Int[np.ndarray, "observation 2"]]:
    """A group of observations as blows on its structure, and the row and the blow of each."""
    level = observations.level[group.observations]
    table = np.stack([group.pairs[:, 1], level], axis=1)
    blows, number = np.unique(table, axis=0, return_inverse=True)
    struck = Struck(
        group.structure,
        laws,
        observations.axis_of(group.level).take(lines),
        tuple((int(row), pulses[int(kind)]) for row, kind in blows),
    )
    return struck, np.stack([group.pairs[:, 0], number.ravel()], axis=1)


def steps_behind(observations: Observations, pulses: Sequence[Pulse], fineness: float = FINENESS) -> Steps:
    """The records behind observations; they begin with the blow where nobody recorded when it fell."""
    campaign = observations.campaign
    known = [campaign.trial(level[0]).record_length for level in observations.levels]
    return Steps.behind(
        observations.axis.frequency,
        length=max((one for one in known if one), default=None),
        start=float(np.mean([pulse.start for pulse in pulses])),
        fineness=fineness,
    )


def measured_form(observations: Observations) -> str:
    """What the sensors measured per force: a name of `FORMS`."""
    campaign = observations.campaign
    if campaign.frfs is not None:
        return campaign.frfs.form
    return FORM_OF[campaign.blows[0].quantity]
