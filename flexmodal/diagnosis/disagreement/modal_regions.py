"""Where measured modes and a model disagree, as the regions of a diagnosis."""

from __future__ import annotations

import numpy as np

from flexmodal.diagnosis.outcome import Region
from flexmodal.identification.evidence.likelihood.errors import errors
from flexmodal.identification.evidence.likelihood.laplace import ModalFit
from flexmodal.identification.evidence.modal_gap import DAMPING_SHARE

MOST = 12
STANDS_OUT = 3.0
"""Standard deviations from which an error is named."""


def regions(fit: ModalFit) -> tuple[Region, ...]:
    """Modes that the model lacks, has elsewhere or damps otherwise, the largest share first."""
    table = errors(fit)
    total = float(np.nansum(table**2))
    found = []
    for k, mode in enumerate(fit.measured.modes):
        named = _kind(fit, k, table[k])
        if named is None:
            continue
        kind, says = named
        posture = fit.measured.postures[mode.posture]
        width = mode.damping_ratio if np.isfinite(mode.damping_ratio) else 0.05
        shape = max(mode.shapes, key=lambda s: len(s.places), default=None)
        places = fit.measured.responses if shape is None else shape.places.tolist()
        reference = places[0] if shape is None else shape.reference
        found.append(
            Region(
                posture.id, (int(places[0][0]), int(places[0][1])), (int(reference[0]), int(reference[1])),
                fit.measured.campaign.trials[0].id if fit.measured.campaign.trials else 1,
                (mode.frequency * (1 - width), mode.frequency * (1 + width)),
                float(np.nansum(table[k] ** 2)) / max(total, 1e-300), kind, f"{posture.name}: {says}",
            )
        )  # fmt: skip
    return tuple(sorted(found, key=lambda region: -region.share)[:MOST])


def _kind(fit: ModalFit, k: int, table: np.ndarray) -> tuple[str, str] | None:
    mode = fit.measured.modes[k]
    if fit.pairs[k] < 0:
        return (
            "missing resonance",
            f"a mode at {mode.frequency:.3g} Hz was measured that the model does not have.",
        )
    away = abs(np.log1p(table[0])) / np.hypot(mode.frequency_error, np.exp(fit.scales["frequency"]))
    if away > STANDS_OUT:
        there = mode.frequency * (1 + table[0])
        return (
            "shifted resonance",
            f"the mode at {mode.frequency:.3g} Hz stands at {there:.3g} Hz in the model.",
        )
    if not np.isfinite(table[1]):
        return None
    off = np.log(max(1 + table[1] / DAMPING_SHARE, 1e-9))
    if abs(off) / np.hypot(mode.damping_error, np.exp(fit.scales["damping"])) > STANDS_OUT:
        there = mode.damping_ratio * np.exp(off)
        measured = f"at {mode.frequency:.3g} Hz the damping ratio is {mode.damping_ratio:.3f}"
        says = f"{measured}, the model has {there:.3f}."
        return ("too much damping" if off > 0 else "too little damping"), says
    return None
