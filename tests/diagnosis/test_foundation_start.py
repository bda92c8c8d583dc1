"""Foundations laid beside free compliances, which are put together by hand."""

import numpy as np
import pytest

from flexmodal.diagnosis.effects import base_flexibility, foundation
from flexmodal.diagnosis.effects.effect import Placement
from flexmodal.diagnosis.effects.foundation_law import FoundationLaw
from flexmodal.diagnosis.effects.free_function import FreeFunction
from flexmodal.structure import ParameterSpace
from flexmodal.structure.assembly import Assembly

EFFECT = base_flexibility.EFFECT
UP = np.array([0.0, 0.0, 1.0])


@pytest.fixture(scope="module")
def context(either_context):
    return either_context


def compliance(context, frequency, springs, dampers, centre, mass, inertia, mass_centre):
    """(K + iωB − ω²M)⁻¹ of springs that meet in a point, and of a body, by Newton's laws at the root."""
    _, motion = foundation.motions(context.normal)

    def at(place):  # [6, way], by what a turn does to a lever
        return np.concatenate([motion[:3] + np.cross(motion[3:].T, place).T, motion[3:]])

    def about(place, sizes):
        ways = motion.T @ at(place)
        return ways.T @ np.diag(sizes) @ ways

    turns = motion[3:].any(axis=0)
    omega = 2 * np.pi * frequency[:, None, None]
    stiffness, damping = about(centre, springs), about(centre, dampers)
    body = about(mass_centre, np.where(turns, inertia, mass))
    return np.linalg.inv(stiffness + 1j * omega * damping - omega**2 * body)


def laid(context):
    """Foundations told by a free port, and the numbers it was made of."""
    length, mass = foundation.length_of(context), 2.0 * context.arm_mass
    tilt, shift = foundation.sizes(context)
    planar, frequency = context.normal is not None, np.linspace(2.0, 120.0, 60)
    springs = np.array([6 * shift, 25 * shift, 0.8 * tilt] if planar else
                       [6 * shift, 4 * shift, 25 * shift, 0.8 * tilt, 1.3 * tilt, 1.7 * tilt])  # fmt: skip
    dampers = 4e-4 * springs
    side = foundation.motions(context.normal)[1][:3, 0] if planar else np.array([1.0, 0.0, 0.0])
    aside, below, low, beside = 0.06 * length, 0.1 * length, 0.05 * length, 0.02 * length
    radius = 0.2 * length
    found = compliance(
        context, frequency, springs, dampers, aside * side - below * UP,
        mass, mass * radius**2, (aside + beside) * side - low * UP,
    )  # fmt: skip
    pairs = np.array(foundation.every_term(context)).T
    value, own = found[:, pairs[0], pairs[1]].T, np.abs(np.einsum("lii->li", found)).T
    size = 0.01 * np.sqrt(own[pairs[0]] * own[pairs[1]])
    size[0] *= 10  # how the root moves along was hardly seen
    value = value + size * np.random.default_rng(1).normal(size=value.shape)
    weight = 1 / size.T
    information = np.einsum("lf,fg->lfg", weight**2, np.eye(len(value)))
    free = FreeFunction(frequency, value, {}, np.zeros(0), information.astype(complex))
    truth = {
        "horizontal_stiffness": springs[0], "vertical_stiffness": springs[1 if planar else 2],
        "below": below, "aside": aside, "mass": mass, "gyration": radius,
    }  # fmt: skip
    return free, truth


@pytest.mark.slow
def test_a_foundation_is_found_beside_the_compliances_that_are_its_own(context):
    free, truth = laid(context)
    told = EFFECT.told(context, "base", free)
    assert 1 <= len(told) <= 2
    for name, value in truth.items():
        assert told[0][name] == pytest.approx(value, rel=0.25), name  # it is a start
    bounds = {one.name: (one.lower, one.upper) for one in EFFECT.parameters(context, "base")}
    assert all(bounds[name][0] <= value <= bounds[name][1] for one in told for name, value in one.items())


@pytest.fixture(params=["springs", "bolts"])
def law(request, context):
    """A law over a few lines, and coordinates in the middle of its parameters."""
    effect = EFFECT if request.param == "springs" else EFFECT.next_level.effect
    space = ParameterSpace(effect.parameters(context, "base"))
    ways = len(foundation.motions(context.normal)[0])
    back = np.eye(ways) + 0.1 * np.random.default_rng(3).normal(size=(ways, ways))
    pairs = np.array(foundation.every_term(context)).T
    bolts = None if request.param == "springs" else base_flexibility.bolts_of
    omega = 2 * np.pi * np.array([3.0, 11.0, 40.0])
    x = np.random.default_rng(4).normal(scale=0.1, size=len(space))
    return FoundationLaw(context, space, bolts, omega, back, pairs), x


def test_derivatives_of_a_foundation_are_those_of_differences(law):
    found, x = law
    step, slopes = 1e-5, found.slopes(x)
    for k, one in enumerate(found.space):
        ahead, behind = (found.compliance(x + way * step * (np.arange(len(x)) == k)) for way in (1, -1))
        expected = (ahead - behind) / (2 * step)
        size = np.abs(expected).max() + 1e-6 * np.abs(found.compliance(x)).max()
        np.testing.assert_allclose(slopes[:, :, k], expected, atol=1e-4 * size, err_msg=one.name)


def test_a_foundation_gives_as_the_structure_that_its_effect_makes_does(law):
    """By the effect's own hooks on a root that carries nothing."""
    found, x = law
    effect = EFFECT if found.bolts is None else EFFECT.next_level.effect
    placement = Placement.still(found.context, "base", found.space.values(x))
    names = foundation.motions(found.context.normal)[0]
    assembly = Assembly(found.context.stacked)
    effect.shape(assembly, placement)
    fresh = assembly.alike()
    effect.act(fresh, placement)
    count = len(names) if found.bolts is None else 2 * len(names)
    parts = {"stiffness": 0.0, "damping": 0.0, "mass": 0.0}
    for kind, matrix, _ in fresh.terms:
        parts[kind] = parts[kind] + fresh.full(matrix)[..., -count:, -count:].reshape(-1, count, count)[0]
    rows = np.hstack([np.eye(len(names))] * (count // len(names)))
    omega = found.powers[1].imag[:, None, None]
    z = parts["stiffness"] + 1j * omega * parts["damping"] - omega**2 * parts["mass"]
    full = found.back @ rows @ np.linalg.inv(z) @ rows.T @ found.back.T
    first, second = found.pairs
    np.testing.assert_allclose(found.compliance(x), full[:, first, second], rtol=1e-8)


def test_where_nobody_says_how_well_they_are_known_nothing_is_told(context):
    free, _ = laid(context)
    assert EFFECT.told(context, "base", FreeFunction(free.frequency, free.value, {}, free.fitted)) == []


@pytest.mark.slow
def test_functions_of_which_only_some_combinations_are_known_tell_starts_too(context):
    """Few points see few ways of moving; a function that nobody saw, and lines of very unequal weight."""
    free, _ = laid(context)
    random = np.random.default_rng(2)
    lines, functions = free.value.shape[1], len(free.value)
    seen = random.normal(size=(lines, 3, functions)) / np.abs(free.value.T)[:, None, :]
    seen *= np.geomspace(1e-5, 1e5, lines)[:, None, None]
    seen[..., -1] = 0.0
    free = FreeFunction(free.frequency, free.value, {}, np.zeros(0), np.swapaxes(seen, 1, 2) @ seen + 0j)
    told = EFFECT.told(context, "base", free)
    assert 1 <= len(told) <= 2
    assert all(np.isfinite(list(one.values())).all() for one in told)
