"""Whether what makes an effect is there at all."""

from unittest.mock import Mock

import numpy as np
import pytest

from flexmodal.campaign import Campaign, Tolerance
from flexmodal.diagnosis.effects import catalogue
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.placed import Placed
from flexmodal.diagnosis.selection import frf_data
from flexmodal.diagnosis.selection.decision import Answer
from flexmodal.diagnosis.selection.frf_candidates import FrfCandidates
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.diagnosis.selection.frf_data import FrfData
from flexmodal.diagnosis.setup import Setup
from flexmodal.structure import robot_space


@pytest.mark.parametrize(("together", "expected"), [(-1.0, Answer.YES), (0.0, Answer.NO)])
def test_a_damper_between_two_joints_is_a_coupling_however_little_its_spring_is_known(
    context, together, expected
):
    """A spring of 0.05 ± 0.04 with a time that is known to 80 %: their product is known, or it is not."""
    placed = Placed(catalogue()["joint_coupling"], "q1+q3")
    hypothesis = Hypothesis(context, robot_space(context.robot)).and_also(placed)
    start = {"coupling": 0.05, "damping_time": 1e-2}
    x = hypothesis.start(placed, start, np.zeros(len(hypothesis.base)))
    spring, time, idler = (
        hypothesis.space.index[f"joint_coupling@q1+q3.{name}"]
        for name in ("coupling", "damping_time", "inertia")
    )
    covariance = np.zeros((len(x), len(x)))
    covariance[spring, spring], covariance[time, time], covariance[idler, idler] = 0.04**2, 0.8**2, 9.0
    covariance[spring, time] = covariance[time, spring] = together * 0.04 * 0.8
    data = FrfData.__new__(FrfData)
    data.covariance = lambda model: covariance
    model = Mock(spec=FittedFrfs, hypothesis=hypothesis, x=x)
    assert data._is_there(model, [placed.key]) is expected
    assert data._is_there(model, [("added_mass", "link_2")]) is Answer.YES


def test_an_idler_alone_is_no_coupling(context):
    """It swings by a spring between the joints: where there is none it is something else that resounds."""
    bare = Hypothesis(context, robot_space(context.robot))
    placed = Placed(catalogue()["joint_coupling"], "q1+q3")
    hypothesis = bare.and_also(placed)
    x = hypothesis.start(placed, {"coupling": 0.0, "inertia": 1.0}, np.zeros(len(bare.space)))
    data = FrfData.__new__(FrfData)
    data.covariance = lambda model: np.eye(len(model.x)) * 1e-6
    assert data._is_there(Mock(spec=FittedFrfs, hypothesis=hypothesis, x=x), [placed.key]) is Answer.NO


def test_a_mass_is_needed_beside_a_coupling_that_is_none(monkeypatch, context):
    """Which was added last does not matter, but what one model has and the other has not."""
    mass = Placed(catalogue()["added_mass"], "link_2")
    coupling = Placed(catalogue()["joint_coupling"], "q1+q3")
    bare = Hypothesis(context, robot_space(context.robot))
    both = bare.and_also(mass).and_also(coupling)
    before = np.zeros(len(bare.and_also(mass).space))
    start = both.start(coupling, {"coupling": 0.0, "damping_time": 1e-2}, before)
    data = FrfData.__new__(FrfData)
    data.covariance = lambda model: np.eye(len(model.x))
    data.setup = Mock(spec=Setup)
    monkeypatch.setattr(frf_data, "over_noise", lambda setup, model: 5.0)
    data.campaign = Mock(spec=Campaign, tolerance=Mock(spec=Tolerance, is_exact=True))

    def fitted(hypothesis, cost):
        x = start if hypothesis is both else np.zeros(len(hypothesis.space))
        return Mock(spec=FittedFrfs, hypothesis=hypothesis, x=x, costs=np.array([cost]), prior=0.0)

    whole = fitted(both, 1.0)
    assert data.worth(fitted(bare.and_also(coupling), 50.0), whole, 1) is Answer.YES
    assert data.worth(fitted(bare.and_also(mass), 50.0), whole, 1) is Answer.NO


def test_what_re_tunes_a_joint_is_not_compared_with_what_is_missing(context):
    """Its evidence may be the best, and it would keep all others from being added."""
    bare = Hypothesis(context, robot_space(context.robot))
    data = FrfData.__new__(FrfData)

    def covariance(model):
        loose = [name.endswith((".damping_time", ".inertia")) for name in model.hypothesis.space.names]
        return np.diag(np.where(loose, 25.0, 1e-4))

    data.covariance = covariance

    def fitted(effect, where, values):
        hypothesis = bare.and_also(Placed(catalogue()[effect], where))
        x = hypothesis.start(hypothesis.placed[-1], values, np.zeros(len(bare.space)))
        return Mock(spec=FittedFrfs, hypothesis=hypothesis, x=x, key=(effect, where))

    none = fitted("joint_coupling", "q1+q2", {"coupling": 0.0, "damping_time": 1e-9})
    some = fitted("joint_coupling", "q2+q3", {"coupling": 0.2})
    mass = fitted("added_mass", "link_2", {})
    assert data._that_are([none, some, mass]) == [some, mass]


@pytest.fixture
def coupled(context):
    """A robot with two coupled joints whose parameters are some standard deviations off, by name."""
    hypothesis = Hypothesis(context, robot_space(context.robot))
    hypothesis = hypothesis.and_also(Placed(catalogue()["joint_coupling"], "q1+q3"))
    space = hypothesis.space

    def made(**off):
        x = np.zeros(len(space))
        for name, deviations in off.items():
            k = space.index[name.replace("__", ".")]
            x[k] = deviations / np.sqrt(space.precision[k])
        prior = float(np.sum(space.precision * x**2))
        return Mock(spec=FittedFrfs, hypothesis=hypothesis, x=x, prior=prior, costs=np.array([1.0]))

    return made


@pytest.mark.parametrize(
    ("off", "tried"),
    [
        ({"mass__link_2": 4.0, "inertia__link_2": -4.0}, ["added_mass"]),
        ({"mass__link_2": 2.0, "inertia__link_2": -2.0}, []),
        ({"stiffness__q1": 4.0, "stiffness__q2": -4.0}, []),
        ({"mass__link_2": 4.0, "stiffness__q1": 9.0}, []),
        ({"damping__q1": -5.0, "damping__q2": -5.0}, ["structural_damping"]),
        ({"damping__q1": -9.0, "mass__link_2": 5.0}, ["structural_damping"]),
    ],
    ids=[
        "links beyond belief",
        "links off",
        "springs beyond belief",
        "springs more so",
        "damping",
        "damping more so",
    ],
)
def test_what_the_card_took_over_is_looked_for_where_it_is_beyond_belief(monkeypatch, coupled, off, tried):
    """At the noise nothing points to it."""
    before, more = coupled(**off), Mock(spec=FittedFrfs)
    found, asked = looked_besides(monkeypatch, before, more)
    assert found == ([before, more] if tried else [])
    assert asked == {name: ["link_1", "link_2"] for name in tried}


def looked_besides(monkeypatch, before, more):
    """What is found besides, and the effects that were tried, each with its places of two links."""
    data, asked = FrfData.__new__(FrfData), {}

    def searched(before, number, allowed):
        every = ((name, link) for name in catalogue() for link in ("link_1", "link_2"))
        for name, link in every:
            if allowed(name, link):
                asked.setdefault(name, []).append(link)
        return [more]

    data.setup, data.asked = Mock(spec=Setup, effects=tuple(catalogue().values())), None
    candidates = FrfCandidates.__new__(FrfCandidates)
    candidates.setup, candidates.searched = data.setup, searched
    data._candidates = candidates
    monkeypatch.setattr(frf_data, "over_noise", lambda setup, model: 1.0)
    return data.besides(before, 1), asked


def test_of_what_is_attached_to_a_link_a_mass_is_a_part(monkeypatch, coupled):
    """Links beyond belief speak for a mass, but not where an absorber is already."""
    before = coupled(mass__link_2=4.0, inertia__link_2=-4.0)
    before.hypothesis = Mock(space=before.hypothesis.space, keys=(("local_absorber", "link_2"),))
    _, asked = looked_besides(monkeypatch, before, Mock(spec=FittedFrfs))
    assert asked == {"added_mass": ["link_1"]}


@pytest.mark.parametrize(("over", "expected"), [(1.05, Answer.YES), (1.6, Answer.NO)])
def test_what_brings_the_card_back_is_worth_it_where_nothing_else_is_missing(
    monkeypatch, coupled, over, expected
):
    """Where more is, parameters are beyond belief for its sake."""
    data = FrfData.__new__(FrfData)
    data.setup, data.modes = Mock(spec=Setup), None
    data.campaign = Mock(spec=Campaign, tolerance=Mock(spec=Tolerance, is_exact=True))
    monkeypatch.setattr(frf_data, "over_noise", lambda setup, model: over)
    before, after = coupled(mass__link_2=6.0), coupled(mass__link_2=1.0)
    assert data.worth(before, after, 1) is expected
    assert data.worth(before, after, 0) is Answer.YES
