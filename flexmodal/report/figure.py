"""Figures of one look: palette, line styles, axes, and how they become SVG, PNG or part of a page.

A function that draws is decorated with `drawing`; what it makes then has the package's letters, grid and
colours, shows names as they are written, and can be told apart without colours. On a page ink, grid and the
palette are variables of its style sheet, so that the same figure is read on white and on black.
"""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Any, ParamSpec

import numpy as np
from jaxtyping import Float

from flexmodal.files import whole_file
from flexmodal.report.words import RAISED

PALETTE = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#14161A")
"""Okabe and Ito's colours; each curve also has a line style of its own."""
INK, SOFT, LINE, NOISE, PAPER = "#14161A", "#5B626B", "#D6D9DE", "#B9BCC2", "#FFFFFF"
"""Letters; marks and what is behind; grid; bands of noise; ground."""
MEASURED, FITTED, THIRD, MARK = PALETTE[0], PALETTE[1], PALETTE[2], SOFT
STYLES = ("-", "--", "-.", ":")
DASHED = (0, (2, 2))
"""Of a line that marks a place."""
WIDE, NARROW = 7.5, 4.7
"""Of a figure across a page, and of one that two go beside each other [in]."""

_RC = {
    "figure.constrained_layout.use": True, "font.size": 10, "text.parse_math": False, "text.color": INK,
    "axes.titlesize": 11, "axes.titlelocation": "left", "axes.labelsize": 10, "axes.labelcolor": INK,
    "axes.edgecolor": SOFT, "axes.facecolor": "none", "axes.axisbelow": True, "axes.grid": True,
    "axes.spines.top": False, "axes.spines.right": False, "grid.color": LINE, "grid.linewidth": 0.6,
    "xtick.color": SOFT, "ytick.color": SOFT, "xtick.labelcolor": INK, "ytick.labelcolor": INK,
    "xtick.labelsize": 9, "ytick.labelsize": 9, "lines.linewidth": 1.6, "lines.markersize": 5,
    "legend.fontsize": 9, "legend.title_fontsize": 9, "legend.framealpha": 0.85, "legend.facecolor": PAPER,
    "legend.edgecolor": LINE, "figure.titlesize": 11, "figure.facecolor": PAPER, "image.cmap": "cividis",
    "svg.fonttype": "none", "svg.hashsalt": "flexmodal", "savefig.dpi": 150,
}  # fmt: skip
"""Text in an SVG stays text, and its parts have the same names each time."""
_VARIABLES = {
    **{colour.lower(): f"var(--c{number})" for number, colour in enumerate(PALETTE[:-1], start=1)},
    INK.lower(): "var(--ink)", SOFT.lower(): "var(--soft)", LINE.lower(): "var(--line)",
    NOISE.lower(): "var(--noise)", PAPER.lower(): "var(--paper)",
}  # fmt: skip

Given = ParamSpec("Given")


def drawing(draw: Callable[Given, Any]) -> Callable[Given, Any]:
    """Draw a matplotlib figure in the package's style, and leave matplotlib's settings as they were."""

    @wraps(draw)
    def styled(*args: Given.args, **kwargs: Given.kwargs) -> Any:
        import matplotlib as mpl

        with mpl.rc_context(_RC):
            figure = draw(*args, **kwargs)
            for axes in figure.axes:
                for axis in (axes.xaxis, axes.yaxis):
                    _plain(axis)
        return figure

    return styled


def new_figure(width: float, height: float) -> Any:
    """An empty matplotlib figure [in].

    Args:
        width: of the figure [in].
        height: likewise [in].
    """
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height))


def look(place: int, **more: Any) -> dict[str, Any]:
    """Colour and line style of a curve by its number; both repeat after 28 curves."""
    return {"color": PALETTE[place % len(PALETTE)], "linestyle": STYLES[place % len(STYLES)]} | more


def headline(figure: Any, text: str) -> None:
    """A heading over a figure of several panels, broken where it is longer than the figure is wide.

    Args:
        figure: with panels.
        text: of the heading.
    """
    from textwrap import wrap

    letters = int(11 * figure.get_figwidth())
    figure.suptitle("\n".join(wrap(text, letters)), x=0.01, ha="left")


def short(text: str, most: int = 18) -> str:
    """A name cut to so many letters; its end stays, which is what tells `configuration_1` from the next.

    Args:
        text: the name.
        most: letters that are left.
    """
    if len(text) <= most:
        return text
    tail = most // 3
    return f"{text[: most - tail - 1]}…{text[-tail:]}"


def frequency_axis(axes: Any, frequency: Float[np.ndarray, " line"], *, wide: float = 20.0) -> None:
    """Label an x axis; logarithmic where the last frequency is more than `wide` times the first [Hz].

    Args:
        axes: of matplotlib.
        frequency: of the lines [Hz].
        wide: last over first from which the axis is logarithmic.
    """
    axes.set_xlabel("Frequency [Hz]")
    if len(frequency) > 1:
        if frequency[0] > 0 and frequency[-1] / frequency[0] >= wide:
            log_axis(axes.xaxis)
        axes.set_xlim(frequency[0], frequency[-1])


def log_axis(axis: Any) -> None:
    """Make an axis logarithmic, with plain numbers at 1, 2 and 5 of each decade as far as they fit."""
    from matplotlib.ticker import LogLocator, NullLocator

    (axis.axes.set_xscale if axis.axis_name == "x" else axis.axes.set_yscale)("log")
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter("{x:g}")


def phase_axis(axes: Any) -> None:
    """Label a y axis of phases."""
    axes.set(ylabel="Phase [°]", ylim=(-190, 190), yticks=[-180, -90, 0, 90, 180])


def wrapped(
    frequency: Float[np.ndarray, " line"], phase: Float[np.ndarray, " line"]
) -> tuple[np.ndarray, np.ndarray]:
    """Phases [°] over frequency with a gap where they wrap round, so that no line crosses the picture.

    Args:
        frequency: of the lines [Hz].
        phase: at each of them [°].
    """
    jump = np.flatnonzero(np.abs(np.diff(phase)) > 180) + 1
    return np.insert(frequency, jump, frequency[jump]), np.insert(phase, jump, np.nan)


def positive(values: np.ndarray) -> Float[np.ndarray, " line"]:
    """Absolute values for a logarithmic axis: NaN instead of 0."""
    return np.where(np.abs(values) > 0, np.abs(values), np.nan)


def write_figure(figure: Any, path: Path, *, overwrite: bool = False) -> None:
    """Write a figure as PNG or SVG, by the ending of the path.

    Args:
        figure: as a function with `drawing` gives it.
        path: where to.
        overwrite: replace a file that stands there.

    Raises:
        OutputExists: the file exists.
        NotWritten: the disk is full, or the folder may not be written.
    """
    with whole_file(path, overwrite=overwrite) as scratch:
        timeless = (
            {"metadata": {"Date": None}} if scratch.suffix == ".svg" else {}
        )  # the same bytes each time
        _save(figure, scratch, **timeless)


def svg_text(figure: Any) -> str:
    """A figure as an SVG element for a page, in the colours of its style sheet."""
    with io.StringIO() as file:
        _save(figure, file, format="svg", metadata={"Date": None}, transparent=True)
        text = file.getvalue()
    text = re.sub(r'<g id="[^"]*"', "<g", text[text.index("<svg") :])
    text = re.sub(r"(?<=: )#[0-9a-f]{6}\b", lambda found: _VARIABLES.get(found[0], found[0]), text)
    inches = float(figure.get_figwidth())
    return text.replace("<svg ", f'<svg style="--inch: {inches:.3g}" ', 1)


def _save(figure: Any, target: Any, **options: Any) -> None:
    import matplotlib as mpl

    with mpl.rc_context(_RC), warnings.catch_warnings():
        # letters that the font lacks are drawn by the browser all the same
        warnings.filterwarnings("ignore", message="Glyph .* missing")
        figure.savefig(target, **options)


def _plain(axis: Any) -> None:
    """Powers of ten in letters: where names may hold a dollar sign, there is no mathematics in a text."""
    from matplotlib.ticker import LogFormatter

    if axis.get_scale() == "log":
        if isinstance(axis.get_major_formatter(), LogFormatter):
            axis.set_major_formatter(_powers())
        if isinstance(axis.get_minor_formatter(), LogFormatter):
            axis.set_minor_formatter(_powers())


def _powers() -> Any:
    """Matplotlib's own formatter of logarithmic axes, such as "2×10⁻⁵", with digits raised as letters."""
    from matplotlib.ticker import LogFormatterSciNotation

    class Powers(LogFormatterSciNotation):
        def __call__(self, x: float, pos: int | None = None) -> str:
            text = super().__call__(x, pos).replace(r"\times", "×")
            text = re.sub(r"\^\{([-\d]+)\}", lambda power: power[1].translate(RAISED), text)
            return re.sub(r"\$?\\mathdefault|[{}$]", "", text)

    return Powers()
