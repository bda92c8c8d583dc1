"""A small campaign with a bending link hidden in it, and a diagnosis of it, put together by hand."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import flexmodal
from flexmodal.diagnosis.effects import Context, catalogue
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.outcome import Compared, Diagnosis, Gaps, NextMeasurement, Region, Step, Verdict
from flexmodal.diagnosis.placed import Placed
from flexmodal.identification import fit, gap, observe, predict, uncertainty, unlimited
from flexmodal.identification.gap import over_noise
from flexmodal.rig import Hide, simulate
from flexmodal.structure import robot_space

KEY = ("link_flexibility", "link_2")
NEXT = ", next level"


@cache
def known():
    """The catalogue, for which all installed packages are asked each time whether they add to it."""
    return catalogue()


def effect_of(name):
    """An effect, at its first level, its next, or one beyond that for each time that is said."""
    effect = known()[name.partition(NEXT)[0]]
    for _ in range(name.count(NEXT)):
        effect = effect.next_level.effect
    return effect


@pytest.fixture(scope="module")
def one_loop():
    """The same loop over the steps from the first call on: both agree but for rounding."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("flexmodal.diagnosis.time_domain.integration.is_worth_it", lambda *work: True)
        yield


@pytest.fixture(scope="session")
def campaign():
    hide = replace(Hide.parse("@".join(KEY)), height=10.0)
    return simulate(
        flexmodal.load("fanuc_s360_rigid_link"), hide=[hide], postures=2, points=3, references=2, trials=4,
        seed=1, record_length=2.0, band=(2.0, 150.0),
    ).campaign  # fmt: skip


@pytest.fixture(scope="session")
def observed(campaign):
    return observe(campaign)


@pytest.fixture(scope="session")
def context(observed):
    return Context.of(flexmodal.load("fanuc_s360_rigid_link"), observed)


@pytest.fixture(scope="module", params=["fanuc_s360", "six_axis"])
def either_context(request):
    """Of a robot in a plane and of one in space, in one posture."""
    robot = flexmodal.load(request.param)
    posture = {"fanuc_s360": "configuration_1", "six_axis": "work"}[request.param]
    made = simulate(robot, postures=[posture], points=2, trials=2, averages=2, seed=3, record_length=1.0)
    return Context.of(robot, observe(made.campaign))


@pytest.fixture(scope="session")
def hinged(context, observed):
    """The robot with the hinge, fitted: hypothesis and fit, and the re-tuned robot before it."""
    root = Hypothesis(context, robot_space(context.robot))
    before = fit(root, observed, stride=4)
    placed = Placed(catalogue()[KEY[0]], KEY[1])
    hypothesis = root.and_also(placed)
    start = hypothesis.start(placed, {"stiffness": 8e5, "position": 0.55}, np.zeros(len(root.space)))
    after = fit(hypothesis, observed, start, stride=4, floors=(0.2, 0.05, 0.01))
    return root, before, hypothesis, after


def diagnosis_of(
    context, observations, stages, hypothesis, made, *, steps=(), verdict=None, measurement=None, **more
):
    """A diagnosis from models that are fitted already; `stages` are predictions by name."""
    size = {name: gap(observations, value) for name, value in stages.items()}
    gaps = Gaps(
        size["before"].value,
        size["after"].value,
        None,
        None,
        size["after"].noise_floor,
        size["believed"].value,
    )
    region = Region(
        posture=observations.postures[0].id, response=(1, 3), reference=(1, 3), trial=1, band=(36.0, 52.0),
        share=0.4, kind="missing resonance", says="Posture 1 resonates at 44 Hz; the model does not.",
    )  # fmt: skip
    return Diagnosis(
        campaign=observations.campaign.title,
        robot=context.robot.name,
        gaps=gaps,
        disagreement=(region,),
        remaining=(),
        steps=tuple(steps),
        verdict=verdict or Verdict((), True, "Nothing is missing."),
        next_measurement=measurement,
        untestable=more.pop("untestable", {}),
        left_out=more.pop("left_out", ()),
        held_out=more.pop("held_out", ()),
        model=hypothesis,
        x=made.x,
        deviation=uncertainty(hypothesis.space, made.normal, observations).deviation,
        frfs=observations,
        predicted=stages,
        over_noise=over_noise(observations, stages["after"]),
        provenance=more.pop("provenance", {"flexmodal": "0.1.0", "seed": "1"}),
    )


@pytest.fixture(scope="session")
def diagnosed(context, observed, hinged):
    """One effect found, one alternative tied with it."""
    root, before, hypothesis, after = hinged
    stages = {
        "believed": predict(root, np.zeros(len(root.space)), observed),
        "before": predict(root, before.x, observed),
        "after": predict(hypothesis, after.x, observed),
    }
    (placed,) = hypothesis.placed
    values = hypothesis.values_of(placed, hypothesis.space.values(after.x))
    own = {name: values[name] for name in ("stiffness", "damping", "position")}
    sizes = {name: gap(observed, value) for name, value in stages.items()}
    step = Step(
        *KEY, own, {"stiffness": "N·m/rad", "damping": "N·m·s/rad", "position": ""}, {"stiffness": 2e4},
        0.93, Gaps(sizes["before"].value, sizes["after"].value, 0.1, 0.05, sizes["after"].noise_floor),
        (
            Compared("local_absorber", "link_2", 0.06, 0.07, -3.1, 0.05, 6),
            Compared("unstructured_mode", "everywhere", 0.07, None, -5.0, 0.02, 9),
            Compared("none", "", sizes["before"].value, 0.1, -80.0, 0.0, 0),
        ),
        ties=(("local_absorber", "link_2"),),
    )  # fmt: skip
    measurement = NextMeasurement(
        {"q1": 1.2, "q2": 0.3, "q3": 0.0},
        (3, 3),
        (2, 3),
        ("@".join(KEY), "local_absorber@link_2"),
        4.2,
        240.0,
    )
    return diagnosis_of(
        context, observed, stages, hypothesis, after, steps=[step], measurement=measurement,
        verdict=Verdict((KEY,), True, "Link 2 bends."),
        untestable={"coulomb_friction": "one level of force only"},
    )  # fmt: skip


@pytest.fixture(scope="module")
def softly_struck():
    """FRFs of the S-360 in two postures at two levels of force, as if records lasted until all is still."""
    campaign = simulate(
        flexmodal.load("fanuc_s360"), postures=2, points=2, references=1, trials=4, averages=2, seed=5,
        band=(2.0, 60.0), record_length=2.0,
    ).campaign  # fmt: skip
    return unlimited(observe(campaign))
