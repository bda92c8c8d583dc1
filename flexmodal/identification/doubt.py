"""When intervals are not those of the noise alone: something missing that the parameters make up for.

What a complete model leaves is noise, which neighbouring lines do not share. Where they share some of it,
something is missing, and the parameters that make up for it are wrong by more than noise says. Much of it,
and no interval is given. Less, and each is at least as wide as the parameters move where a posture is left
out: with n postures, fits x_p without each and x to all, the jackknife's

    ± t(n − 1) · √((n − 1)/n · Σ (x_p − x)²)

(Efron and Tibshirani, An Introduction to the Bootstrap, Chapman and Hall 1993, chapter 11). How much complete
models share hangs on what says how noisy the lines are, and so do the limits.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from flexmodal.identification.evidence.both import Both
from flexmodal.identification.evidence.evidence import Evidence
from flexmodal.identification.evidence.frf import FrfEvidence


@dataclass(frozen=True)
class Limits:
    """Of the misfit that neighbouring lines share, in variances of the noise."""

    doubted: float
    """From where intervals are widened."""
    withheld: float
    """From where none are given."""


REPEATS = Limits(0.04, 0.06)
"""Trials that repeat each other tell the noise: of complete models ten shared 0.03 or less and five up to
0.10. Of 24 that lacked a soft link, three times the noise floor high, two shared 0.02 or less, the others
0.06 and more; where six of these shared up to 0.15, intervals as wide as parameters move without a posture
held 39 parameters of 83: what is missing moves them alike in all postures."""
COHERENCE = Limits(0.15, 0.3)
"""Complete models shared up to 0.24."""
LINES = Limits(0.4, 1.0)
"""Nothing but the lines themselves tells the noise, and the scatter of the blows is not in that: complete
models shared up to 0.91."""


def limits(evidence: Evidence, *, bare: bool) -> Limits:
    """Those that go with what says how noisy the lines are.

    Args:
        evidence: that was fitted.
        bare: whether nothing but neighbouring lines says it.
    """
    if bare:
        return LINES
    frfs = evidence.frfs if isinstance(evidence, Both) else evidence
    if not isinstance(frfs, FrfEvidence):
        return COHERENCE
    count = np.bincount(frfs.observations.of_record, minlength=len(frfs.observations))
    return REPEATS if float(np.median(count)) >= 2 else COHERENCE


def jackknife(
    x: Float[np.ndarray, " parameter"], without: Float[np.ndarray, "posture parameter"]
) -> tuple[Float[np.ndarray, " parameter"], float]:
    """Standard errors by how far the parameters move where a posture is left out, and Student's t for 95 %.

    Args:
        x: coordinates of the fit to all.
        without: of the fits without each posture, two or more.
    """
    from scipy.special import stdtrit

    n = len(without)
    error = np.sqrt((n - 1) / n * np.sum((without - x) ** 2, axis=0))
    return error, float(stdtrit(n - 1, 0.975)) if n > 1 else math.inf
