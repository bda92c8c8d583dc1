"""How places are put together, on ports whose misfits are given."""

from dataclasses import replace
from unittest.mock import Mock, patch

import numpy as np
import pytest

from flexmodal.diagnosis.effects import Context
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.lawfree import afresh as afresh_module
from flexmodal.diagnosis.lawfree.afresh import Again
from flexmodal.diagnosis.lawfree.joint_ports import COUPLING, JOINT
from flexmodal.diagnosis.lawfree.kinds import TORQUE
from flexmodal.diagnosis.lawfree.link_ports import LINK
from flexmodal.diagnosis.lawfree.look import Field
from flexmodal.diagnosis.lawfree.port import Port, PortKind, Wider
from flexmodal.diagnosis.lawfree.profile import Profile, State
from flexmodal.diagnosis.lawfree.pursuit import alone, pursued
from flexmodal.diagnosis.lawfree.reading_ports import SENSOR
from flexmodal.diagnosis.lawfree.sighting import Round, Sighting
from flexmodal.diagnosis.time_limit import OutOfTime

PROFILE, STATE = object.__new__(Profile), object.__new__(State)
"""Of no port at all; nobody looks at them here."""


class Given(Field):
    """A field in which the misfit of every set of ports is known."""

    bare = 10.0

    def __init__(self, ports, misfits):
        object.__setattr__(self, "ports", ports)
        object.__setattr__(self, "misfits", misfits)

    def sighted(self, ports, before=None):
        every = (*(before.ports if before else ()), *ports)
        misfit = self.misfits.get(frozenset(one.where for one in every), 9.0)
        return Sighting(every, misfit, None, sum(len(one.names) for one in every), PROFILE, STATE)

    def round(self, before=None, ports=None, advance=lambda part: None):
        taken = {one.key for one in before.ports} if before else set()
        tried = [one for one in (self.ports if ports is None else ports) if one.key not in taken]
        found = [self.sighted((one,), before) for one in tried]
        return Round(tuple(sorted(found, key=lambda one: one.judged)))


PAIR = Port(COUPLING, "q1+q2", ("first", "between", "second"))
ONE, OTHER = (Port(JOINT, name, ("stiffness",)) for name in ("q1", "q2"))


def test_a_coupling_and_both_of_its_joints_stay_three():
    """No port that can do less is left for the coupling then."""
    field = Given((PAIR, ONE, OTHER), {
        frozenset({"q1+q2"}): 6.0, frozenset({"q1+q2", "q1"}): 3.0, frozenset({"q1+q2", "q1", "q2"}): 0.7,
    })  # fmt: skip
    found = pursued(field, alone(field))
    assert {one.where for one in found.whole.ports} == {"q1+q2", "q1", "q2"}
    assert found.explains
    assert {one.port.where: one.without for one in found.members}["q2"] == 3.0


def test_a_joint_stands_for_a_coupling_that_is_no_better():
    """The coupling came first, and a joint of it does as well once the other place is known."""
    field = Given((PAIR, ONE, OTHER), {
        frozenset({"q1+q2"}): 3.0, frozenset({"q1+q2", "q2"}): 0.7, frozenset({"q1", "q2"}): 0.75,
    })  # fmt: skip
    found = pursued(field, alone(field))
    assert {one.where for one in found.whole.ports} == {"q1", "q2"}


THREE = {
    frozenset({"q1"}): 6.0, frozenset({"q1", "q2"}): 3.0, frozenset({"q1", "q2", "q1+q2"}): 0.7,
}  # fmt: skip
"""Of the first, of the first and the second, and of all three."""


class Counted(Given):
    """Time may be up in a round; every fit is counted."""

    def __init__(self, rounds=99):
        super().__init__((ONE, OTHER, PAIR), THREE)
        object.__setattr__(self, "fitted", [])
        object.__setattr__(self, "left", [rounds])

    def round(self, before=None, ports=None, advance=lambda part: None):
        self.left[0] -= 1
        if self.left[0] < 0:
            raise OutOfTime
        there = tuple(one.where for one in before.ports) if before else ()
        self.fitted.extend((there, one.where) for one in ports or ())
        return super().round(before, ports, advance)


def test_what_was_fitted_in_the_stead_of_a_port_is_fitted_once():
    field = Counted()
    found = pursued(field, alone(field))
    assert [one.where for one in found.whole.ports] == ["q1", "q2", "q1+q2"]
    assert len(field.fitted) == len(set(field.fitted))
    assert (("q1", "q1+q2"), "q2") in field.fitted


@pytest.mark.parametrize(
    ("rounds", "where"),
    [
        (1, ["q1"]),
        (2, ["q1", "q2"]),
        (3, ["q1", "q2"]),
        (4, ["q1", "q2", "q1+q2"]),
        (6, ["q1", "q2", "q1+q2"]),
    ],
)
def test_those_found_by_then_stand_where_time_is_up(rounds, where):
    """What was a rival when each was found still is one, and each has the misfit from before it."""
    field = Counted(rounds)
    found = pursued(field, first := alone(field))
    assert [one.where for one in found.whole.ports] == where
    assert [one.port.where for one in found.members] == where
    assert (found is first) == (rounds == 1)
    assert found.explains == (len(where) == 3)
    if rounds < 6:
        assert [one.without for one in found.members] == [10.0, 6.0, 3.0][: len(where)]
        assert all(one.alike == (one.port,) for one in found.members)


class Screened(Given):
    """Ports go on as they come, rare ones among them; what is asked for is kept."""

    round = Field.round

    def __init__(self, placed, best, ports=(ONE,), torques=(), firsts=(10.0, 1.0)):
        super().__init__(ports, {frozenset({"q1"}): best, frozenset({"q1+q2"}): 5.5})
        root = Mock(spec=Hypothesis, placed=placed, context=Mock(spec=Context))
        rest = {
            "rare": (PAIR,),
            "torques": torques,
            "root": root,
            "asked": [],
            "brought": [],
            "firsts": firsts,
        }
        for name, value in rest.items():
            object.__setattr__(self, name, value)

    def sighted(self, ports, before=None, start=None, *, patient=False, roughly=False):
        return super().sighted(ports, before)

    def ended(self, one):
        self.brought.append(one.port)
        return one

    def _screened(self, ports, before, advance):
        self.asked.extend(ports)
        return [(port, None, self.firsts[port is PAIR]) for port in ports]


@pytest.mark.parametrize(
    ("placed", "best", "tried"),
    [((), 3.3, False), ((), 3.4, True), (("an effect",), 7.0, False), (("an effect",), 7.3, True)],
)
def test_rare_ports_are_tried_where_no_other_leads_on(placed, best, tried):
    """Of 10 without any a port leads on that takes two thirds, beside effects three tenths."""
    field = Screened(placed, best)
    field.round()
    assert (PAIR in field.asked) is tried


@pytest.mark.parametrize(
    ("placed", "best", "ended"),
    [
        ((), 1.5, [ONE]),
        ((), 4.6, [ONE, OTHER]),
        ((), 5.1, []),
        (("an effect",), 3.0, [ONE]),
        (("an effect",), 3.3, []),
    ],
)
def test_those_near_the_best_are_brought_to_their_ends(placed, best, ended):
    """The other one leaves 9 of 10; none where several are missing."""
    field = Screened(placed, best, ports=(ONE, OTHER))
    field.round()
    assert field.brought == ended


@pytest.mark.parametrize(
    ("placed", "best", "again"),
    [
        ((), 0.9, 0),
        ((), 4.9, 2),
        ((), 5.1, 0),
        (("an effect",), 3.0, 1),
        (("an effect",), 3.5, 0),
        (("an effect",), 0.9, 0),
    ],
)
def test_what_leaves_too_much_is_not_fitted_once_more(placed, best, again):
    """Where one place would not be enough, patience is not rewarded: alone where it leaves half of 10."""
    field = Screened(placed, best)
    with patch.object(Again, "_one", side_effect=lambda one: one) as afresh:
        field.round()
    assert afresh.call_count == again


@pytest.mark.parametrize(("placed", "again"), [((), 2), (("an effect",), 1)])
def test_a_link_is_not_fitted_once_more_beside_effects(placed, again):
    """With its many hinges it takes most of a look's time and gains nothing; what is next to it is."""
    field = Screened(placed, 3.0, ports=(Port(LINK, "q1", ("bending",)), OTHER))
    object.__setattr__(field, "misfits", {frozenset({"q1"}): 3.0, frozenset({"q2"}): 3.1})
    with patch.object(Again, "_one", side_effect=lambda one: one) as afresh:
        field.round()
    assert afresh.call_count == again


@pytest.mark.parametrize(("improved", "again"), [(3.0, 2), (1.9, 1)])
def test_the_second_is_fitted_once_more_where_it_is_near_the_first_that_was(improved, again):
    """The first one leaves 4, and then so much; the second leaves 5."""
    first, better, second = (
        Sighting((port,), misfit, None, 1, PROFILE, STATE)
        for port, misfit in ((ONE, 4.0), (ONE, improved), (OTHER, 5.0))
    )
    with patch.object(Again, "_one", side_effect=[better, second]) as afresh:
        found = Again(Mock(spec=Field.sighted), Mock(spec=Context), None, 10.0).better([second, first])
    assert afresh.call_count == again
    assert [one.judged for one in found] == [improved, 5.0]


@pytest.mark.parametrize(
    ("functions", "left", "place", "tried"),
    [
        (1, 12.0, "q1", True),
        (1, 12.0, "joints", False),
        (4, 12.0, "q1", True),
        (5, 12.0, "q1", False),
        (1, 9.0, "q1", False),
        (1, 0.9, "q1", False),
    ],
)
def test_where_more_is_missing_only_a_port_of_few_functions_is_widened(functions, left, place, tried):
    """Up to 10 it is fitted once more as a whole; at 1 nothing is missing; the wider one sits at q1."""
    wide = Port(replace(LINK, name="wide", wider=()), "q1", tuple("abcdefgh"))
    kind = replace(
        LINK,
        name="narrow",
        wider=(Mock(spec=Wider, kind=Mock(spec=PortKind, places=lambda context: ("q1",))),),
    )
    narrow = Sighting((Port(kind, place, tuple("abcdefgh"[:functions])),), left, None, 1, PROFILE, STATE)
    better = Sighting((wide,), 0.7, None, 3, PROFILE, STATE)
    fits = Mock(spec=Field.sighted, return_value=better)
    begins = Mock(return_value=(wide, (np.zeros(1), np.zeros((1, 8, 1)))))
    with (
        patch.object(afresh_module, "widened", begins),
        patch.object(Again, "_one", side_effect=lambda one: one),
    ):
        found = Again(fits, Mock(spec=Context), None, 10.0).better([narrow])
    assert (found == [better]) is tried
    assert fits.called is tried


@pytest.mark.parametrize(("rare", "found"), [(9.9, True), (10.1, False)])
def test_a_rare_port_goes_on_where_it_did_better_than_the_others(rare, found):
    """After the first round, whose best of the others is 10."""
    field = Screened((), 7.0, firsts=(10.0, rare))
    assert (PAIR in [one.port for one in field.round().sightings]) is found


@pytest.mark.parametrize(
    ("placed", "left", "tried"), [((), 1.0, False), ((), 2.0, True), (("an effect",), 1.0, True)]
)
def test_where_a_torque_explains_everything_only_readings_are_tried_beside_it(placed, left, tried):
    """What changes with the force of the blow no linear port explains, but a reading may."""
    kind = replace(TORQUE, wider=())
    torque, reading = Port(kind, "q1", ("torque",)), Port(SENSOR, "point_1", ("gain",))
    field = Screened(placed, left, ports=(ONE, reading), torques=(torque,))
    field.round()
    assert reading in field.asked
    assert (ONE in field.asked) is tried


def test_progress_is_told_for_every_port_that_is_tried():
    """A time that is up is noticed then."""
    told = []
    Screened((), 0.7).round(ports=(ONE, PAIR), advance=told.append)
    assert told == [0.5, 1.0]
    told.clear()
    Screened((), 0.7, torques=(Port(TORQUE, "q2", ("torque",)),)).round(advance=told.append)
    assert told == [0.2, 1.0]
