"""Trust in a card of which little is known: a supplier's masses, stiffness and damping guessed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType

DECADE = math.log(10) / 2
"""Standard deviation of a logarithm of which 95 % lie within a factor of ten."""

POOR: Mapping[str, float] = MappingProxyType(
    {"stiffness": DECADE, "damping": DECADE, "mass": 0.4, "inertia": 0.4}
)
"""Standard deviations of ln(true / card) by kind: a decade for what was guessed, 40 % for masses."""
