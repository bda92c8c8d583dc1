"""Many systems at once against one at a time, compiled loops against numpy, and ports with derivatives."""

from dataclasses import replace

import numpy as np
import pytest

from flexmodal.errors import Fault, InaccurateModes, InvalidSystem, SingularResponse
from flexmodal.frf.kernels.route import has_numba
from flexmodal.structure import solve_kernel, truncation
from flexmodal.structure.assembly import KINDS
from flexmodal.structure.port import CompliancePort, StiffnessPort
from flexmodal.structure.solution import Entries, back_solved, solved
from flexmodal.structure.stack import Structures, joined
from flexmodal.structure.structure import Axis, receptance
from flexmodal.structure.truncation import missing_of, missing_with_slopes
from flexmodal.structure.with_ports import with_ports

SYSTEMS, DOF, ROWS, STRUCK, NAMES = 3, 5, 4, 2, tuple(f"p{k}" for k in range(8))
AXIS = Axis(np.linspace(3.0, 120.0, 41), 20.0, decay=0.4)
ENTRIES = Entries(
    np.array([[m, u, v] for m in range(SYSTEMS) for u in range(ROWS) for v in range(STRUCK) if m or u]),
    (ROWS, STRUCK),
)


def symmetric(random, *shape, size=1.0):
    a = random.normal(size=(*shape, DOF, DOF))
    return size * (a @ np.swapaxes(a, -1, -2) / DOF + 0.1 * np.eye(DOF))


@pytest.fixture
def structures():
    random = np.random.default_rng(0)
    slopes = {
        "mass": (np.arange(3), symmetric(random, 3, SYSTEMS)),
        "stiffness": (np.arange(2, 6), symmetric(random, 4, SYSTEMS, size=1e5)),
        "damping": (np.array([5]), symmetric(random, 1, SYSTEMS, size=50.0)),
        "loss": (np.array([2]), symmetric(random, 1, SYSTEMS, size=1e4)),
    }
    rows = [(SYSTEMS, ROWS, DOF), (SYSTEMS, STRUCK, DOF)]
    return Structures(
        tuple("abcde"), symmetric(random, SYSTEMS), symmetric(random, SYSTEMS, size=60.0),
        symmetric(random, SYSTEMS, size=2e5), symmetric(random, SYSTEMS, size=5e4),
        *(random.normal(size=shape) for shape in rows), NAMES, slopes,
        {6: tuple(random.normal(size=shape) for shape in rows)}, 0.06, {7: 1.0},
    )  # fmt: skip


def complex_of(parts):
    return parts[:, :, 0] + 1j * parts[:, :, 1]


BOTH_WAYS = pytest.mark.parametrize(
    "compiled", [False, pytest.param(True, marks=pytest.mark.skipif(not has_numba(), reason="no numba"))]
)


@BOTH_WAYS
def test_all_at_once_are_what_each_is_by_itself(structures, compiled):
    found = solved(structures, AXIS, ENTRIES, compiled=compiled)
    scale = 1 / found.value
    slopes = complex_of(found.slopes(scale))
    for m in range(SYSTEMS):
        own = ENTRIES.table[:, 0] == m
        value, change = receptance(structures[m], AXIS, ENTRIES.table[own, 1:], NAMES)
        # LAPACK's own rounding times the condition of Z
        np.testing.assert_allclose(found.value[own], value, rtol=1e-10)
        np.testing.assert_allclose(slopes[:, own], change / value, atol=1e-10 * np.abs(slopes).max())


@BOTH_WAYS
def test_response_rows_are_solved_for_one_after_the_other(structures, compiled):
    found = back_solved(structures, AXIS, compiled=compiled)
    for m in range(SYSTEMS):
        truth = np.transpose(structures[m].solve(AXIS)[0], (2, 1, 0))
        np.testing.assert_allclose(found[m], truth, atol=1e-10 * np.abs(truth).max())


def test_what_is_linked_to_one_coordinate_goes_first(structures):
    """The ends of relaxing springs: each acts on one place when it goes, and makes nothing more than zero."""
    apart = structures.stiffness[0] * np.array([[1, 1, 0, 0, 1], [1, 1, 1, 0, 0], [0, 1, 1, 0, 0],
                                                [0, 0, 0, 1, 1], [1, 0, 0, 1, 1]])  # fmt: skip
    order, count = np.empty(DOF, dtype=int), np.empty(DOF, dtype=int)
    behind, linked = np.empty((DOF, DOF), dtype=int), np.empty((DOF, DOF), dtype=bool)
    solve_kernel.ordered(apart[None], order, behind, count, linked, np.empty(DOF, dtype=bool))
    assert order.tolist() == [2, 1, 0, 3, 4], "a chain from c by b, a, e to d; c first, as d is its other end"
    assert count.tolist() == [1, 1, 1, 1, 0]
    assert [behind[k, 0] for k in range(4)] == [1, 2, 4, 4]


@BOTH_WAYS
def test_coordinates_that_are_linked_to_few_are_solved_too(structures, compiled):
    links = np.array([[1, 0, 0, 1, 0], [0, 1, 1, 1, 0], [0, 1, 1, 0, 1], [1, 1, 0, 1, 1], [0, 0, 1, 1, 1]])
    names = "mass", "damping", "stiffness", "loss"
    sparse = replace(structures, **{name: getattr(structures, name) * links for name in names})
    assert np.all(np.linalg.eigvalsh(sparse.stiffness) > 0)
    found = solved(sparse, AXIS, ENTRIES, compiled=compiled)
    for m in range(SYSTEMS):
        own = ENTRIES.table[:, 0] == m
        value, _ = receptance(sparse[m], AXIS, ENTRIES.table[own, 1:], NAMES)
        np.testing.assert_allclose(found.value[own], value, rtol=1e-10)


@pytest.mark.skipif(not has_numba(), reason="no numba")
def test_negative_stiffness_is_solved_with_pivoting(structures):
    """Resonances of a part held fast make a pivot of the elimination vanish; such lines are repaired."""
    soft = replace(
        structures, damping=np.zeros_like(structures.damping), loss_factor=0.0, loss_slopes={},
        stiffness=structures.stiffness * np.array([[[-1.0]], [[1.0]], [[0.0]]]),
    )  # fmt: skip
    held = replace(soft, stiffness=soft.stiffness.copy())
    axis = replace(AXIS, decay=0.0)
    s = (2 * np.pi * axis.frequency[7]) ** 2
    held.stiffness[0, 0, 0] = s * held.mass[0, 0, 0]  # Z_00 = 0 on the line, exactly
    one, other = (solved(held, axis, ENTRIES, compiled=way).value for way in (True, False))
    np.testing.assert_allclose(one, other, rtol=1e-7)


def test_what_is_joined_is_added(structures):
    twice = joined([structures.slopes, structures.slopes])
    doubled = replace(structures, slopes=twice, turned={}, loss_slopes={})
    once = replace(structures, turned={}, loss_slopes={})
    scale = np.ones((len(ENTRIES.table), len(AXIS)), dtype=complex)
    one, other = (solved(each, AXIS, ENTRIES, compiled=False).slopes(scale) for each in (once, doubled))
    np.testing.assert_allclose(other, 2 * one, rtol=1e-12)
    np.testing.assert_allclose(doubled[1].changes["p3"].stiffness, 2 * once[1].changes["p3"].stiffness)


# ports


def pattern_of(b):
    return b[:, :, None] * b[:, None, :]


def ported(structures, port, value, compiled):
    return with_ports(structures, AXIS, ENTRIES, [port], compiled=compiled).at(value[None])


@pytest.fixture
def between(structures):
    """A spring, a dashpot and a mass between two rows, as an effect puts them in, and as a port."""
    b = structures.response[:, 0] - structures.response[:, 1]
    k, c, m = 4e4, 30.0, 0.2
    p = pattern_of(b)
    built = replace(
        structures, stiffness=structures.stiffness + k * p, damping=structures.damping + c * p,
        mass=structures.mass + m * p,
    )  # fmt: skip
    s = AXIS.s
    return built, StiffnessPort(p), (k + c * s + m * s**2)[None]


@BOTH_WAYS
def test_a_port_is_the_parts_it_stands_for(structures, between, compiled):
    built, port, z = between
    made, truth = ported(structures, port, z, compiled), solved(built, AXIS, ENTRIES, compiled=False)
    np.testing.assert_allclose(made.value, truth.value, rtol=1e-10)
    scale = 1 / truth.value
    np.testing.assert_allclose(made.slopes(scale), truth.slopes(scale), rtol=1e-8, atol=1e-10)


@BOTH_WAYS
def test_derivatives_along_a_stiffness_and_its_pattern(structures, between, compiled):
    _, port, z = between
    b = structures.response[:, 0] - structures.response[:, 1]
    way = structures.reference[:, 0]
    moved = np.array([4]), (b[:, :, None] * way[:, None] + way[:, :, None] * b[:, None])[None]
    made = ported(structures, port, z, compiled)
    step = 1e-4 * np.abs(z).max()
    for turn in (1.0, 1j):  # holomorphic: the same along the real and the imaginary axis
        up, down = (ported(structures, port, z + side * step * turn, compiled).value for side in (1, -1))
        # central differences: step² of the third derivative
        np.testing.assert_allclose((up - down) / (2 * step * turn), made.along[..., 0], rtol=1e-3, atol=1e-14)
    h = 1e-5

    def at(side):
        here = replace(
            structures, stiffness=structures.stiffness + side * h * structures.slopes["stiffness"][1][2]
        )
        return ported(here, StiffnessPort(pattern_of(b + side * h * way)), z, compiled).value

    slopes = complex_of(made.slopes(1 / made.value, moved={0: moved}))
    numeric = (at(1) - at(-1)) / (2 * h) / made.value
    np.testing.assert_allclose(slopes[4], numeric, rtol=1e-5, atol=1e-7)


@BOTH_WAYS
@pytest.mark.parametrize("size", [0.0, 1e-6])
def test_a_compliance_is_regular_where_it_vanishes(structures, size, compiled):
    """At 0 the port holds its coordinate; elsewhere it is a spring of 1/c there."""
    c = np.full((1, len(AXIS)), size * (1 - 0.3j))
    made = ported(structures, CompliancePort(4), c, compiled)
    if size:
        pattern = np.zeros((SYSTEMS, DOF, DOF))
        pattern[:, 4, 4] = 1.0
        other = ported(structures, StiffnessPort(pattern), 1 / c, compiled)
        scale = 1 / other.value
        np.testing.assert_allclose(made.slopes(scale), other.slopes(scale), rtol=1e-7, atol=1e-9)
    else:
        cut = replace(
            structures, coordinates=tuple("abcd"), slopes={}, turned={}, names=(), loss_slopes={},
            **{kind: getattr(structures, kind)[:, :4, :4] for kind in KINDS},
            response=structures.response[:, :, :4], reference=structures.reference[:, :, :4],
        )  # fmt: skip
        other = solved(cut, AXIS, ENTRIES, compiled=False)
    np.testing.assert_allclose(made.value, other.value, rtol=1e-9)


@BOTH_WAYS
def test_ports_together_are_solved_as_one(structures, compiled):
    """Two coordinates that share a compliance, beside a stiffness between two motions, put into Z itself."""
    random = np.random.default_rng(4)
    a, b = structures.response[:, 0], structures.response[:, 1]
    mixed = a[:, :, None] * b[:, None] + b[:, :, None] * a[:, None]
    patterns = [pattern_of(a), mixed, pattern_of(b)]
    stiffness = 1e4 * (random.normal(size=(3, len(AXIS))) + 1j * random.normal(size=(3, len(AXIS))))
    compliance = 1e-5 * (random.normal(size=(3, len(AXIS))) + 1j * random.normal(size=(3, len(AXIS))))
    ports = [CompliancePort(3), CompliancePort(3, 4), CompliancePort(4), *map(StiffnessPort, patterns)]
    values = np.array([each[None] for each in (*compliance, *stiffness)])
    made = with_ports(structures, AXIS, ENTRIES, ports, compiled=compiled).at(values)
    s = AXIS.s[:, None, None]
    h = AXIS.hysteresis(structures.loss_factor)[0][:, None, None]
    expected = np.empty_like(made.value)
    for e, (m, u, v) in enumerate(ENTRIES.table):
        z = structures.stiffness[m] + s * structures.damping[m] + s**2 * structures.mass[m]
        z = z + h * structures.loss[m]
        z = z + sum(k[:, None, None] * p[m] for k, p in zip(stiffness, patterns, strict=True))
        shared = np.array([[compliance[0], compliance[1]], [compliance[1], compliance[2]]])
        z[:, 3:, 3:] += np.linalg.inv(np.moveaxis(shared, 2, 0))
        y = np.linalg.solve(z, np.broadcast_to(structures.reference[m, v][:, None], (len(AXIS), DOF, 1)))
        expected[e] = (structures.response[m, u] @ y)[:, 0]
    np.testing.assert_allclose(made.value, expected, rtol=1e-8)
    for number, value in enumerate(values):
        step = 1e-5 * np.abs(value).max()
        moved = [values + side * step * np.eye(len(values))[number][:, None, None] for side in (1, -1)]
        up, down = (made.base.at(one).value for one in moved)
        slope = made.along[..., number]
        np.testing.assert_allclose(
            (up - down) / (2 * step), slope, rtol=1e-4, atol=1e-5 * np.abs(slope).max()
        )


@BOTH_WAYS
@pytest.mark.parametrize("size", [0.0, 1e-6])
def test_derivatives_along_a_compliance(structures, size, compiled):
    c, step = np.full((1, len(AXIS)), size + 0j), 1e-10
    made = ported(structures, CompliancePort(4), c, compiled)
    up, down = (ported(structures, CompliancePort(4), c + side * step, compiled).value for side in (1, -1))
    found, numeric = made.along[..., 0], (up - down) / (2 * step)
    np.testing.assert_allclose(found, numeric, rtol=1e-4, atol=1e-5 * np.abs(found).max())


@pytest.mark.parametrize("loss", [0.0, 0.1])
@pytest.mark.parametrize("power", [0, 1, 2])
def test_what_a_record_cuts_off_is_the_same_by_modes_and_by_the_state_at_its_end(structures, power, loss):
    bare = replace(structures, slopes={}, turned={}, names=(), loss_factor=loss, loss_slopes={})
    axis = replace(AXIS, length=0.05, power=power, cut_slopes=False)
    found = solved(bare, axis, ENTRIES, compiled=False)
    by_modes, _ = missing_with_slopes(found, ())
    by_state = missing_of(found)
    assert np.abs(by_modes).max() > 1e-3 * np.abs(found.value).max()
    np.testing.assert_allclose(by_state, by_modes, rtol=1e-7, atol=1e-9 * np.abs(by_modes).max())


@pytest.mark.parametrize("power", [0, 1, 2])
def test_what_a_control_loop_leaves_at_the_end_is_cut_off_too(structures, power):
    """A negative Maxwell element, as of a loop that integrates, makes the mass matrix indefinite."""
    bare = replace(structures, slopes={}, turned={}, names=(), loss_factor=0.0, loss_slopes={})
    k, time, light = 300.0, 0.02, 1e-4
    row = np.zeros((SYSTEMS, DOF, DOF))
    row[:, :2, :2] = [[1.0, -1.0], [-1.0, 1.0]]
    end = np.zeros((SYSTEMS, DOF, DOF))
    end[:, 1, 1] = 1.0
    mass = bare.mass.copy()
    mass[:, 1], mass[:, :, 1] = 0.0, 0.0  # the second coordinate is the end of the element alone
    damping, stiffness = bare.damping.copy(), bare.stiffness.copy()
    for matrix in (damping, stiffness):
        matrix[:, 1], matrix[:, :, 1] = 0.0, 0.0
    active = replace(
        bare, mass=mass - light * end, damping=damping - k * time * end, stiffness=stiffness - k * row
    )
    assert np.linalg.eigvalsh(active.mass)[:, 0].max() < 0
    axis = replace(AXIS, length=0.05, power=power, cut_slopes=False)
    found = solved(active, axis, ENTRIES, compiled=False)
    by_modes, _ = missing_with_slopes(found, ())
    assert np.abs(by_modes).max() > 1e-3 * np.abs(found.value).max()
    np.testing.assert_allclose(missing_of(found), by_modes, rtol=1e-7, atol=1e-9 * np.abs(by_modes).max())


def test_what_rings_up_beyond_any_number_has_no_end(structures):
    """A damper that drives: an error that fits catch, not a receptance that is no number."""
    bare = replace(structures, slopes={}, turned={}, names=(), loss_factor=0.0, loss_slopes={})
    driven = replace(bare, damping=-1e3 * bare.mass)
    found = solved(driven, replace(AXIS, length=4.0, power=2, cut_slopes=False), ENTRIES, compiled=False)
    with pytest.raises(SingularResponse, match="rings up"):
        missing_of(found)


@pytest.mark.parametrize("error", [InvalidSystem, InaccurateModes, np.linalg.LinAlgError])
def test_where_there_are_no_modes_nothing_is_said_to_be_cut_off(structures, monkeypatch, error):
    """Of stiffness over too many decades, say, whose receptance stays right."""

    def poles(structure, names, *, active):
        raise error([Fault("", "", "none", "some")]) if issubclass(error, InvalidSystem) else error("none")

    monkeypatch.setattr(truncation, "poles", poles)
    axis = replace(AXIS, length=0.05, power=2, cut_slopes=False)
    pairs = np.array([[0, 0]])
    assert truncation.missing(structures[0], axis, pairs) is None
    found = solved(structures, axis, ENTRIES, compiled=False)
    assert missing_with_slopes(found, ()) is None
