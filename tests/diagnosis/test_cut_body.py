"""How the body of a link that bends is shared out between its hinges."""

import numpy as np
import pytest

import flexmodal
from flexmodal.diagnosis.effects import link_flexibility
from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.cut_body import SPREAD, TUBE, cut
from flexmodal.diagnosis.effects.effect import Placement, along
from flexmodal.identification import observe
from flexmodal.rig import simulate
from flexmodal.structure.arm import Body

PLACES = np.array([0.1, 0.45, 0.8])


@pytest.fixture(scope="module", params=["fanuc_s360", "six_axis"])
def context(request):
    posture = {"fanuc_s360": "configuration_1", "six_axis": "work"}[request.param]
    made = simulate(
        flexmodal.load(request.param), postures=[posture], points=2, trials=2, averages=2, record_length=1.0
    )
    return Context.of(flexmodal.load(request.param), observe(made.campaign))


def placed(context, **values):
    link = next(link for link in context.links if along(context, link)[0] > 0.1)
    return Placement.still(context, link, values)


def about(lever):
    return lever @ lever * np.eye(3) - np.outer(lever, lever)


def bodies(context, link):
    """With mass centres in the middle, off the axis, near an end and beyond it."""
    length, axis = along(context, link)
    random = np.random.default_rng(0)
    for place in (0.5, 0.2, 0.95, 1.2):
        masses, levers = random.uniform(0.5, 2, 12), random.normal(size=(12, 3)) * 0.2 * length
        levers += place * length * axis
        mass = masses.sum()
        centre = masses @ levers / mass
        yield Body(mass, centre, sum(m * about(r - centre) for m, r in zip(masses, levers, strict=True)))


@pytest.mark.parametrize("values", [{}, {TUBE: 0.3, SPREAD: 0.2}])
def test_mass_centre_and_inertia_of_the_link_stay(context, values):
    placement = placed(context, **values)
    for body in bodies(context, placement.where):
        parts, whole = cut(placement, body, PLACES)
        masses = np.array([part.body.mass for part in parts])
        assert (masses > 0).all()
        assert masses.sum() == pytest.approx(body.mass)
        centre = sum(part.body.mass * part.body.centre for part in parts) / body.mass
        assert centre == pytest.approx(body.centre, abs=1e-9)
        rods = sum(p.body.inertia + p.body.mass * about(p.body.centre - centre) for p in parts)
        assert rods == pytest.approx(whole, abs=1e-9)
        assert sum(part.turning for part in parts) == pytest.approx(1.0)
        assert min(part.turning for part in parts) > 0


def test_what_the_rods_lack_is_an_inertia_that_a_body_can_have(context):
    """Else a mass matrix would not be positive definite."""
    placement = placed(context)
    turn = np.eye(3) if context.normal is None else context.axes(placement.where).T @ context.normal[:, None]
    for body in bodies(context, placement.where):
        _, whole = cut(placement, body, PLACES)
        left = turn.T @ (body.inertia - whole) @ turn
        assert np.linalg.eigvalsh(left)[0] >= -1e-9 * np.trace(body.inertia)


def test_an_even_tube_is_cut_by_length(context):
    placement = placed(context)
    length, axis = along(context, placement.where)
    thin = np.eye(3) - np.outer(axis, axis)
    disc = 1e-3 * length**2 * np.eye(3)
    body = Body(7.0, length / 2 * axis, 7.0 * length**2 / 12 * thin + disc)
    parts, _ = cut(placement, body, PLACES)
    masses = np.array([part.body.mass for part in parts])
    assert masses / 7.0 == pytest.approx(np.diff([0.0, *PLACES, 1.0]), abs=0.01)


def test_a_lump_at_an_end_moves_with_that_end(context):
    placement = placed(context)
    length, axis = along(context, placement.where)
    body = Body(7.0, 0.95 * length * axis, 1e-3 * length**2 * np.eye(3))
    parts, _ = cut(placement, body, PLACES)
    assert parts[-1].body.mass > 0.9 * 7.0


def test_a_link_that_stands_across_the_plane_does_not_bend(context, monkeypatch):
    link = placed(context).where
    assert link in link_flexibility.EFFECT.places(context)
    if context.normal is not None:
        upright = context.axes(link).T @ context.normal
        others = along
        monkeypatch.setattr(
            link_flexibility,
            "along",
            lambda context, one: (1.0, upright) if one == link else others(context, one),
        )
        assert link not in link_flexibility.EFFECT.places(context)


def test_between_two_hinges_in_one_place_there_is_nothing(context):
    """Where a wider law moves hinges they may meet; it had ended in a division by nothing."""
    placement = placed(context)
    for body in bodies(context, placement.where):
        parts, whole = cut(placement, body, np.array([0.1, 0.45, 0.45, 0.8]))
        expected, other = cut(placement, body, PLACES)
        assert (parts[2].body.mass, parts[2].turning) == (0.0, 0.0)
        assert not parts[2].body.inertia.any()
        for one, same in zip([*parts[:2], *parts[3:]], expected, strict=True):
            assert one.body.mass == pytest.approx(same.body.mass)
            assert one.body.centre == pytest.approx(same.body.centre)
        assert whole == pytest.approx(other, abs=1e-12)
