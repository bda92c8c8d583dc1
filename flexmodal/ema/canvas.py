"""What the pictures of a fit have in common: size, grid, colours."""

from __future__ import annotations

from typing import Any

from flexmodal.frf.plot import PALETTE

MEASURED, FITTED, THIRD, MARK = PALETTE[0], PALETTE[1], PALETTE[2], "0.35"


def canvas(width: float, height: float) -> Any:
    """An empty matplotlib figure [inch]."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")


def grid(axes: Any) -> None:
    """A light grid behind the curves."""
    axes.grid(True, which="major", color="0.85", linewidth=0.6)
    axes.set_axisbelow(True)
