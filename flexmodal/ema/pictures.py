"""Every picture of a campaign's fit that an engineer would ask for, each drawn when it is wanted."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from flexmodal import report
from flexmodal.campaign import Campaign, FrfRecords
from flexmodal.ema.choices import Choices
from flexmodal.ema.estimate import peaks_of
from flexmodal.ema.fit import Fit
from flexmodal.ema.measured import Measured
from flexmodal.ema.methods.circle import CircleFit, fit_circle
from flexmodal.ema.methods.stabilisation import stabilise
from flexmodal.ema.of_campaign import known_variance
from flexmodal.ema.plot import draw_coherence, draw_fit, draw_nyquist
from flexmodal.ema.plot_poles import draw_circle, draw_stabilisation
from flexmodal.ema.plot_shapes import draw_mac, draw_shapes, fixed_place
from flexmodal.ema.records import Place, Trials, by_posture, grouped
from flexmodal.ema.shapes import FittedShapes, fitted_shapes
from flexmodal.files import whole_folder
from flexmodal.modal import mac

_KINDS = ("frf", "nyquist", "circle", "coherence", "stabilisation", "shapes", "mac")
PICTURES = tuple(f"{kind}_*{ending}" for kind in _KINDS for ending in (".png", ".svg"))
"""Names of pictures, as patterns."""
_CURVES = 12
"""Of coherence in one picture."""


@dataclass(frozen=True, eq=False)
class Picture:
    """One picture that can be drawn."""

    section: str
    """Heading that it belongs under."""
    name: str
    """For its file, without ending."""
    draw: Callable[[], Any]
    """Gives a matplotlib figure."""

    def on_page(self) -> report.Picture:
        """As a part of a page."""
        return report.Picture(self.draw, f"{self.section}: {self.name.replace('_', ' ')}")


def pictures(
    fits: Sequence[Fit], records: FrfRecords, campaign: Campaign, choices: Choices
) -> tuple[Picture, ...]:
    """All pictures of some fits, section by section.

    Args:
        fits: what `fit` found.
        records: the FRFs it was found in.
        campaign: for names.
        choices: under which it was found.
    """
    return tuple(
        [
            *_of_frfs(fits, records, campaign, choices),
            *_coherence(records, campaign, choices),
            *_stabilisation(fits, records, campaign, choices),
            *_shapes(fits, campaign),
        ]
    )


def write_pictures(
    drawn: Sequence[Picture], folder: Path, ending: str, *, overwrite: bool = False
) -> tuple[Path, ...]:
    """Write a folder of pictures, each under its name, whole or not at all.

    Args:
        drawn: what to draw.
        folder: new, or with `overwrite` one with nothing in it but earlier pictures.
        ending: ".png" or ".svg".
        overwrite: replace such a folder.

    Raises:
        OutputExists: something else stands there.
        NotWritten: the disk is full, or the folder may not be written.
    """
    with whole_folder(folder, own=PICTURES, overwrite=overwrite) as scratch:
        for picture in drawn:
            report.write_figure(picture.draw(), scratch / f"{picture.name}{ending}")
    return tuple(folder / f"{picture.name}{ending}" for picture in drawn)


def _of_frfs(
    fits: Sequence[Fit], records: FrfRecords, campaign: Campaign, choices: Choices
) -> Iterator[Picture]:
    """Amplitude and phase of each FRF, its Nyquist plot, and its circles where those were fitted."""
    shown = [(one, frf) for one in fits for frf in range(len(one.places))]
    for one, frf in shown:
        place, title = one.places[frf], _title(one, frf, campaign)
        yield Picture(
            "Measured and synthesised", f"frf_{_file(place)}", partial(_fit, one, frf, records, title)
        )
    for one, frf in shown:
        title = _title(one, frf, campaign)
        name = f"nyquist_{_file(one.places[frf])}"
        yield Picture("Nyquist plots", name, partial(draw_nyquist, one.modes, frf, title=title))
    if fits and fits[0].modes.method == "circle":
        yield from _circles(shown, records, campaign, choices)


def _circles(
    shown: Sequence[tuple[Fit, int]], records: FrfRecords, campaign: Campaign, choices: Choices
) -> Iterator[Picture]:
    """The circles of the fit through the lines as measured, so with the damping of a window."""
    if not shown:
        return
    trials: Trials = "average" if shown[0][0].places[0].trial is None else "separate"
    axis = shown[0][0].modes.measured.frequency
    peaks = {
        posture: peaks_of(whole.within(float(axis[0]), float(axis[-1])), choices)
        for posture, _, whole in by_posture(records, trials, known_variance(records))
    }
    for one, frf in shown:
        single, title = one.modes.measured.only(frf), _title(one, frf, campaign)
        circles = [fit_circle(single, peak) for peak in peaks[one.posture]]
        good = [circle for circle in circles if isinstance(circle, CircleFit)]
        for number, circle in enumerate(good, start=1):
            name = f"circle_{_file(one.places[frf])}_{number}"
            yield Picture("Circles", name, partial(draw_circle, circle, title=title))


def _coherence(records: FrfRecords, campaign: Campaign, choices: Choices) -> Iterator[Picture]:
    if records.coherence is None:
        return
    low, high = choices.band or campaign.band
    inside = (records.frequency >= low) & (records.frequency <= high)
    groups = grouped(records, "average")
    for posture in dict.fromkeys(place.posture for place in groups):
        rows = {str(place): rows for place, rows in groups.items() if place.posture == posture}
        mean = np.array([records.coherence[numbers].mean(axis=0)[inside] for numbers in rows.values()])
        for first in range(0, len(mean), _CURVES):
            part = "" if len(mean) <= _CURVES else f"_{first // _CURVES + 1}"
            labels = list(rows)[first : first + _CURVES]
            title = f"{_posture(posture, campaign)}: coherence, mean of the trials"
            axis = records.frequency[inside]
            draw = partial(draw_coherence, axis, mean[first : first + _CURVES], labels, title=title)
            yield Picture("Coherence", f"coherence_{posture}{part}", draw)


def _stabilisation(
    fits: Sequence[Fit], records: FrfRecords, campaign: Campaign, choices: Choices
) -> Iterator[Picture]:
    """The diagram from which the modes were chosen: of all FRFs of a posture, or of each FRF's own LSCF."""
    if not fits:
        return
    single = fits[0].modes.method == "lscf" and len(fits[0].places) == 1
    if single:
        for one in fits:
            title = _title(one, 0, campaign)
            draw = partial(_diagram, one.modes.measured, list(one.modes.frequency), choices, title)
            yield Picture("Stabilisation", f"stabilisation_{_file(one.places[0])}", draw)
        return
    axis = fits[0].modes.measured.frequency
    for posture, _, whole in by_posture(records, "average", known_variance(records)):
        found = [mode.frequency for one in fits if one.posture == posture for mode in one.modes]
        part = whole.within(float(axis[0]), float(axis[-1]))
        title = f"{_posture(posture, campaign)}: all FRFs"
        draw = partial(_diagram, part, found, choices, title)
        yield Picture("Stabilisation", f"stabilisation_{posture}", draw)


def _diagram(measured: Measured, found: list[float], choices: Choices, title: str) -> Any:
    highest = min(choices.highest_order, (len(measured.frequency) - 1) // 2)
    diagram = stabilise(measured, highest=highest, tolerances=choices.tolerances)
    return draw_stabilisation(diagram, found, title=title)


def _shapes(fits: Sequence[Fit], campaign: Campaign) -> Iterator[Picture]:
    """Shapes along the arm, their auto-MAC, and the MAC from each posture to the next."""
    names = {point.id: point.name for point in campaign.points}
    shapes = fitted_shapes(fits)
    for one in shapes:
        title = f"{_posture(one.posture, campaign)}, {fixed_place(one, names)}"
        yield Picture(
            "Shapes along the arm", f"shapes_{_stem(one)}", partial(draw_shapes, one, names, title=title)
        )
    for one in shapes:
        title = f"Auto-MAC: {_posture(one.posture, campaign)}, {fixed_place(one, names)}"
        yield Picture("Modal assurance criterion", f"mac_{_stem(one)}", partial(_mac, one, one, title))
    for one in shapes:
        later = [other for other in shapes if _alike(one, other) and other.posture > one.posture]
        if later:
            other = min(later, key=lambda shape: shape.posture)
            between = f"{_posture(one.posture, campaign)} against {_posture(other.posture, campaign)}"
            title = f"MAC: {between}, {fixed_place(one, names)}"
            name = f"mac_{_stem(one)}_against_{other.posture}"
            yield Picture("Modal assurance criterion", name, partial(_mac, one, other, title))


def _alike(one: FittedShapes, other: FittedShapes) -> bool:
    """Whether two shapes are of the same places under the same hammer or past the same sensor."""
    return (one.places, one.side, one.fixed, one.trial) == (
        other.places,
        other.side,
        other.fixed,
        other.trial,
    )


def _mac(one: FittedShapes, other: FittedShapes, title: str) -> Any:
    rows, columns = ([f"{f:.4g} Hz" for f in shapes.frequency] for shapes in (one, other))
    first, second = (f"Posture {shapes.posture}" for shapes in (one, other))
    return draw_mac(mac(one.shape, other.shape), rows, columns, first=first, second=second, title=title)


def _fit(one: Fit, frf: int, records: FrfRecords, title: str) -> Any:
    place, coherence = one.places[frf], None
    if records.coherence is not None:
        rows = grouped(records, "average" if place.trial is None else "separate")[place]
        lines = np.isin(records.frequency, one.modes.measured.frequency)
        coherence = records.coherence[rows][:, lines].mean(axis=0)
    return draw_fit(one.modes, frf, coherence=coherence, title=title)


def _posture(number: int, campaign: Campaign) -> str:
    return f"Posture {number}, {campaign.posture(number).name}"


def _title(one: Fit, frf: int, campaign: Campaign) -> str:
    return f"{_posture(one.posture, campaign)}: {one.places[frf]}"


def _file(place: Place) -> str:
    text = str(place).replace(":", "").replace(" ", "_").replace(",", "")
    return f"{place.posture}_{text}"


def _stem(shapes: FittedShapes) -> str:
    point, way = shapes.fixed
    tool = "hammer" if shapes.side == "reference" else "sensor"
    trial = "" if shapes.trial is None else f"_trial_{shapes.trial}"
    return f"{shapes.posture}_{tool}_{point}{'+' if way > 0 else '-'}{'xyz'[abs(way) - 1]}{trial}"
