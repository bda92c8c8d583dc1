"""Ways to predict one posture from others: physics, physics and what it leaves, data alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.identification.baselines import log_mean, posture_distance
from flexmodal.prediction.alignment import aligned, resampled
from flexmodal.prediction.panel import Panel
from flexmodal.prediction.process import features, interpolated

METHODS: Mapping[str, str] = {
    "hybrid": "the model fitted to the others, times a share of what it leaves, learnt over the posture",
    "physics": "the model fitted to the others",
    "process": "their mean, times what that leaves, learnt over the posture: data alone",
    "mean": "the mean of the other postures",
    "nearest": "the nearest posture",
}
"""Every method, the most trusted first."""
DATA_ALONE = ("process", "mean", "nearest")
"""Those that know no physics."""


@dataclass(frozen=True, eq=False)
class Known:
    """What a posture is predicted from."""

    panel: Panel
    postures: tuple[int, ...]
    """Numbers of the postures whose FRFs may be looked at."""
    physics: Complex[np.ndarray, "observation line"]
    """The model's receptances of every observation, by a fit to those postures [m/N]."""
    resonances: Sequence[Float[np.ndarray, " mode"]]
    """The model's natural frequencies in each posture of the panel [Hz]."""
    sliding: tuple[str, ...] = ()
    """Names of prismatic joints."""


def predicted_by_all(
    known: Known, target: int, share: float = 1.0
) -> dict[str, Complex[np.ndarray, "some line"]]:
    """Receptances of a posture's observations by every method [m/N].

    Args:
        known: what may be looked at.
        target: number of the posture; its own FRFs are not looked at.
        share: of what was learnt that goes into `hybrid`.

    Raises:
        MissingExtra: scikit-learn is not installed.
    """
    panel = known.panel
    rows = panel.of_posture(target)
    physics, place = known.physics[rows], panel.place[rows]
    mean = _means(known)
    left = _learnt(known, target, known.physics, align=True)[place]
    alone = _learnt(known, target, mean[panel.place], align=False)[place]
    return {
        "hybrid": physics * np.exp(share * left),
        "physics": physics,
        "process": mean[place] * np.exp(alone),
        "mean": mean[place],
        "nearest": _nearest(known, target, mean)[place],
    }


def _learnt(
    known: Known, target: int, base: Complex[np.ndarray, "observation line"], *, align: bool
) -> Complex[np.ndarray, "place line"]:
    """What a base leaves in the posture asked for, as learnt from the others; 0 at places nobody struck."""
    panel, axis = known.panel, known.panel.axis
    left = []
    for number in known.postures:
        ratio = panel.ratio(number, base)
        if align:
            there = aligned(axis, known.resonances[target], known.resonances[number])
            ratio = resampled(ratio, axis, there)
        left.append(ratio)
    rows = np.array(left)
    struck = np.isfinite(rows)
    some = np.maximum(struck.sum(axis=0), 1)
    usual = np.where(struck, rows, 0).sum(axis=0) / some
    rows = np.where(struck, rows, usual)
    flat = np.concatenate([rows.real, rows.imag], axis=1).reshape(len(rows), -1)
    postures = [panel.observations.postures[number].q for number in (*known.postures, target)]
    at = features(postures, known.sliding)
    found = interpolated(flat, at[:-1], at[-1]).reshape(2, *usual.shape)
    return found[0] + 1j * found[1]


def _means(known: Known) -> Complex[np.ndarray, "place line"]:
    """Mean over the known postures at each place; 1 where none of them was struck there."""
    seen, panel = known.panel.observations, known.panel
    here = np.isin(seen.posture, known.postures)
    found = np.ones((len(panel.pairs), seen.value.shape[1]), dtype=complex)
    for place in np.unique(panel.place[here]).tolist():
        value = log_mean(seen.value[here & (panel.place == place)])
        found[place] = np.where(value == 0, 1.0, value)
    return found


def _nearest(
    known: Known, target: int, mean: Complex[np.ndarray, "place line"]
) -> Complex[np.ndarray, "place line"]:
    """At each place the FRF of the nearest posture that was struck there."""
    seen, panel = known.panel.observations, known.panel
    q = seen.postures[target].q
    order = sorted(known.postures, key=lambda number: posture_distance(seen.postures[number].q, q))
    found, open_ = np.array(mean), np.ones(len(panel.pairs), bool)
    for number in order:
        rows = panel.of_posture(number)
        for place in np.unique(panel.place[rows]).tolist():
            if open_[place]:
                found[place] = log_mean(seen.value[rows[panel.place[rows] == place]])
                open_[place] = False
    return found
