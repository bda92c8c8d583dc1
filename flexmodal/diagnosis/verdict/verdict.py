"""The verdict in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from flexmodal.diagnosis.disagreement.compare import excess
from flexmodal.diagnosis.lawfree.result import Findings
from flexmodal.diagnosis.names import NONE, UNKNOWN, UNSTRUCTURED
from flexmodal.diagnosis.outcome import Gaps, Step, Verdict
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.diagnosis.setup import Setup
from flexmodal.report.words import percent
from flexmodal.text.words import enumeration


def verdict(
    setup: Setup,
    steps: Sequence[Step],
    final: FittedFrfs,
    gaps: Gaps,
    over: float,
    *,
    explained: bool,
    named: bool,
    share: float,
    look: Findings,
    lacking: Mapping[int, float] | None = None,
) -> Verdict:
    """Nothing is missing, something of the catalogue is, or something else.

    Args:
        setup: what the diagnosis works with.
        steps: effects that were added.
        final: the model with them.
        gaps: before and after.
        over: how far the model is from the averages, over their noise.
        explained: whether that is near enough.
        named: if not, whether the effect takes the larger part and the law-free look points to its place.
        share: part of the disagreement that the effects take.
        look: the law-free look.
        lacking: measured modes that the model has none for, frequencies [Hz].
    """
    floors = gaps.after / gaps.noise_floor
    effects = tuple((step.effect, step.where) for step in steps)
    silent = f" Of {', '.join(setup.untestable)} these data cannot tell." if setup.untestable else ""
    if explained and not effects:
        says = f"Nothing is missing: re-tuned, the robot's gap is {floors:.2f} × the noise floor.{silent}"
        return Verdict((), True, says)
    if explained:
        words = " and ".join(f"{_says(setup, step.effect)} ({step.where})" for step in steps)
        tied = [_named(*tie) for step in steps for tie in step.ties]
        tail = f" These data cannot tell it from {', '.join(tied)}." if tied else ""
        says = f"Missing: {words}.{tail} The gap falls to {floors:.2f} × the noise floor."
        return Verdict(effects, True, says, share)
    if named:
        step = steps[0]
        says = (
            f"Missing: {_says(setup, step.effect)} ({step.where}). It takes {percent(share)} of the "
            f"disagreement; averaged over repeats the model stays {over:.1f} times as far from the "
            "measurements as noise alone would put it, for its law is not quite the catalogue's. "
            f"{look.says}{silent}"
        )
        return Verdict(effects, False, says, share)
    where = look.best.where if look.explains else place(setup, final)
    near = f" Nearest comes {effects[-1][0]} at {effects[-1][1]}, which is not enough." if effects else ""
    modes = ""
    if lacking:
        frequencies = enumeration([f"{frequency:.3g}" for frequency in lacking.values()])
        modes = f" It has no mode for those measured near {frequencies} Hz."
    says = (
        "Something is missing that nothing in the catalogue explains: averaged over repeats, the model stays "
        f"{over:.1f} times as far from the measurements as noise alone would put it.{modes} "
        f"Look at {where}.{near} {look.says}{silent}"
    )
    return Verdict(((UNKNOWN, where),), False, says)


def _named(effect: str, where: str) -> str:
    """A tied explanation in words."""
    plain = {NONE: "nothing added", UNSTRUCTURED: "a mode with no structure"}
    return plain.get(effect, f"{effect} at {where}")


def _says(setup: Setup, name: str) -> str:
    return next(effect.says for effect in setup.effects if effect.name == name)


def place(setup: Setup, final: FittedFrfs) -> str:
    """Where an unexplained disagreement sits best: the place of what comes nearest, or the worst point."""
    if final.hypothesis.placed:
        return final.hypothesis.keys[-1][1]
    observations = setup.observations
    above = excess(observations, final.predicted).sum(axis=1)
    points = np.unique(observations.response[:, 0])
    share = [above[observations.response[:, 0] == p].sum() for p in points]
    return observations.campaign.point(int(points[int(np.argmax(share))])).name
