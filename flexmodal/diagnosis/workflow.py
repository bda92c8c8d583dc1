"""The workflow: re-tune, compare, hypothesise, weigh, add, and again, until nothing significant is left."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool
from threadpoolctl import threadpool_limits

from flexmodal.campaign import Campaign
from flexmodal.diagnosis.compare import disagreement, excess, force_dependence
from flexmodal.diagnosis.effects import Effect, Scene, catalogue
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.march.model import has_law
from flexmodal.diagnosis.modes.workflow import diagnose_modes, is_modal
from flexmodal.diagnosis.next_measurement import next_measurement
from flexmodal.diagnosis.outcome import (
    UNKNOWN,
    Diagnosis,
    Gaps,
    NextMeasurement,
    Step,
    Verdict,
    Weighed,
)
from flexmodal.diagnosis.provenance import provenance
from flexmodal.diagnosis.refine import refined
from flexmodal.diagnosis.search import (
    CLOSE,
    COARSE,
    Candidate,
    candidates,
    look_at,
    narrowed,
    polished,
    some_lines,
    unlimited,
)
from flexmodal.diagnosis.weigh import Scales, Weighable, weigh, weighable
from flexmodal.errors import Fault, InvalidRequest
from flexmodal.identification import (
    FrfFit,
    Observations,
    ParameterSpace,
    fit,
    gap,
    observe,
    predict,
    robot_space,
    uncertainty,
)
from flexmodal.identification.frf_fit import residual
from flexmodal.identification.truncation import missing
from flexmodal.model import Robot

TRUST = {"stiffness": 0.08, "damping": 0.08, "mass": 0.08, "inertia": 0.08}
"""Standard deviation of ln(true / card) in re-tuning, unless the card or the user says other."""
MOST_STEPS = 2
"""Effects added at most: more of them explain anything."""
FINALISTS = 4
"""Candidates that are fitted closely and weighed."""
MARCHED = 3
"""The same for effects that depend on force, whose torques are marched in time."""
FORCE = 1.5
"""Change of FRFs with the force of the blow, over their noise, from which a structure is not linear."""
SIGNIFICANT = 8.0
"""Score that an effect has to gain, in 19 of 20 draws of the bootstrap [nat]."""
WORTH = 0.03
"""Part of the sum of squares that it has to take away besides."""
ANOTHER = 0.35
"""The same for every further effect: what a good but not perfect model leaves is not another effect."""
WORST = 0.05
"""Part of the observations, the worst, that do not count in it."""
FLOOR_REACHED = 1.2
"""Gap over noise floor that needs no explanation."""
EXPLAINED = 1.6
"""Gap over noise floor that a perfect model may show."""
LEFT = 0.12
"""Part of the disagreement above the noise that may be left between the two."""
TIE = 0.05
"""Probability from which another explanation counts as tied with the best."""

_FEWEST = 3
"""Postures from which on some are held out."""

Advance = Callable[[str, float], None]


@dataclass(frozen=True, eq=False)
class _Bench:
    """What a diagnosis works with."""

    scene: Scene
    base: ParameterSpace
    observations: Observations
    fitted: Observations
    """Without the postures held out."""
    held: Bool[np.ndarray, " observation"]
    effects: tuple[Effect, ...]
    seed: int
    advance: Advance


def diagnose(
    campaign: Campaign,
    robot: Robot,
    *,
    hold_out: Sequence[int | str] | None = None,
    effects: Sequence[str] | None = None,
    trust: Mapping[str, float] | None = None,
    seed: int = 0,
    advance: Advance = lambda doing, part: None,
) -> Diagnosis:
    """Find what is missing between a robot and a campaign of hammer tests on it.

    Args:
        campaign: with FRFs, or blows to estimate them from; with modes alone they are diagnosed (`modes`).
        robot: as it is believed to be.
        hold_out: postures (ids or names) that no weighed fit sees. By default one in four, at least one,
            those on which the re-tuned robot is neither best nor worst; with fewer than three postures none.
        effects: names from the catalogue; all by default.
        trust: standard deviation of ln(true / card) by kind or parameter name.
        seed: of the bootstrap.
        advance: called with what is being done and the part of it that is done.

    Raises:
        InvalidRequest: no data, unknown effects or postures, a campaign that does not belong to the robot.
    """
    if is_modal(campaign):
        return diagnose_modes(
            campaign, robot, hold_out=hold_out, effects=effects, trust=trust, seed=seed, advance=advance
        )
    with threadpool_limits(1):  # matrices this small only wait for the threads of a BLAS
        return _diagnose(campaign, robot, hold_out, effects, trust, seed, advance)


def _diagnose(
    campaign: Campaign,
    robot: Robot,
    hold_out: Sequence[int | str] | None,
    effects: Sequence[str] | None,
    trust: Mapping[str, float] | None,
    seed: int,
    advance: Advance,
) -> Diagnosis:
    observations = observe(campaign)
    _belong(observations, robot)
    observations = _whole(observations, robot)
    scene = Scene(robot, observations)
    known = catalogue(effects)
    base = robot_space(robot, trust={**_trust_of(robot), **(trust or {})})
    held = _held(observations, hold_out) if hold_out is not None else _middling(scene, base)
    bench = _Bench(
        scene,
        base,
        observations,
        observations.keeping(~held),
        held,
        tuple(known.values()),
        seed,
        advance,
    )
    return _Course(bench).run()


class _Course:
    """One run of the workflow; keeps what it has found so far."""

    def __init__(self, bench: _Bench) -> None:
        self.bench = bench
        advance = bench.advance
        advance("re-tuning the robot", 0.0)
        root = Hypothesis(bench.scene, bench.base)
        zero = np.zeros(len(bench.base))
        self.believed = predict(root, zero, bench.observations)
        self.root, self.current = root, self._look(root, self._fit(root, zero, bench.fitted))
        self.before = self.current
        self.steps: list[Step] = []
        self.runner_up: Weighable | None = None
        self.force_matters = force_dependence(bench.observations) > FORCE

    def run(self) -> Diagnosis:
        """Add effects until nothing significant is left."""
        for number in range(MOST_STEPS):
            if number and self._over(self.current) <= FLOOR_REACHED:
                break
            step = self._step(number)
            if step is None:
                break
        self._still_needed()
        return self._conclude()

    # one step

    def _step(self, number: int) -> Step | None:
        bench, before = self.bench, self.current
        doing = f"looking for {'an effect' if not number else 'another effect'}"
        bench.advance(doing, 0.0)
        at_card = np.zeros(len(bench.base))
        starts = at_card if not number else before.fitted.x
        look = look_at(bench.fitted)
        loud = [effect for effect in bench.effects if "blow" in effect.variants]
        quiet = [effect for effect in bench.effects if "blow" not in effect.variants]
        finalists: list[Candidate] = []
        for some, most in ((quiet, FINALISTS), (loud if self.force_matters else [], MARCHED)):
            found = candidates(before.hypothesis, starts, some, look)
            best_of = narrowed(found, look, lambda part: bench.advance(doing, 0.7 * part))
            finalists += best_of[:most]
        fits = [(one.hypothesis, polished(one, bench.fitted)) for one in finalists]
        fits.sort(key=lambda one: one[1].normal.cost)
        looked = [before]
        for place, (hypothesis, fitted) in enumerate(fits):
            looked.append(self._look(hypothesis, fitted, marched=has_law(hypothesis)))
            bench.advance(doing, 0.7 + 0.3 * (place + 1) / len(fits))
        scales = weigh(looked, bench.observations, bench.seed)
        best = int(np.argmax(scales.scores))
        worth = 1 - looked[best].costs.sum() / max(before.costs.sum(), 1e-300)
        if best == 0 or scales.gain < SIGNIFICANT or worth < (ANOTHER if number else WORTH):
            return None
        self.current = looked[best]
        step = self._describe(looked, scales, best, before)
        self.steps.append(step)
        order = np.argsort(-scales.scores)
        second = [int(k) for k in order if k not in (0, best)]
        self.runner_up = looked[second[0]] if step.ties and second else None
        return step

    def _describe(self, looked: Sequence[Weighable], scales: Scales, best: int, before: Weighable) -> Step:
        bench, chosen = self.bench, looked[best]
        placed = chosen.hypothesis.placed[-1]
        alternatives = tuple(
            Weighed(
                effect=looked[k].key[0] if k else "none",
                where=looked[k].key[1] if k else "",
                gap=self._gap(looked[k], ~bench.held),
                held_out_gap=self._gap(looked[k], bench.held) if bench.held.any() else None,
                evidence=float(scales.scores[k]),
                confidence=float(scales.probability[k]),
                parameters=len(looked[k].hypothesis.space) - len(before.hypothesis.space),
            )
            for k in np.argsort(-scales.scores).tolist()
            if k != best
        )
        ties = tuple((one.effect, one.where) for one in alternatives if one.confidence >= TIE)
        parameters, units, errors = self._parameters(chosen, placed.key)
        return Step(
            effect=placed.effect.name,
            where=placed.where,
            parameters=parameters,
            units=units,
            uncertainty=errors,
            confidence=float(scales.probability[best]),
            gaps=self._gaps(before, chosen),
            alternatives=alternatives,
            ties=ties,
        )

    def _parameters(
        self, one: Weighable, key: tuple[str, str]
    ) -> tuple[dict[str, float], dict[str, str], dict[str, float]]:
        """Physical parameters of an effect, their units and standard errors, by finite differences."""
        space, x = one.hypothesis.space, one.fitted.x
        placed = next(p for p in one.hypothesis.placed if p.key == key)
        sure = uncertainty(space, one.fitted.normal, self.bench.fitted)

        def physical(at: np.ndarray) -> dict[str, float]:
            values = one.hypothesis.values_of(placed, space.values(at))
            own = {p.name for p in placed.effect.parameters(self.bench.scene, placed.where)}
            found = placed.effect.physical(self.bench.scene, placed.where, values)
            return {k: v for k, v in found.items() if k in own or "." not in k}

        here = physical(x)
        slopes = np.zeros((len(here), len(x)))
        for k in range(len(x)):
            if space.names[k].startswith(f"{placed.label}.") or "." in space.names[k]:
                moved = x.copy()
                moved[k] += 1e-5
                slopes[:, k] = (np.array(list(physical(moved).values())) - list(here.values())) / 1e-5
        errors = np.sqrt(np.maximum(np.einsum("pi,ij,pj->p", slopes, sure.covariance, slopes), 0.0))
        units = {p.name: p.unit for p in placed.effect.parameters(self.bench.scene, placed.where)}
        units = {name: placed.effect.units.get(name, units.get(name, "")) for name in here}
        return here, units, dict(zip(here, errors.tolist(), strict=True))

    # fits

    def _fit(self, hypothesis: Hypothesis, start: np.ndarray, observations: Observations) -> FrfFit:
        return fit(hypothesis, observations, start, lines=some_lines(observations, CLOSE), steps=25)

    def _look(
        self,
        hypothesis: Hypothesis,
        fitted: FrfFit,
        *,
        marched: bool = False,
        fitted_to: Observations | None = None,
    ) -> Weighable:
        """A fit seen from all postures; its non-linear torques marched in time where that is asked for."""
        observations = self.bench.observations
        if not marched:
            return weighable(hypothesis, fitted, observations)
        close = refined(hypothesis, fitted, self.bench.fitted if fitted_to is None else fitted_to)
        return weighable(hypothesis, close.fitted, observations, predict(close.model, close.x, observations))

    def _still_needed(self) -> None:
        """Leave out every effect but the last in turn; those that nobody misses go."""
        for step in list(self.steps[:-1]):
            key = (step.effect, step.where)
            without = self.current.hypothesis.without(key)
            kept = [
                float(v)
                for name, v in zip(self.current.hypothesis.space.names, self.current.fitted.x, strict=True)
                if not name.startswith(f"{step.effect}@{step.where}.")
            ]
            fitted = self._fit(without, np.array(kept), self.bench.fitted)
            less = self._look(without, fitted, marched=has_law(without))
            scales = weigh([less, self.current], self.bench.observations, self.bench.seed)
            if scales.gain < SIGNIFICANT:
                self.current = less
                self.steps.remove(step)

    # figures

    def _gap(self, one: Weighable, keep: Bool[np.ndarray, " observation"]) -> float:
        return gap(self.bench.observations, one.predicted, keep).value

    def _gaps(self, before: Weighable, after: Weighable, believed: float | None = None) -> Gaps:
        bench = self.bench
        held = bench.held if bench.held.any() else None
        every = np.ones(len(bench.observations), dtype=bool)
        return Gaps(
            before=self._gap(before, every),
            after=self._gap(after, every),
            held_out_before=None if held is None else self._gap(before, held),
            held_out_after=None if held is None else self._gap(after, held),
            noise_floor=gap(bench.observations, after.predicted).noise_floor,
            believed=believed,
        )

    def _over(self, one: Weighable) -> float:
        """Gap over noise floor, without the few observations that are worst.

        Where a point hardly moves along its axis, a hammer's tilt of a fraction of a degree counts for more
        than noise.
        """
        observations = self.bench.observations
        each = np.where(observations.used, np.abs(residual(one.predicted, observations.value)) ** 2, 0.0)
        ratio = each.sum(axis=1) / np.maximum((observations.variance * observations.used).sum(axis=1), 1e-300)
        keep = ratio <= np.quantile(ratio, 1 - WORST)
        return gap(observations, one.predicted, keep).over_floor

    def _left(self, one: Weighable) -> float:
        """Part of the disagreement above the noise, before, that is left."""
        every = self.bench.observations
        floor = gap(every, one.predicted).noise_floor
        first, last = gap(every, self.before.predicted).value, gap(every, one.predicted).value
        return max(last**2 - floor**2, 0.0) / max(first**2 - floor**2, 1e-300)

    # the end

    def _conclude(self) -> Diagnosis:
        bench = self.bench
        bench.advance("fitting everything once more", 0.0)
        held_pair = self._gaps(self.before, self.current)
        final = self.current
        if bench.held.any():
            marched = has_law(final.hypothesis)
            refit = (
                final.fitted if marched else self._fit(final.hypothesis, final.fitted.x, bench.observations)
            )
            final = self._look(final.hypothesis, refit, marched=marched, fitted_to=bench.observations)
            tuned = self._fit(self.root, self.before.fitted.x, bench.observations)
            before = self._look(self.root, tuned)
        else:
            before = self.before
        over = self._over(final)
        explained = over <= FLOOR_REACHED or (over <= EXPLAINED and self._left(final) <= LEFT)
        if self.force_matters and not has_blow(final.hypothesis):
            explained = False  # nothing linear changes with the force
        everything = gap(bench.observations, self.believed)
        gaps = replace(
            self._gaps(before, final, everything.value),
            held_out_before=held_pair.held_out_before,
            held_out_after=held_pair.held_out_after,
        )
        verdict = self._verdict(explained, final, over)
        sure = uncertainty(final.hypothesis.space, final.fitted.normal, bench.observations)
        bench.advance("what to measure next", 0.5)
        return Diagnosis(
            campaign=bench.observations.campaign.title,
            robot=bench.scene.robot.name,
            gaps=gaps,
            disagreement=disagreement(bench.observations, before.predicted),
            remaining=disagreement(bench.observations, final.predicted),
            steps=tuple(self.steps) if explained else (),
            verdict=verdict,
            next_measurement=self._next(final),
            untestable={
                effect.name: why for effect in bench.effects if (why := effect.untestable(bench.scene))
            },
            left_out=bench.observations.silent,
            held_out=tuple(
                bench.observations.postures[int(k)].id
                for k in np.unique(bench.observations.posture[bench.held])
            ),
            model=final.hypothesis,
            x=final.fitted.x,
            deviation=sure.deviation,
            observations=bench.observations,
            predicted={"believed": self.believed, "before": before.predicted, "after": final.predicted},
            provenance=provenance(bench.observations.campaign, bench.scene.robot, bench.seed),
        )

    def _next(self, final: Weighable) -> NextMeasurement | None:
        if self.runner_up is None:
            return None
        return next_measurement(
            self.bench.scene,
            (final.hypothesis, final.fitted.x),
            (self.runner_up.hypothesis, self.runner_up.fitted.x),
        )

    def _verdict(self, explained: bool, final: Weighable, over: float) -> Verdict:
        effects = tuple((step.effect, step.where) for step in self.steps)
        if explained and not effects:
            return Verdict(
                (), True, f"Nothing is missing: re-tuned, the robot's gap is {over:.2f} × the noise floor."
            )
        if explained:
            words = " and ".join(f"{self._says(step.effect)} ({step.where})" for step in self.steps)
            tied = [f"{e} at {w}" for step in self.steps for e, w in step.ties]
            tail = f" These data cannot tell it from {', '.join(tied)}." if tied else ""
            return Verdict(
                effects, True, f"Missing: {words}.{tail} The gap falls to {over:.2f} × the noise floor."
            )
        where = self._place(final)
        near = f" Nearest comes {effects[-1][0]} at {effects[-1][1]}, which is not enough." if effects else ""
        says = (
            "Something is missing that nothing in the catalogue explains: the gap stays at "
            f"{over:.1f} × the noise floor. Look at {where}.{near}"
        )
        return Verdict(((UNKNOWN, where),), False, says)

    def _says(self, name: str) -> str:
        return next(effect.says for effect in self.bench.effects if effect.name == name)

    def _place(self, final: Weighable) -> str:
        """Where an unexplained disagreement sits best: the place of what comes nearest, or the worst."""
        if final.hypothesis.placed:
            return final.hypothesis.keys[-1][1]
        observations = self.bench.observations
        above = excess(observations, final.predicted).sum(axis=1)
        points = np.unique(observations.response[:, 0])
        share = [above[observations.response[:, 0] == p].sum() for p in points]
        return observations.campaign.point(int(points[int(np.argmax(share))])).name


def has_blow(hypothesis: Hypothesis) -> bool:
    """Whether one of its effects depends on the blow."""
    return any("blow" in placed.effect.variants for placed in hypothesis.placed)


def _trust_of(robot: Robot) -> dict[str, float]:
    """The workflow's own trust where the card gives none."""
    found = dict(TRUST)
    for name, joint in robot.joints.items():
        if joint.scale is not None:
            found[f"stiffness.{name}"] = joint.scale
            if joint.damping > 0:
                found[f"damping.{name}"] = joint.scale
    return found


def _belong(observations: Observations, robot: Robot) -> None:
    """Whether the campaign is one of this robot.

    Raises:
        InvalidRequest: links, joints or postures that the robot does not have; all at once.
    """
    campaign = observations.campaign
    source = str(campaign.path or "campaign")
    links = {link.name for link in robot.urdf.links}
    faults = [
        Fault(source, f"point {p.name}", f"link {p.link!r}", f"a link of {robot.name}: {', '.join(links)}")
        for p in campaign.points
        if p.link not in links
    ]
    for posture in campaign.postures:
        try:
            robot.posture(dict(posture.q), source=source)
        except InvalidRequest as error:
            faults += error.faults
        except ValueError as error:
            faults += getattr(error, "faults", ())
    if faults:
        raise InvalidRequest(faults)


def _whole(observations: Observations, robot: Robot) -> Observations:
    """The observations, without the length of their records where the robot comes to rest within it."""
    root = Hypothesis(Scene(robot, observations), robot_space(robot))
    for group in root.groups(np.zeros(len(root.space)), observations, slopes=False):
        axis = observations.axis_of(group.level)
        if axis.length > 0 and missing(group.structure, axis, group.pairs[:1]) is not None:
            return replace(observations, cut_slopes=False)  # steps need not be exact, and are much faster so
    return unlimited(observations)


def _middling(scene: Scene, base: ParameterSpace) -> Bool[np.ndarray, " observation"]:
    """Observations of the postures in the middle, by how far the re-tuned robot is from each.

    A posture that alone shows the effect must not be held out, nor one that does not show it at all.
    """
    observations = scene.observations
    count = len(observations.postures)
    if count < _FEWEST:
        return np.zeros(len(observations), dtype=bool)
    root = Hypothesis(scene, base)
    lines = some_lines(observations, COARSE)
    tuned = fit(root, observations, floors=(0.2, 0.05), steps=10, lines=lines, apart=False)
    value = predict(root, tuned.x, observations)
    far = [gap(observations, value, observations.posture == k).value for k in range(count)]
    order = np.argsort(np.nan_to_num(far), kind="stable")
    number = max(1, count // 4)
    first = (count - number) // 2
    return np.isin(observations.posture, order[first : first + number])


def _held(observations: Observations, wanted: Sequence[int | str]) -> Bool[np.ndarray, " observation"]:
    """Observations of the postures that are held out."""
    names = {p.name: k for k, p in enumerate(observations.postures)}
    ids = {p.id: k for k, p in enumerate(observations.postures)}
    count = len(observations.postures)
    faults, numbers = [], []
    for one in wanted:
        k = names.get(str(one), ids.get(int(one)) if str(one).isdigit() else None)
        if k is None:
            allowed = ", ".join(p.name for p in observations.postures)
            faults.append(Fault("call", "hold_out", repr(one), f"a posture with FRFs: {allowed}"))
        else:
            numbers.append(k)
    if len(set(numbers)) >= count and not faults:
        faults.append(Fault("call", "hold_out", "every posture", "one left to fit at least"))
    if faults:
        raise InvalidRequest(faults)
    return np.isin(observations.posture, numbers)
