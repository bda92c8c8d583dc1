"""A diagnosis on its robot, gone through step by step: the card, re-tuned, with each effect found."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from flexmodal.diagnosis import Diagnosis
from flexmodal.diagnosis.outcome import Step
from flexmodal.diagnosis.report.pictures import telling_rows
from flexmodal.diagnosis.report.words import effect_words, pair, placed
from flexmodal.identification import Observations
from flexmodal.identification.frf_fit import residual
from flexmodal.report.words import error, figure, percent, size
from flexmodal_viewer.arm import Arm
from flexmodal_viewer.diagnosis_marks import mark_of, points_on
from flexmodal_viewer.live_measured import short
from flexmodal_viewer.live_numbers import live_numbers
from flexmodal_viewer.live_scene import live_scene
from flexmodal_viewer.palette import JOINT, POINT, TARGET
from flexmodal_viewer.scene import Scene, Swatch

_MOST_LINES = 800
"""Of a curve; of finer ones every second, third, … is taken."""


def diagnosis_scene(diagnosis: Diagnosis) -> Scene:
    """Draw a diagnosis on the robot as it was believed to be, its joints to be moved by hand as well.

    Args:
        diagnosis: what `flexmodal.diagnose` found.

    Raises:
        InvalidRequest: joints that a page cannot move.
    """
    context = diagnosis.model.context
    robot, points = context.robot, context.points
    arm = Arm(robot)
    scene = live_scene(robot, robot.posture(dict(context.postures[0].q)), band=context.band)
    here = [point for point in points if point.link in arm.index]
    tested, legend = points_on(arm, here), []
    found = [
        mark_of(arm, points, number, step.where, placed(step.effect, step.where))
        for number, step in enumerate(diagnosis.steps)
    ]
    drawn = tested
    for one in found:
        drawn = drawn.beside(one)
    if diagnosis.frfs is not None:
        text = "measured points: the larger and the more orange, the farther the model is from them"
        legend.append(Swatch(text, JOINT, "dot"))
    if found:
        legend.append(Swatch("what is missing, from the step on that adds it", TARGET, "clear"))
    told = _told(diagnosis) | {
        "points": [
            [f"/flexmodal/{item.path}", one.name] for item, one in zip(tested.items, here, strict=True)
        ],
        "marks": [[f"/flexmodal/{item.path}" for item in one.items] for one in found],
    }
    places = {point.name: point for point in here}
    return replace(
        scene,
        items=(*(item for item in scene.items if "/point_" not in item.path), *drawn.items),
        labels=(*(label for label in scene.labels if "/point_" not in label.path), *drawn.labels),
        caption=replace(
            scene.caption,
            title=f"Diagnosis of “{diagnosis.campaign}”",
            subtitle=f"with the robot {robot.title or robot.name}",
            legend=(*(one for one in scene.caption.legend if one.colour != POINT), *legend),
        ),
        live={**(scene.live or {}), "robot": live_numbers(robot, (), places), "diagnosis": told},
    )


def _told(diagnosis: Diagnosis) -> dict[str, Any]:
    """What the page goes through."""
    seen = diagnosis.frfs
    return {
        "stages": _stages(diagnosis),
        "pairs": [] if seen is None else [_pair(diagnosis, seen, row) for row in telling_rows(diagnosis)],
        "misfit": {} if seen is None else {name: _misfit(seen, p) for name, p in diagnosis.predicted.items()},
        "noise": size(diagnosis.gaps.noise_floor),
        "verdict": diagnosis.verdict.says,
    }


def _stages(diagnosis: Diagnosis) -> list[dict[str, Any]]:
    """Name, words and gap of each model: the card, re-tuned, with the first effect, and so on."""
    gaps, steps = diagnosis.gaps, diagnosis.steps
    first = "Nothing fitted: the robot as its card has it."
    found = [_stage("believed", "the card as it came", first, gaps.believed, None, 0)]
    tuned = "The card's own parameters fitted to the measurements, nothing added."
    found.append(_stage("before", "re-tuned, nothing added", tuned, gaps.before, gaps.held_out_before, 0))
    words = effect_words(diagnosis)
    for number, step in enumerate(steps, start=1):
        last = number == len(steps)
        after = gaps.after if last else step.gaps.after
        held = gaps.held_out_after if last else step.gaps.held_out_after
        what = words.get(step.effect, step.effect)
        says = f"{what[:1].upper()}{what[1:]}: {_parameters(step)}"
        key = "after" if last else f"step {number}"
        found.append(_stage(key, f"and {placed(step.effect, step.where)}", says, after, held, number))
    if not steps and diagnosis.model.placed:
        tried = "Not named: it does not explain the measurements, or gains too little."
        stage = ("after", "with the best that was tried", tried, gaps.after, gaps.held_out_after, 0)
        found.append(_stage(*stage))
    return found


def _stage(
    key: str, name: str, says: str, gap: float | None, held: float | None, marks: int
) -> dict[str, Any]:
    return {
        "key": key,
        "name": name,
        "says": says,
        "gap": size(gap),
        "held": "" if held is None else size(held),
        "marks": marks,
    }


def _parameters(step: Step) -> str:
    """Such as "stiffness 8.1 × 10⁵ ± 2 × 10⁴ N·m/rad; confidence 93 %."."""
    found = []
    for name, value in step.parameters.items():
        about, unit = step.uncertainty.get(name), step.units.get(name, "")
        sure = "" if about is None else f" ± {error(about)}"
        found.append(f"{name.replace('_', ' ')} {figure(value)}{sure} {unit}".strip())
    return f"{', '.join(found)}; confidence {percent(step.confidence)}."


def _pair(diagnosis: Diagnosis, seen: Observations, row: int) -> dict[str, Any]:
    """One FRF, measured and by each model [m/N], with the bands in which they disagree [Hz]."""
    lines = np.flatnonzero(seen.used[row])
    lines = lines[:: max(1, -(-len(lines) // _MOST_LINES))]
    posture = seen.postures[int(seen.posture[row])]
    regions = {"before": diagnosis.disagreement, "after": diagnosis.remaining}
    key = (posture.id, tuple(seen.response[row].tolist()), tuple(seen.reference[row].tolist()))
    return {
        "name": f"{posture.name}: {pair(seen, row)}",
        "posture": posture.name,
        "q": dict(posture.q),
        "response": seen.direction(seen.response[row]),
        "reference": seen.direction(seen.reference[row]),
        "frequencies": short(seen.axis.frequency[lines], 7),
        "measured": short(np.abs(seen.value[row, lines]), 4),
        "stages": {name: short(np.abs(one[row, lines]), 4) for name, one in diagnosis.predicted.items()},
        "bands": {
            name: [
                {"band": list(one.band), "says": one.says}
                for one in some
                if (one.posture, tuple(map(abs, one.response)), tuple(map(abs, one.reference))) == key
            ]
            for name, some in regions.items()
        },
    }


def _misfit(seen: Observations, predicted: np.ndarray) -> dict[str, dict[str, float]]:
    """Root mean square of |ln(model / measured)| over that of the noise, by posture and point.

    A point counts with the FRFs of its sensor, and where there is none with those of the hammer there.
    """
    squared = np.where(seen.used, np.abs(residual(predicted, seen.value)) ** 2, 0.0).sum(axis=1)
    noise = np.where(seen.used, seen.variance, 0.0).sum(axis=1)
    found: dict[str, dict[str, float]] = {}
    for number, posture in enumerate(seen.postures):
        here: dict[str, float] = {}
        for point in seen.campaign.points:
            of = [np.flatnonzero((seen.posture == number) & (way[:, 0] == point.id)) for way in _ways(seen)]
            rows = next((some for some in of if len(some)), np.zeros(0, dtype=int))
            if len(rows) and noise[rows].sum() > 0:
                here[point.name] = float(f"{np.sqrt(squared[rows].sum() / noise[rows].sum()):.4g}")
        found[posture.name] = here
    return found


def _ways(seen: Observations) -> tuple[np.ndarray, np.ndarray]:
    return seen.response, seen.reference
