"""The problem of an identification: campaign, robot, parameters, and the data they are to meet."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool

from flexmodal.campaign import Campaign
from flexmodal.errors import Fault, InvalidRequest
from flexmodal.identification.compatibility import check_compatible
from flexmodal.identification.evidence.both import Both
from flexmodal.identification.evidence.evidence import Evidence
from flexmodal.identification.evidence.frf import FrfEvidence
from flexmodal.identification.evidence.modal import MODEL_ERROR, USES, ModalEvidence
from flexmodal.identification.evidence.mode_sources import modes_of_frfs, modes_of_table
from flexmodal.identification.identifiability import Identifiability
from flexmodal.identification.model import RobotModel
from flexmodal.identification.observations import Observations, observe
from flexmodal.identification.setting_up import far_words
from flexmodal.identification.source import Source, doubled, source_of
from flexmodal.identification.tolerance import as_set_up
from flexmodal.model import Robot
from flexmodal.structure.parameter import ParameterSpace
from flexmodal.structure.space import robot_space
from flexmodal.text.words import listing, nearest

OSCILLATING = 0.5
"""Damping ratio up to which a mode makes a peak."""


BARE = (
    "neither repeats nor coherence say how noisy the FRFs are: "
    "it is taken from how neighbouring lines disagree"
)
"""What is said of FRFs that come alone."""


@dataclass(frozen=True, eq=False)
class IdentificationProblem:
    """What is to be found, and from what."""

    campaign: Campaign
    robot: Robot
    space: ParameterSpace
    source: Source
    evidence: Evidence
    """The data that are fitted."""
    whole: Evidence
    """The same with what is held out."""
    held_out: tuple[tuple[str, str], ...] = ()
    """Kind and name of what the fit never sees."""
    warnings: tuple[str, ...] = ()
    """What was taken for granted that may not be so."""

    @property
    def what(self) -> str:
        """The data in words."""
        return self.evidence.what

    @property
    def bare(self) -> bool:
        """Whether nothing but neighbouring lines says how noisy the FRFs are."""
        return BARE in self.warnings

    @property
    def postures(self) -> tuple[str, ...]:
        """Names of the postures with data, those that are held out too."""
        return tuple(name for kind, name in self.whole.folds() if kind == "posture")

    @cached_property
    def identifiability(self) -> Identifiability:
        """What these data can tell, computed at the card."""
        return Identifiability(self.space, self.evidence.information(), self.what)


def build_identification(
    campaign: Campaign,
    robot: Robot,
    *,
    source: Source | None = None,
    space: ParameterSpace | None = None,
    trust: Mapping[str, float] | None = None,
    hold_out: Sequence[str | int] = (),
    use: Sequence[str] | None = None,
    model_error: float = MODEL_ERROR,
) -> IdentificationProblem:
    """Set up an identification.

    Args:
        campaign: what was measured.
        robot: as its card says.
        source: "frf", "modes" or "both"; by default both where there are FRFs and a `modes.csv`, else what
            there is. Modes come from `modes.csv`, else from fits of the FRFs.
        space: parameters; stiffness, damping, mass and inertia of the robot if None.
        trust: standard deviations of ln(true / card) by kind or name, over the card's.
        hold_out: names or ids of postures, or names of points, that the fit is not to see.
        use: what of the modes: frequency, damping, shape, residue, antiresonance; if None frequency and
            damping, with residues where FRFs are fitted. Shapes of a table are as good as whoever made it.
        model_error: relative error of natural frequencies that the model is granted, tenfold of all else of
            modes; without it a few frequencies that are known very well would decide everything.

    Raises:
        InvalidRequest: campaign and robot do not belong together, the data are too few or nothing but noise,
            or an argument is out of its range.
        SingularResponse, InaccurateModes: as the FRFs of the robot.
    """
    check_compatible(campaign, robot)
    if not 0 <= model_error < 1:
        raise InvalidRequest(Fault("call", "model_error", f"{model_error:g}", "0 to 1"))
    warnings, source = doubled(campaign, source), source_of(campaign, source)
    if use is not None and source == "frf":
        found = f"{', '.join(use)} of modes, while FRFs are fitted"
        raise InvalidRequest(Fault("call", "use", found, "none, or modes as the source"))
    chosen = robot_space(robot, trust=trust) if space is None else space.trusting(dict(trust or {}))
    model = RobotModel(robot, chosen)
    whole: Evidence
    if source != "modes":
        frfs, more = _of_frfs(campaign, model, hold_out)
        warnings = (*warnings, *more)
    if source == "frf":
        whole = frfs
    else:
        whole = _of_modes(campaign, model, use, model_error)
        if source == "both":
            whole = Both(frfs, whole)
    held = _held_out(campaign, whole, hold_out)
    evidence = whole
    if held:
        folds = whole.folds()
        evidence = whole.keeping(~np.any([folds[key] for key in held], axis=0))
    if faults := evidence.faults():
        raise InvalidRequest(faults)
    return IdentificationProblem(campaign, robot, chosen, source, evidence, whole, held, warnings)


def _of_modes(
    campaign: Campaign, model: RobotModel, use: Sequence[str] | None, model_error: float
) -> ModalEvidence:
    """Modes of the table, or of fits that begin at the card's own frequencies."""
    tabled = campaign.modes is not None and "antiresonance" not in (use or ())
    chosen = _uses(use or ("frequency", "damping", *(() if tabled else ("residue",))))
    if tabled:
        return ModalEvidence(model, modes_of_table(campaign), chosen, model_error)
    near = {}
    for posture in campaign.postures:
        modes = model.robot.at(dict(posture.q)).modes()
        near[posture.id] = modes.frequency[modes.damping_ratio < OSCILLATING].tolist()
    found = modes_of_frfs(campaign, near, antiresonances="antiresonance" in chosen)
    return ModalEvidence(model, found, chosen, model_error)


def _uses(use: Sequence[str]) -> tuple[str, ...]:
    unknown = [name for name in use if name not in USES]
    if unknown or not use:
        found = ", ".join(map(repr, unknown)) or "nothing"
        raise InvalidRequest(Fault("call", "use", found, f"some of {', '.join(USES)}"))
    return tuple(use)


def _of_frfs(
    campaign: Campaign, model: RobotModel, hold_out: Sequence[str | int]
) -> tuple[FrfEvidence, tuple[str, ...]]:
    """FRFs as they were most likely set up, and what has to be said of them."""
    seen = observe(campaign, bare=True)
    there = as_set_up(seen, model.robot, model.space, _away(seen, hold_out))
    warnings = (BARE,) if seen.by_lines else ()
    return FrfEvidence(model, there.observations), (*warnings, *far_words(there.found))


def _away(seen: Observations, wanted: Sequence[str | int]) -> Bool[np.ndarray, " observation"]:
    """What nothing is moved by: observations in postures and of points that are held out."""
    names = {str(one) for one in wanted}
    postures = np.array([bool({one.name, str(one.id)} & names) for one in seen.postures])
    points = [point.id for point in seen.campaign.points if point.name in names]
    return postures[seen.posture] | np.isin(seen.response[:, 0], points)


def _held_out(
    campaign: Campaign, whole: Evidence, wanted: Sequence[str | int]
) -> tuple[tuple[str, str], ...]:
    folds = whole.folds()
    ids = {str(posture.id): posture.name for posture in campaign.postures}
    found: list[tuple[str, str]] = []
    faults = []
    for item in wanted:
        name = ids.get(str(item), str(item))
        key = next((k for k in (("posture", name), ("point", name)) if k in folds), None)
        if key is None:
            names = [n for _, n in folds]
            allowed = f"{nearest(str(item), names)}a posture or point with data: {listing(names)}"
            faults.append(Fault("call", "hold_out", repr(item), allowed))
        elif key not in found:
            found.append(key)
    postures = {name for kind, name in folds if kind == "posture"}
    if postures and postures <= {name for kind, name in found if kind == "posture"}:
        faults.append(Fault("call", "hold_out", "every posture", "at least one posture to fit"))
    if faults:
        raise InvalidRequest(faults)
    return tuple(found)
