"""Which ports go on after the first round, and what that round sees of the data."""

from dataclasses import replace
from unittest.mock import MagicMock, Mock

import numpy as np

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.lawfree import screening
from flexmodal.diagnosis.lawfree.kinds import KINDS
from flexmodal.diagnosis.lawfree.port import Port
from flexmodal.diagnosis.lawfree.profile import Profile, State
from flexmodal.diagnosis.lawfree.screening import FRFS, LINES, kept, on_all, thinned
from flexmodal.identification import Observations

BY_NAME = {kind.name: kind for kind in KINDS}


def ports(*misfits):
    """Joints with these misfits, the best first."""
    return [(misfit, Port(BY_NAME["joint"], f"q{number}")) for number, misfit in enumerate(misfits)]


def test_what_is_far_behind_does_not_go_on_but_a_second_one():
    assert len(kept(ports(0.1, 5.0, 5.0, 5.0))) == 2
    assert len(kept(ports(0.5, 1.0, 3.0, 4.0, 4.5, 4.9, 4.9))) == 6  # while no more than six are near
    assert len(kept(ports(*np.linspace(0.5, 0.6, 30)))) == 20  # all that explain everything alike


def test_the_best_of_a_kind_goes_on_from_farther_behind():
    link = (10.0, Port(BY_NAME["link"], "link_2"))
    assert kept([*ports(1.0, 1.1, 1.2, 1.3, 1.4, 1.5), link])[-1] is link[1]
    far = (100.0, link[1])
    assert link[1] not in kept([*ports(1.0, 1.1, 1.2, 1.3, 1.4, 1.5), far])


def test_where_no_place_explains_everything_fewer_kinds_go_on():
    """With several effects each port is far from the truth, and all of them are alike in that."""
    best = screening.EXPLAINED * 2
    near, far = ((k * best, Port(BY_NAME["link"], "link_2")) for k in (1.9, 2.1))
    others = ports(*np.linspace(best, 1.1 * best, screening.MOST_KEPT))
    assert near[1] in kept([*others, near])
    assert far[1] not in kept([*others, far])
    reading = far[0], Port(BY_NAME["sensor"], "point_1")
    assert reading[1] in kept([*others, reading])  # they take little time


def test_where_no_port_gains_only_the_fewest_go_on():
    alike = ports(*np.linspace(0.5, 0.6, 30))
    assert len(kept(alike, 0.5 * screening.NOTHING_GAINED * 0.99)) == screening.FEWEST
    assert len(kept(alike, 0.5 * screening.NOTHING_GAINED * 1.01)) == screening.MOST_ALIKE


def test_so_many_ports_at_most_and_the_best_of_each_kind_are_near(monkeypatch):
    monkeypatch.setattr(screening, "misfit_of", lambda one: one[1].cost)
    repaired = []
    monkeypatch.setattr(screening, "mended", lambda *fit: repaired.append(fit) or fit)
    every = [*ports(*np.linspace(1.0, 1.5, 50)), (3.0, Port(BY_NAME["link"], "link_2"))]
    begins = [(port, (Mock(spec=Profile), Mock(spec=State, cost=misfit))) for misfit, port in every]
    found = [port for port, _ in screening.near(begins)]
    assert found == [port for _, port in [*every[: screening.MOST_NEAR], every[-1]]]
    assert len(repaired) == screening.UNMENDED * screening.MOST_NEAR + 1


def test_lines_are_repaired_before_a_port_is_given_up(monkeypatch):
    """But for ports that are so far behind that no repair brings them back."""
    far, to = 1.5 * screening.HOPELESS, 0.5

    def fit(misfit):
        return Mock(spec=Profile), Mock(spec=State, cost=misfit)

    monkeypatch.setattr(screening, "misfit_of", lambda one: one[1].cost)

    def repaired(profile, state):
        return fit(state.cost * (to if state.cost == far else 1))

    monkeypatch.setattr(screening, "mended", repaired)
    first, stuck, lost = (port for _, port in ports(1.0, far, 2 * far))
    link = Port(BY_NAME["link"], "link_2")
    begins = [(lost, fit(2 * far)), (stuck, fit(far)), (first, fit(1.0)), (link, fit(3 * far))]
    found = screening.near(begins)
    assert [port for port, _ in found] == [first, stuck, link]  # the last as the best of its kind
    assert [state.cost for _, (_, state) in found] == [1.0, far / 2, 3 * far]
    to = 0.9
    assert [port for port, _ in screening.near(begins)] == [first, link]
    assert screening.near([]) == []


def test_where_little_is_left_only_what_takes_a_part_of_it_goes_on(monkeypatch):
    """Of 2 without any port the best leaves 1; the best of a kind has to take its part too."""

    def fit(misfit):
        return Mock(spec=Profile), Mock(spec=State, cost=misfit)

    monkeypatch.setattr(screening, "misfit_of", lambda one: one[1].cost)
    monkeypatch.setattr(screening, "mended", lambda profile, state: (profile, state))
    (_, first), (_, second), (_, third) = ports(1.0, 1.6, 1.8)
    link = Port(BY_NAME["link"], "link_2")
    begins = [(first, fit(1.0)), (second, fit(1.6)), (third, fit(1.8)), (link, fit(1.9))]
    assert [port for port, _ in screening.near(begins, 2.0)] == [first, second]
    assert len(screening.near(begins)) == 4
    assert [port for port, _ in screening.near([begins[0], *begins[2:]], 2.0)] == [first, third]


def test_only_those_whose_geometry_matters_and_that_do_best_are_placed_again(monkeypatch):
    def fit(misfit):
        return Mock(spec=Profile), Mock(spec=State, cost=misfit)

    monkeypatch.setattr(screening, "misfit_of", lambda one: one[1].cost)
    rod = replace(BY_NAME["coupling"], geometries=lambda context, where: ({"crank": 1.0},))
    rods = [Port(rod, f"q{number}+q9") for number in range(screening.WELL_PLACED + 1)]
    begins = [(ports(1.0)[0][1], fit(1.0)), *((port, fit(9.0 - k)) for k, port in enumerate(rods))]
    again = fit(0.5)
    found = screening.with_places(begins, Mock(spec=Context), lambda port: again)
    assert found == [*begins[:2], *((port, again) for port in rods[1:])]


def test_functions_on_some_lines_are_straight_between_them():
    every = np.arange(9) * (1.0 - 0.5j)
    assert LINES == 2
    np.testing.assert_allclose(on_all(every[None, None, ::LINES], 9)[0, 0], every)
    np.testing.assert_allclose(on_all(every[None, None, :8:LINES], 8)[0, 0], [*every[:7], every[6]])


def test_so_many_frfs_of_every_posture_and_always_the_same():
    observed = MagicMock(spec=Observations, posture=np.repeat([0, 1, 2], [90, 50, 10]))
    observed.__len__.return_value = 150
    observed.keeping.return_value = observed
    thinned(observed)
    thinned(observed)
    first, second = (call.args[0] for call in observed.keeping.call_args_list)
    assert (first == second).all()
    assert [int(first[observed.posture == number].sum()) for number in range(3)] == [30, 17, 4]
    assert FRFS <= first.sum() < 2 * FRFS
    few = MagicMock(spec=Observations)
    few.__len__.return_value = FRFS + 1
    assert thinned(few) is few
