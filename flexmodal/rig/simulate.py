"""A campaign on a robot that only exists here, with effects hidden in it."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from flexmodal.campaign import Blow, Campaign
from flexmodal.errors import Fault, InvalidRequest, OutputExists
from flexmodal.model import Robot
from flexmodal.rig.believed import ParameterError, true_robot
from flexmodal.rig.bench import Conduct, Struck, each_posture, peaks
from flexmodal.rig.effects import EFFECTS, Site, Stand
from flexmodal.rig.plan import Plan, make_plan
from flexmodal.rig.robot_folder import CARD, write_robot
from flexmodal.rig.severity import Floor, noise_floor, severity_for
from flexmodal.rig.structure import Hidden
from flexmodal.rig.truth import HiddenEffect, Truth, truth_path

_NEAR = 0.2
"""Relative distance from the height asked for at which a place will do."""
_MOST_PLACES = 4
"""Places tried for an effect that may choose where it sits."""


@dataclass(frozen=True)
class Hide:
    """An effect to hide."""

    effect: str
    where: str = ""
    """Where; drawn from the seed if empty."""
    parameters: Mapping[str, float] = field(default_factory=dict)
    """Some or all of its parameters; the others are drawn from the seed."""
    severity: float = 1.0
    """Multiple of those parameters, in the sense of `Effect.scaled`."""
    height: float | None = None
    """How many times the noise floor it is to stand; then the severity is searched for."""

    @classmethod
    def parse(cls, text: str | Hide, *, source: str = "call") -> Hide:
        """Read "EFFECT", "EFFECT@WHERE" or "EFFECT@WHERE,parameter=value,…"."""
        if isinstance(text, Hide):
            return text
        head, *rest = (part.strip() for part in text.split(","))
        name, _, where = head.partition("@")
        parameters, faults = {}, []
        for part in rest:
            key, equals, value = part.partition("=")
            try:
                parameters[key.strip()] = float(value)
            except ValueError:
                equals = ""
            if not equals:
                faults.append(Fault(source, "hide", repr(part), "parameter=value"))
        if faults:
            raise InvalidRequest(faults)
        return cls(name.strip(), where.strip(), parameters)


@dataclass(frozen=True, eq=False)
class RigResult:
    """A simulated campaign and what is behind it."""

    campaign: Campaign
    truth: Truth
    robot: Robot
    """As the tester believes it to be."""
    plan: Plan
    stand: Stand
    hidden: tuple[Hidden, ...]

    def write(self, folder: str | Path, *, binary: bool = True) -> Path:
        """Write the campaign to a new folder and the truth beside it.

        Returns:
            Where the truth is.

        Raises:
            OutputExists: the folder or the file of the truth is there already; nothing is written.
        """
        from flexmodal.campaign import write_campaign

        target = Path(folder)
        refuse_existing(target)
        scratch = Path(tempfile.mkdtemp(dir=target.parent, prefix=f".{target.name}."))
        try:
            inside = scratch / target.name
            write_campaign(self.campaign, inside, binary=binary)
            write_robot(self.robot, inside, self.plan.postures, self.plan.points)
            self.truth.write(truth_path(target))
            inside.rename(target)
        finally:
            shutil.rmtree(scratch, ignore_errors=True)
        return truth_path(target)


def refuse_existing(folder: Path) -> None:
    """Complain where a campaign would land on something.

    Raises:
        OutputExists: folder or truth exist, or the folder they belong in does not.
    """
    faults = [
        Fault(str(path), "", "something that exists", "a new name")
        for path in (folder, truth_path(folder))
        if path.exists() or path.is_symlink()
    ]
    if not folder.parent.is_dir():
        faults.append(Fault(str(folder.parent), "", "no such folder", "an existing folder to put it in"))
    if faults:
        raise OutputExists(faults)


def simulate(
    robot: Robot,
    *,
    postures: int | Sequence[str | Mapping[str, float]] = 7,
    points: int | None = None,
    references: int | Sequence[str] = 2,
    axes: str | None = None,
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
    advance: Callable[[], None] = lambda: None,
) -> RigResult:
    """Simulate a hammer test in the time domain.

    Args:
        robot: as the tester believes it to be; the true one is drawn around it.
        postures: how many, or which; a number takes the card's named postures, then random ones.
        points: how many of the card's points carry the sensor; all if None.
        references: how many hammer positions, or which, as "name:+z".
        axes: world directions the sensor measures, such as "xz"; the vertical for a planar chain, else xyz.
        trials: kinds of blows; they go through `peaks` in turn, the second time as repeats.
        averages: blows in each FRF.
        peaks: typical peaks of the blows [N].
        tip: soft, medium or hard.
        band: lines of interest [Hz]; the sampling rate is 2.56 times its end.
        record_length: [s].
        hide: effects, as "EFFECT@WHERE" or `Hide`.
        noise: standard deviation of each channel's noise over the root mean square of its record.
        scatter: multiple of the usual scatter of the blows in peak, place and direction.
        parameter_error: how far the true robot is off the card, as standard deviation of a logarithm.
        seed: of everything drawn.
        advance: called once for each posture and point.

    Raises:
        InvalidRequest, InvalidPosture: an argument out of its range, an unknown effect or place.
    """
    _check_numbers(noise, scatter, parameter_error, seed)
    plan = make_plan(
        robot, postures=postures, points=points, references=references, axes=axes, trials=trials,
        averages=averages, peaks=peaks, tip=tip, band=band, record_length=record_length,
        random=np.random.default_rng([seed, 3]),
    )  # fmt: skip
    error = (
        parameter_error
        if isinstance(parameter_error, ParameterError)
        else ParameterError.all(parameter_error)
    )
    stand = make_stand(robot, plan, error, seed)
    conduct = Conduct(noise, scatter, seed)
    hidden, effects, floor = _hidden(stand, [Hide.parse(text) for text in hide], conduct)
    blows: list[Blow] = []
    for posture, struck in each_posture(stand, hidden, conduct, advance):
        blows += _blows(plan, posture.id, struck)
    truth = Truth(robot.name, seed, noise, scatter, floor, effects, stand.true.factors)
    return RigResult(_campaign(robot, plan, blows), truth, robot, plan, stand, tuple(hidden))


def _check_numbers(noise: float, scatter: float, error: float | ParameterError, seed: int) -> None:
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
    if faults:
        raise InvalidRequest(faults)


def make_stand(robot: Robot, plan: Plan, error: ParameterError, seed: int) -> Stand:
    """The true robot, and how far it moves when it is struck."""
    true = true_robot(robot, error, np.random.default_rng([seed, 4]))
    bare = Stand(robot, true, plan, {}, {})
    found = [peaks(bare, posture) for posture in plan.postures]
    weak, hard = (choose(trial.force_peak for trial in plan.trials) for choose in (min, max))
    deflection = {
        joint: tuple(float(force * np.median([d[joint] for d, _ in found])) for force in (weak, hard))
        for joint in robot.joints
    }
    acceleration = {p.name: float(hard * np.median([a[p.name] for _, a in found])) for p in plan.points}
    return Stand(robot, true, plan, deflection, acceleration)  # type: ignore[arg-type]


def _hidden(
    stand: Stand, wanted: Sequence[Hide], conduct: Conduct
) -> tuple[list[Hidden], tuple[HiddenEffect, ...], float | None]:
    """Sites of the effects, how they came out, and the noise floor where it was needed."""
    faults = [fault for item in wanted for fault in _hide_faults(stand, item)]
    names = [item.effect for item in wanted]
    if len(set(names)) < len(names):
        faults.append(Fault("call", "hide", "the same effect twice", "each effect once"))
    if faults:
        raise InvalidRequest(faults)
    searched = any(item.height is not None for item in wanted)
    if searched and conduct.noise == 0:
        allowed = "noise above 0, since heights are measured against it"
        raise InvalidRequest(Fault("call", "hide", "a height over the noise floor, without noise", allowed))
    floor = noise_floor(stand, conduct) if searched else None
    hidden, effects = [], []
    for number, item in enumerate(wanted):
        effect = EFFECTS[item.effect]
        random = np.random.default_rng([conduct.seed, 5, number, list(EFFECTS).index(item.effect)])
        places = effect.places(stand)
        order = [_canonical(item.where, places)] if item.where else list(map(str, random.permutation(places)))
        site, severity, reached = _placed(stand, item, order, random, floor)
        where = site.where
        wrong = effect.check(site.parameters)
        if wrong:
            raise InvalidRequest(Fault("call", f"hide {item.effect}", wrong, "parameters in their range"))
        hidden.append((item.effect, site))
        effects.append(
            HiddenEffect(
                item.effect, where, dict(site.parameters), effect.units, severity, reached, effect.catalogued
            )
        )
    return hidden, tuple(effects), None if floor is None else floor.height


def _placed(
    stand: Stand, item: Hide, places: Sequence[str], random: np.random.Generator, floor: Floor | None
) -> tuple[Site, float, float | None]:
    """Site, severity and height of an effect; of several places the first where it can stand so high."""
    effect = EFFECTS[item.effect]
    tried: list[tuple[Site, float, float | None]] = []
    for where in places[:_MOST_PLACES]:
        site = Site(stand, where, {**effect.draw(stand, where, random), **item.parameters})
        severity, reached = item.severity, None
        if item.height is not None and floor is not None:
            severity, reached = severity_for(stand, item.effect, site, item.height, floor)
        if severity != 1:
            site = Site(stand, where, effect.scaled(site.parameters, severity))
        tried.append((site, severity, reached))
        if item.height is None or reached is None or abs(reached / item.height - 1) < _NEAR:
            return tried[-1]
    return min(tried, key=lambda one: abs(float(np.log((one[2] or 1e-9) / (item.height or 1.0)))))


def _canonical(where: str, places: Sequence[str]) -> str:
    """A pair of joints is the same in either order."""
    turned = "+".join(reversed(where.split("+")))
    return turned if where not in places and turned in places else where


def _hide_faults(stand: Stand, item: Hide) -> list[Fault]:
    key = f"hide {item.effect}" + (f"@{item.where}" if item.where else "")
    if item.effect not in EFFECTS:
        return [Fault("call", "hide", f"unknown effect {item.effect!r}", ", ".join(EFFECTS))]
    effect = EFFECTS[item.effect]
    places = effect.places(stand)
    faults = []
    if not places:
        faults.append(Fault("call", key, f"a robot without {effect.place_is}", "another effect"))
    elif item.where and _canonical(item.where, places) not in places:
        found = f"no place {item.where!r} for it"
        faults.append(Fault("call", key, found, f"{effect.place_is}: {', '.join(places)}"))
    for name, value in item.parameters.items():
        if name not in effect.units:
            faults.append(Fault("call", key, f"unknown parameter {name!r}", ", ".join(effect.units)))
        elif not np.isfinite(value):
            faults.append(Fault("call", key, f"{name} = {value}", "a finite number"))
    if not (np.isfinite(item.severity) and item.severity > 0):
        faults.append(Fault("call", key, f"severity {item.severity}", "a finite number above 0"))
    if item.height is not None and not (np.isfinite(item.height) and 0 < item.height <= 1000):
        faults.append(Fault("call", key, f"{item.height} times the noise floor", "above 0, at most 1000"))
    return faults


def _blows(plan: Plan, posture: int, struck: Struck) -> list[Blow]:
    """One blow after the other: by trial, and in it by reference, point and average."""
    blows = []
    time = plan.analyser.time
    for t, trial in enumerate(plan.trials):
        sequence = 0
        for r, reference in enumerate(plan.references):
            for p, point in enumerate(plan.points):
                for a in range(trial.averages):
                    sequence += 1
                    blows.append(
                        Blow(
                            posture=posture,
                            trial=trial.id,
                            sequence=sequence,
                            reference=reference,
                            time=time,
                            force=struck.force[t, r, p, a],
                            channels=tuple((point.id, axis) for axis in plan.axes),
                            response=struck.response[t, r, p, a],
                            quantity="acceleration",
                        )
                    )
    return blows


def _campaign(robot: Robot, plan: Plan, blows: list[Blow]) -> Campaign:
    from dataclasses import replace

    from flexmodal.campaign import estimate_frfs

    campaign = Campaign(
        title=f"{robot.title}: simulated hammer test",
        robot=CARD,
        band=plan.band,
        postures=plan.postures,
        points=plan.points,
        trials=plan.trials,
        blows=tuple(blows),
    )
    frfs = estimate_frfs(campaign, estimator="H1")
    return replace(campaign, frfs=frfs)
