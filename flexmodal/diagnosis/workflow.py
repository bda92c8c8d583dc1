"""The workflow: re-tune, compare, hypothesise, weigh, add, and again, until nothing significant is left."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from threadpoolctl import threadpool_limits

from flexmodal.campaign import Campaign
from flexmodal.diagnosis.outcome import Diagnosis
from flexmodal.diagnosis.parallel.workers import working_on
from flexmodal.diagnosis.result import diagnosis_of
from flexmodal.diagnosis.selection.asked import asked_of
from flexmodal.diagnosis.selection.beside_frfs import ModesBeside
from flexmodal.diagnosis.selection.comparison import M
from flexmodal.diagnosis.selection.data import Data
from flexmodal.diagnosis.selection.decision import Asked
from flexmodal.diagnosis.selection.frf_data import FrfData
from flexmodal.diagnosis.selection.modal_data import ModalData
from flexmodal.diagnosis.selection.selection import ForwardSelection
from flexmodal.diagnosis.selection.set_up_anew import set_up_closely
from flexmodal.diagnosis.setup import Advance, numbers_of, prepare, trust_of
from flexmodal.diagnosis.time_limit import TimeLimit, limit_of
from flexmodal.identification.compatibility import check_compatible, placed_on
from flexmodal.identification.evidence.mode_sources import modes_of_table
from flexmodal.identification.source import Source, doubled, source_of
from flexmodal.model import Robot
from flexmodal.structure import robot_space

MODAL_TRUST = {"stiffness": 0.5, "damping": 1.0, "mass": 0.2, "inertia": 0.2}
"""Standard deviation of ln(true / card) with modes alone, unless the card or the caller says other; the
comparison halves and doubles it."""


def diagnose(
    campaign: Campaign,
    robot: Robot,
    *,
    source: Source | None = None,
    hold_out: Sequence[int | str] | None = None,
    effects: Sequence[str] | None = None,
    trust: Mapping[str, float] | None = None,
    seed: int = 0,
    within: float | None = None,
    workers: int | None = None,
    advance: Advance = lambda doing, part: None,
) -> Diagnosis:
    """Find what is missing between a robot and a campaign of hammer tests on it.

    Args:
        campaign: with FRFs, blows to estimate them from, modes, or FRFs and modes, which both count then. Of
            modes alone, a point on a link that the robot lacks is taken where its card has a point of that
            name.
        robot: as it is believed to be.
        source: "frf", "modes" or "both"; everything that was measured by default.
        hold_out: postures (ids or names) that no fit sees. By default one in four, at least one,
            those on which the re-tuned robot is neither best nor worst; with fewer than three postures none.
            With modes alone each is left out in turn, with three or more.
        effects: names from the catalogue; all by default. `NAME@WHERE` looks in that place only, and adds the
            effect there if it gains more than a tie.
        trust: standard deviation of ln(true / card) by kind or parameter name.
        seed: of the bootstrap, and of the postures tried for the next measurement.
        within: seconds after which it stops looking and says what it has found by then, which another
            computer may not have; by default it takes as long as it takes. The first look, without a law, is
            not cut off.
        workers: processes that it works on, which changes no result but for rounding; by default as many as
            the environment variable FLEXMODAL_WORKERS says, or else as there are cores, at most 8. On other
            systems than Linux it is always one.
        advance: called with what is being done and the part of it that is done.

    Raises:
        InvalidRequest: no data, unknown effects or postures, a campaign that does not belong to the robot,
            no time, no such number of workers.
    """
    limit = limit_of(within)
    advance = limit.watching(advance)
    asked, chosen, warnings = asked_of(effects), source_of(campaign, source), doubled(campaign, source)
    with (
        working_on(workers, limit.check),
        threadpool_limits(1),
    ):  # matrices this small only wait for the threads of a BLAS
        if chosen != "modes":
            setup = set_up_closely(prepare(campaign, robot, hold_out, asked, trust, seed, advance))
            modes = ModesBeside(modes_of_table(campaign)) if chosen == "both" else None
            left_out = setup.observations.silent
            return _concluded(FrfData(setup, modes), limit, left_out=left_out, warnings=warnings, seed=seed)
        placed, moved = placed_on(campaign, robot)
        data = _modal(placed, robot, hold_out, asked, trust, seed, advance)
        return _concluded(data, limit, left_out=moved, warnings=warnings, seed=seed)


def _concluded(
    data: Data[M], limit: TimeLimit, *, left_out: tuple[str, ...], warnings: tuple[str, ...], seed: int
) -> Diagnosis:
    selection = ForwardSelection(data, limit)
    selection.run()
    return diagnosis_of(selection, left_out=left_out, warnings=warnings, seed=seed)


def _modal(
    campaign: Campaign,
    robot: Robot,
    hold_out: Sequence[int | str] | None,
    asked: Asked | None,
    trust: Mapping[str, float] | None,
    seed: int,
    advance: Advance,
) -> ModalData:
    check_compatible(campaign, robot)
    measured = modes_of_table(campaign)
    base = robot_space(robot, trust={**trust_of(robot, MODAL_TRUST), **(trust or {})})
    held = None
    if hold_out is not None:
        away = numbers_of(measured.postures, hold_out, seen_by="modes")
        held = np.array([mode.posture in away for mode in measured.modes])
    return ModalData(measured, robot, base, asked, held, seed, advance)
