"""The stabilisation diagram to click in: what the page needs of each posture, as numbers for its script."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from flexmodal.campaign import Campaign, FrfRecords
from flexmodal.ema.choices import Choices
from flexmodal.ema.chosen import fingerprint_of
from flexmodal.ema.fit import Fit
from flexmodal.ema.measured import Measured
from flexmodal.ema.methods.stabilisation import stabilise
from flexmodal.ema.methods.standing import mode_indicator
from flexmodal.ema.mode import ModeEstimate
from flexmodal.ema.of_campaign import known_variance
from flexmodal.ema.records import by_posture
from flexmodal.frf.form import POWER, unit
from flexmodal.report import Live, Parts, Section, Text

_LARGEST = 6_000_000
"""Bytes of FRFs that a page takes, so that it still opens at once; further postures need a page of their
own."""
_APART, _LINE = 0.5, 0.25
"""A pole replaces a chosen one closer than this part of its decay rate, or of the way between two lines."""
_DRAWN = 400
"""Points of the drawn indicator."""
_TOLD = """Choose and drop poles: with the mouse in the diagram, with the arrow keys and Enter, or in the list
below it. Residues are fitted again at once, with poles as chosen and every line alike. Curves are drawn with
at most 700 lines; what is fitted is all of them. ○ stable in frequency and damping, × in frequency, · new; ◆
and a dashed line: chosen;
grey: the mode indicator."""


def choosing(fits: Sequence[Fit], records: FrfRecords, campaign: Campaign, choices: Choices) -> list[Section]:
    """The section of a page in which poles are chosen; none without FRFs that carry a diagram.

    Args:
        fits: what `fit` found.
        records: the FRFs it was found in.
        campaign: for names.
        choices: under which it was found.
    """
    if not fits:
        return []
    axis = fits[0].modes.measured.frequency
    band = (float(axis[0]), float(axis[-1]))
    postures: list[dict[str, Any]] = []
    size, left = 0, 0
    for posture, places, whole in by_posture(records, "average", known_variance(records)):
        some = [one for one in fits if one.posture == posture]
        part = whole.within(*band)
        size += part.value.nbytes
        if not some or len(part.frequency) < 13:
            continue
        if postures and size > _LARGEST:
            left += 1
            continue
        name = f"Posture {posture}, {campaign.posture(posture).name}"
        postures.append(_posture(posture, name, [str(place) for place in places], part, some, choices))
    if not postures:
        return []
    everything = {
        "title": campaign.title, "band": list(band), "residuals": choices.residuals, "apart": _APART,
        "postures": postures,
    }  # fmt: skip
    script = (Path(__file__).parent / "choose.js").read_text(encoding="utf-8")
    instead = "This needs a browser that runs scripts; flexmodal fit --pictures FOLDER draws the diagram."
    parts: Parts = [Text(_TOLD.replace("\n", " "), note=True), Live("choose", everything, script, instead)]
    if left:
        more = f"{left} postures more are left out to keep the page small; name them by --posture."
        parts = [*parts, Text(more, note=True)]
    return [Section("Choose the modes", parts)]


def _posture(
    number: int, name: str, labels: list[str], part: Measured, fits: Sequence[Fit], choices: Choices
) -> dict[str, Any]:
    """The numbers of one posture."""
    highest = min(choices.highest_order, (len(part.frequency) - 1) // 2)
    diagram = stabilise(part, highest=highest, tolerances=choices.tolerances)
    indicator = 10 * np.log10(np.maximum(mode_indicator(part), 1e-300))
    bins = np.array_split(np.arange(len(indicator)), min(_DRAWN, len(indicator)))
    tops = np.array([lines[np.argmax(indicator[lines])] for lines in bins])
    stacked = np.concatenate([part.value.real, part.value.imag]).T
    return {
        "posture": number,
        "name": name,
        "labels": labels,
        "form": part.form,
        "unit": f"1 {unit(part.form)}",
        "least": _LINE * 2 * np.pi * part.spacing,
        "power": POWER[part.form],
        "frequency": _base64(part.frequency),
        "value": _base64(stacked),
        "highest": int(diagram.orders[-1]),
        "pole": {
            "frequency": _base64(diagram.frequency),
            "damping": _base64(diagram.damping_ratio),
            "order": diagram.order.tolist(),
            "kind": (diagram.stable_frequency.astype(int) + diagram.stable).tolist(),
        },
        "columns": diagram.choose().tolist(),
        "chosen": _chosen(fits),
        "indicator": [
            [round(float(part.frequency[line]), 4), round(float(indicator[line]), 2)] for line in tops
        ],
        "fingerprint": list(fingerprint_of(part)),
    }


def _chosen(fits: Sequence[Fit]) -> list[list[float]]:
    """The modes of the fit, as the FRFs show them: those of a posture, or the median of each FRF's own."""
    numbered: dict[int, list[complex]] = {}
    for one in fits:
        for number, mode in one.numbered():
            numbered.setdefault(number, []).append(_as_measured(mode, one.modes.decay))
    poles = [complex(np.median(np.real(some)), np.median(np.imag(some))) for some in numbered.values()]
    return sorted(
        [abs(pole) / (2 * np.pi), -pole.real / abs(pole)] for pole in poles if pole.real < 0 < pole.imag
    )


def _as_measured(mode: ModeEstimate, decay: float) -> complex:
    """The pole with the damping that a window added."""
    return mode.pole - decay


def _base64(values: np.ndarray) -> str:
    return base64.b64encode(np.ascontiguousarray(values, dtype="<f8").tobytes()).decode("ascii")
