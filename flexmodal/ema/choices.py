"""What a person decides of a fit: band, peaks, what is held, weights and residual terms."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from flexmodal.ema.methods.peak import Peak
from flexmodal.ema.methods.stabilisation import Tolerances


@dataclass(frozen=True)
class Choices:
    """What a person may decide about a fit; the defaults decide nothing by hand."""

    band: tuple[float, float] | None = None
    """Lines to use [Hz]."""
    at: Sequence[float | Peak] | None = None
    """Peaks to take instead of the automatic ones [Hz]."""
    forbid: Sequence[tuple[float, float]] = ()
    """Bands in which no automatic peak is wanted [Hz]."""
    hold_frequency: Sequence[float] = ()
    """Natural frequencies to take as they are [Hz]."""
    damping: Mapping[float, float] = field(default_factory=dict)
    """Damping ratios to force, by the frequency of their peak [Hz]."""
    prominence: float = 2.0
    """Least height of an automatic peak over its valleys [dB]."""
    residuals: str = "complex"
    """Terms for modes outside the band: none, real, complex."""
    weighting: str = "variance"
    """Of least squares: variance, uniform, logarithmic."""
    highest_order: int = 40
    """Of LSCF."""
    tolerances: Tolerances = field(default_factory=Tolerances)
    """Of the stabilisation diagram."""
    refine: bool = True
    """Whether a least squares fit from LSCF's poles takes their bias out and gives intervals."""
    vary: bool = True
    """Whether fits are repeated under other choices than these, to state how far those move each number."""
