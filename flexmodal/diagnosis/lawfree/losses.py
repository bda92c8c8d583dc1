"""Whether a torque that depends on the blow rubs: the part of its free function that takes energy.

A joint's free torque has a complex stiffness z for every blow. Dry friction has a positive imaginary part,
more of it the weaker the blow, as it is the same force over less motion; a spring that is not straight has
none that goes with the force (Gelb and Vander Velde, Multiple-Input Describing Functions, 1968).
"""

from __future__ import annotations

import numpy as np

from flexmodal.diagnosis.lawfree.result import Loss
from flexmodal.diagnosis.lawfree.sighting import Sighting


def loss_of(sighting: Sighting, number: int) -> Loss | None:
    """What a torque takes; None where it has not both weak and hard blows.

    Every line counts for as much as the data know of the function there.

    Args:
        sighting: of ports with a function for every blow.
        number: of the port.
    """
    profile, state = sighting.profile, sighting.state
    at = profile.model.spans[number].start
    known = profile.equations(state, held=True).zz[:, :, at, at].real
    z = state.z[:, at]
    taken, of = 0.0, 0.0
    for weak, hard in _pairs(sighting):
        both = 1 / (1 / np.maximum(known[weak], 1e-300) + 1 / np.maximum(known[hard], 1e-300))
        taken += float(both @ (z[weak] - z[hard]).imag)
        of += float(both @ np.abs(z[weak] - z[hard]))
    total = float(np.sum(known * np.abs(z)))
    return None if of <= 0 or total <= 0 else Loss(float(np.sum(known * z.imag)) / total, taken / of)


def _pairs(sighting: Sighting) -> list[tuple[int, int]]:
    """Cells of the weakest and of the hardest blow on the same place in the same posture."""
    model = sighting.profile.model
    seen, places = model.observations, dict[tuple[int, ...], list[tuple[float, int]]]()
    for cell in range(model.cells):
        row = int(np.flatnonzero(model.cell == cell)[0])
        place = int(seen.posture[row]), *seen.reference[row].tolist()
        places.setdefault(place, []).append((seen.peak(int(seen.level[row])), cell))
    return [(min(each)[1], max(each)[1]) for each in places.values() if min(each)[0] < max(each)[0]]
