"""A request for a campaign, looked at before anything is simulated."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from flexmodal.campaign import AxisFrame
from flexmodal.errors import Fault, InvalidRequest
from flexmodal.model import Robot
from flexmodal.rig.believed import ParameterError
from flexmodal.rig.hammer_test import Conduct
from flexmodal.rig.hidden.hide import Hide, check_hides
from flexmodal.rig.plan import HammerPlan, make_plan
from flexmodal.rig.plant.card_springs import refuse_springs
from flexmodal.rig.positions import choose_points
from flexmodal.text.gather import Gathering

MOST_WORKERS = 256


@dataclass(frozen=True, eq=False)
class Prepared:
    """A request found sound: what will be struck, and what is to be hidden."""

    robot: Robot
    plan: HammerPlan
    wanted: tuple[Hide, ...]
    error: ParameterError
    conduct: Conduct


def prepare(
    robot: Robot,
    *,
    postures: int | Sequence[str | Mapping[str, float]] = 7,
    points: int | None = None,
    references: int | Sequence[str] = 2,
    axes: str | None = None,
    frame: AxisFrame = "world",
    trials: int = 4,
    averages: int = 3,
    peaks: Sequence[float] = (60.0, 240.0),
    tip: str = "soft",
    band: tuple[float, float] = (2.0, 200.0),
    record_length: float = 4.0,
    hide: Sequence[str | Hide] = (),
    noise: float = 0.01,
    scatter: float = 1.0,
    parameter_error: float | ParameterError = 0.05,
    seed: int = 0,
    workers: int = 1,
) -> Prepared:
    """Look at a request without simulating anything; see `simulate` for the arguments.

    Raises:
        InvalidRequest, InvalidPosture: everything that is wrong, at once.
    """
    gathering = Gathering()
    with gathering.step():
        _check_numbers(noise, scatter, parameter_error, seed, workers)
    with gathering.step():
        plan = make_plan(
            robot, postures=postures, points=points, references=references, axes=axes, frame=frame,
            trials=trials, averages=averages, peaks=peaks, tip=tip, band=band, record_length=record_length,
            random=np.random.default_rng([max(seed, 0), 3]),
        )  # fmt: skip
        refuse_springs(robot, plan)
    wanted = []
    for text in hide:
        with gathering.step():
            wanted.append(Hide.parse(text))
    sensed = None
    with gathering.step():
        sensed = choose_points(robot, points)
    with gathering.step():
        check_hides(robot, sensed, wanted, noise)
    gathering.done()
    error = parameter_error
    if not isinstance(error, ParameterError):
        error = ParameterError.all(error)
    return Prepared(robot, plan, tuple(wanted), error, Conduct(noise, scatter, seed))


def _check_numbers(
    noise: float, scatter: float, error: float | ParameterError, seed: int, workers: int
) -> None:
    sizes = {"noise": noise, "scatter": scatter}
    if isinstance(error, ParameterError):
        sizes |= {f"parameter_error.{name}": float(value) for name, value in vars(error).items()}
    else:
        sizes["parameter_error"] = float(error)
    most = {"noise": 10.0, "scatter": 100.0}
    faults = [
        Fault("call", name, f"{value:g}", f"0 to {most.get(name, 0.5):g}")
        for name, value in sizes.items()
        if not 0 <= value <= most.get(name, 0.5)
    ]
    if seed < 0:
        faults.append(Fault("call", "seed", str(seed), "0 or more"))
    if not 1 <= workers <= MOST_WORKERS:
        faults.append(Fault("call", "workers", str(workers), f"1 to {MOST_WORKERS}"))
    if faults:
        raise InvalidRequest(faults)
