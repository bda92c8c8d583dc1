"""All minima over a band: by bounds, by an eigenvalue problem, by dense sampling, and against Table 3.6."""

import csv
import json
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from scipy.signal import argrelmax, argrelmin

import flexmodal
from flexmodal.cards import FrozenDict
from flexmodal.errors import InvalidRequest
from flexmodal.modal import SecondOrderSystem
from flexmodal.optimisation import (
    Hold,
    PostureProblem,
    ReceptanceObjective,
    TunedObjective,
    fixed_gain_descent,
    optimise,
    tune,
)
from flexmodal.optimisation.frequency.partial_fractions import (
    LogarithmicSlope,
    antiresonances,
    logarithmic_slope,
)
from flexmodal.optimisation.frequency.roots import roots

from ..model.writing import planar
from .optimality import difference, directions

THESIS = Path(__file__).parents[1] / "data" / "thesis"


def sampled(posed, band, response, reference, count=40001):
    """Local minima and maxima of a dense scan, each refined; knows nothing of poles [Hz]."""

    def size(f):
        values = posed.frf(np.atleast_1d(f), response=response, reference=reference).value[:, 0, 0]
        return np.abs(values)

    grid = np.geomspace(max(band[0], 1e-3), band[1], count)
    scanned = size(grid)
    found = []
    for sign, places in ((1, argrelmin(scanned)[0]), (-1, argrelmax(scanned)[0])):
        found.append(
            [
                minimize_scalar(
                    lambda f, sign=sign: sign * np.log(size(f)[0]),
                    bounds=(grid[place - 1], grid[place + 1]),
                    method="bounded",
                    options={"xatol": 1e-12},
                ).x
                for place in places
            ]
        )
    return found


def by_eigenvalues(slope: LogarithmicSlope) -> np.ndarray:
    """Roots of Σ c/(x − w): x Σ c/(x − w) = Σ c + Σ cw/(x − w) vanishes at eigenvalues of W − 1 (cw)ᵀ/Σc."""
    places, weights = [], []
    for centre, width, weight in zip(slope.centre, slope.width, slope.weight, strict=True):
        pair = abs(weight) == 2
        places += [centre + 1j * width, centre - 1j * width] if pair else [centre]
        weights += [weight / 2] * 2 if pair else [weight]
    w, c = np.array(places, dtype=complex), np.array(weights)
    scale = np.abs(w).max()
    return scale * np.linalg.eigvals(np.diag(w) / scale - np.outer(np.ones(len(w)), c * w / scale) / c.sum())


def random_posture(robot, seed):
    problem = PostureProblem(robot, ReceptanceObjective(directions(f"{robot.tool}:+z"), np.array([1.0])))
    return robot.at(problem.posture(problem.random_vector(np.random.default_rng(seed))))


PAIRS = [("+z", "+z"), ("+x", "+x"), ("+z", "+x")]


@pytest.mark.some(4)
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("pair", PAIRS)
@pytest.mark.parametrize("name", ["fanuc_s360", "six_link", "ur5"])
def test_minima_are_those_of_a_dense_scan(robots, name, pair, seed):
    robot = robots[name]
    band = (0.5, 300.0)
    posed = random_posture(robot, seed)
    response, reference = (f"{robot.tool}:{axis}" for axis in pair)
    found = tune(posed, band, response=response, reference=reference)
    minima, maxima = sampled(posed, band, response, reference)
    # A minimum of a quantity known to 1e-14 is located to the root of that, 1e-7, by values alone.
    np.testing.assert_allclose([one.frequency for one in found.minima], minima, rtol=1e-6)
    np.testing.assert_allclose([one.frequency for one in found.maxima], maxima, rtol=1e-6)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("name", ["fanuc_s360", "six_link", "ur5"])
def test_roots_are_the_eigenvalues_of_a_matrix(robots, name, seed):
    robot = robots[name]
    (z,) = directions(f"{robot.tool}:+z")
    posed = random_posture(robot, 10 + seed)
    slope = logarithmic_slope(posed, z, z)
    everything = by_eigenvalues(slope)
    low, high = (2 * np.pi * 0.3) ** 2, (2 * np.pi * 1000) ** 2
    real = everything[np.abs(everything.imag) <= 1e-7 * np.abs(everything)].real
    expected = np.sort(real[(real > low) & (real < high)])
    found = tune(posed, (0.3, 1000.0))
    ours = np.sort([(2 * np.pi * one.frequency) ** 2 for one in (*found.minima, *found.maxima)])
    np.testing.assert_allclose(ours, expected, rtol=1e-6)


def test_minima_and_maxima_take_turns(robots):
    for name, robot in robots.items():
        for seed in range(10):
            found = tune(random_posture(robot, 30 + seed), (0.01, 2000.0))
            kinds = sorted(
                [(one.frequency, 1) for one in found.minima] + [(one.frequency, -1) for one in found.maxima]
            )
            signs = [kind for _, kind in kinds]
            assert all(a != b for a, b in pairwise(signs)), (name, seed)
            assert found.best.receptance == min(
                one.receptance for one in (*found.minima, *found.maxima, *found.ends)
            )


def test_the_slope_is_that_of_the_receptance(robots):
    """Σ of fractions against differences of ln|α|², from the direct solve."""
    for robot in robots.values():
        posed = random_posture(robot, 3)
        for a, b in PAIRS:
            response, reference = directions(f"{robot.tool}:{a}", f"{robot.tool}:{b}")
            slope = logarithmic_slope(posed, response, reference)
            for f in (0.7, 4.0, 33.0, 180.0):

                def log_square(x, posed=posed, response=response, reference=reference):
                    line = [float(np.sqrt(x[0])) / (2 * np.pi)]
                    value = posed.frf(line, response=response, reference=reference).value[0, 0, 0]
                    return np.array(2 * np.log(abs(value)))

                x = np.array([(2 * np.pi * f) ** 2])
                expected = difference(log_square, x, 1e-3 * x[0])
                assert slope.at(x)[0] * x[0] == pytest.approx(expected[0] * x[0], abs=1e-7, rel=1e-6)


def test_bounds_hold_and_close_in(fanuc):
    """Values inside an interval lie between the bounds, and halving it brings them together."""
    (z,) = directions("tool:+z")
    slope = logarithmic_slope(fanuc.at("configuration_1"), z, z)
    generator = np.random.default_rng(5)
    centre = generator.uniform(10, 4e5, 200)
    last = np.inf
    for width in (1e4, 1e2, 1.0):
        low, high = np.maximum(centre - width, 1.0), centre + width
        least, greatest = slope.bounds(low, high)
        falls, rises = slope.slope_bounds(low, high)
        for share in np.linspace(0, 1, 21):
            x = low + share * (high - low)
            assert np.all((least <= slope.at(x)) & (slope.at(x) <= greatest))
            step = 1e-4 * x
            rate = (slope.at(x + step) - slope.at(x - step)) / (2 * step)
            inside = (x - step >= low) & (x + step <= high)
            room = 1e-6 * np.abs(rate) + 1e-12
            assert np.all((falls[inside] <= (rate + room)[inside]) & ((rate - room)[inside] <= rises[inside]))
        gap = float(np.max(greatest - least))
        assert gap < last
        last = gap


def test_a_needle_between_two_samples_is_found():
    """Two fractions so narrow that a scan of 10⁵ lines passes them by."""
    needle = LogarithmicSlope(
        np.array([1e4, 1e4 + 1e-3, 5e4]), np.array([1e-4, 1e-4, 1e3]), np.array([2.0, -2, -2])
    )
    found, rising = roots(needle, np.array([1.0, 1e5]))
    assert np.any(np.abs(found - 1e4) < 1e-3)
    assert np.any(np.abs(found - 1e4 - 1e-3) < 1e-3)
    scan = np.sign(needle.at(np.arange(1.5, 1e5)))
    assert np.sum(scan[1:] != scan[:-1]) < len(found)
    assert len(rising) == len(found)


@pytest.mark.parametrize("seed", range(5))
def test_antiresonances_make_the_receptance_vanish(seed):
    generator = np.random.default_rng(seed)
    a, b, c = (generator.normal(size=(5, 5)) for _ in range(3))
    system = SecondOrderSystem(a @ a.T + np.eye(5), 0.1 * b @ b.T, 50 * c @ c.T + np.eye(5), tuple("vwxyz"))
    rows = generator.normal(size=(2, 5))
    for u, v in ((rows[0], rows[0]), (rows[0], rows[1])):
        zeros = antiresonances(system, u, v)
        assert len(zeros) == 8  # 2n − 2
        for s in zeros:
            dynamic = system.stiffness + s * system.damping + s**2 * system.mass
            solved = np.linalg.solve(dynamic, v)
            assert abs(u @ solved) <= 1e-7 * np.linalg.norm(u) * np.linalg.norm(solved)


def test_without_damping_antiresonances_are_zeros_and_poles_infinite(tmp_path):
    """Two links on paper: the antiresonance of the tip is the frequency of the arm with its tip held."""
    path = planar(tmp_path / "two.urdf", [1.0, 1.0], [4.0, 3.0], [0.4, 0.3], [0.5, 0.5])
    robot = flexmodal.load(path, stiffness={"q1": 3e3, "q2": 1e3})
    posed = robot.at({"q1": 0.3, "q2": 0.9})
    mass, stiffness = posed.system.mass, posed.system.stiffness
    row = posed.rows(directions("tool:+z"))[0]
    along = np.array([row[1], -row[0]])
    held = np.sqrt((along @ stiffness @ along) / (along @ mass @ along)) / (2 * np.pi)
    poles = np.sqrt(np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real) / (2 * np.pi)
    found = tune(posed, (0.1, 100.0))
    assert [one.frequency for one in found.minima] == pytest.approx([held], rel=1e-12)
    assert found.best.receptance <= 1e-15
    assert sorted(one.frequency for one in found.maxima) == pytest.approx(sorted(poles), rel=1e-9)
    assert all(one.receptance == np.inf for one in found.maxima)
    at_pole = tune(posed, (float(min(poles)), 100.0))
    assert at_pole.ends[0].receptance == np.inf
    assert np.isfinite(at_pole.best.receptance)


def test_one_joint_has_no_minimum(tmp_path):
    path = planar(tmp_path / "one.urdf", [1.0], [4.0], [0.4], [0.5])
    posed = flexmodal.load(path, stiffness=1e3, damping=2.0).at({"q1": 0.3})
    found = tune(posed, (0.0, 50.0))
    assert (len(found.minima), len(found.maxima)) == (0, 1)
    assert "upper end" in found.verdict
    assert found.best == found.ends[1]


def test_a_mode_that_the_force_does_not_shake(tmp_path):
    """A link that hangs straight down is not pushed on by a force along it, and the row of its joint is 0."""
    path = planar(tmp_path / "two.urdf", [1.0, 1.0], [4.0, 3.0], [0.4, 0.3], [0.5, 0.5])
    posed = flexmodal.load(path, stiffness=1e3, damping=2.0).at({"q1": 0.0, "q2": np.pi / 2})
    with pytest.raises(InvalidRequest, match="0 at every frequency"):
        tune(posed, (1.0, 50.0), response="tool:+y")
    found = tune(posed, (0.5, 50.0), response="tool:+z")
    minima, maxima = sampled(posed, (0.5, 50.0), "tool:+z", "tool:+z")
    np.testing.assert_allclose([one.frequency for one in found.minima], minima, rtol=1e-6)
    np.testing.assert_allclose([one.frequency for one in found.maxima], maxima, rtol=1e-6)


@pytest.mark.parametrize("band", [(5.0, 5.0), (6.0, 5.0), (-1.0, 5.0), (0.0, np.inf), (np.nan, 5.0)])
def test_bands_that_are_none(fanuc, band):
    with pytest.raises(InvalidRequest, match="band"):
        tune(fanuc.at("configuration_1"), band)


def test_zero_hertz_is_an_end(fanuc):
    found = tune(fanuc.at("configuration_1"), (0.0, 5.0))
    assert found.minima == ()
    assert found.best == found.ends[0]
    assert found.best.receptance == pytest.approx(
        fanuc.measures("configuration_1").static_receptance, rel=1e-10
    )


@pytest.mark.some(3)
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("pair", PAIRS)
@pytest.mark.parametrize("name", ["lossy", "always_lossy"])
def test_loss_factors_move_the_minima(request, fanuc, name, pair, seed):
    """Causal or not, coupled or not: where a dense scan has them, and not where they are without loss."""
    robot, band = request.getfixturevalue(name), (0.5, 300.0)
    plain, posed = random_posture(fanuc, seed), random_posture(robot, seed)
    response, reference = (f"tool:{axis}" for axis in pair)
    found = tune(posed, band, response=response, reference=reference)
    minima, maxima = sampled(posed, band, response, reference)
    np.testing.assert_allclose([one.frequency for one in found.minima], minima, rtol=1e-6)
    np.testing.assert_allclose([one.frequency for one in found.maxima], maxima, rtol=1e-6)
    without = tune(plain, band, response=response, reference=reference)
    assert (found.proved, without.proved) == (name == "always_lossy", True)
    assert ("grid" in found.verdict) == (name == "lossy")
    assert found.maxima[0].receptance < 0.9 * without.maxima[0].receptance


@pytest.mark.parametrize("name", ["lossy", "always_lossy", "fanuc"])
def test_a_fixed_gain_takes_the_slope_of_the_receptance(request, name):
    """First step against differences of ln|α|, hysteresis or not."""
    posed, start, gain, step = request.getfixturevalue(name).at("configuration_1"), 30.0, 0.1, 1e-4
    path = fixed_gain_descent(posed, start, gain=gain, ceiling=200.0, steps=1)
    up, down = (np.log(abs(posed.frf([start + sign * step]).value[0, 0, 0])) for sign in (1, -1))
    assert path.frequency[1] == pytest.approx(start - gain * (up - down) / (2 * step), rel=1e-9)


def test_a_joint_without_loss_beside_one_with(tmp_path):
    """One of two joints loses energy: every mode has some of it, and the roots are no conjugate pairs."""
    path = planar(tmp_path / "two.urdf", [1.0, 1.0], [4.0, 3.0], [0.4, 0.3], [0.5, 0.5])
    robot = flexmodal.load(path, stiffness={"q1": 3e3, "q2": 1e3})
    joints = {"q1": robot.joints["q1"], "q2": replace(robot.joints["q2"], loss_factor=0.05)}
    posed = replace(robot, joints=FrozenDict(joints)).at({"q1": 0.3, "q2": 0.9})
    found = tune(posed, (0.1, 100.0))
    minima, maxima = sampled(posed, (0.1, 100.0), "tool:+z", "tool:+z")
    np.testing.assert_allclose([one.frequency for one in found.minima], minima, rtol=1e-6)
    np.testing.assert_allclose([one.frequency for one in found.maxima], maxima, rtol=1e-6)
    assert found.proved


def test_causal_hysteresis_has_no_fractions(lossy):
    (z,) = directions("tool:+z")
    with pytest.raises(InvalidRequest, match="loss_frequency"):
        logarithmic_slope(lossy.at("configuration_1"), z, z)


# Table 3.6: where the thesis's descents ended.


def printed():
    with (THESIS / "frequency_optimisation.csv").open(newline="") as file:
        return [row for row in csv.DictReader(file) if row["configuration"]]


def test_table_3_6(fanuc):
    """Within 3.5 Hz where the model has that minimum: its lengths are inferred, its frequencies 3.4 % off."""
    missing = []
    for row in printed():
        posed = fanuc.at(f"configuration_{row['configuration']}")
        found = tune(posed, (0.0, 200.0))
        if row["flag"] == "unbounded":
            assert found.maxima[-1].frequency < float(row["initial_frequency_hz"])  # downhill from there on
            continue
        end = float(row["final_frequency_hz"])
        places = [0.0, *(one.frequency for one in found.minima)]
        gap = min(abs(place - end) for place in places)
        if gap > 3.5:
            missing.append((row["configuration"], end, gap))
    assert missing == []


def test_a_fixed_gain_hops_over_a_maximum_and_bounds_do_not(fanuc):
    """From 54 Hz the next minimum downhill is 54.7 Hz; a large gain ends at 45.2, beyond the maximum."""
    posed = fanuc.at("configuration_1")
    found = tune(posed, (0.0, 200.0))
    small = fixed_gain_descent(posed, 54.0, gain=1.0, ceiling=200.0)
    large = fixed_gain_descent(posed, 54.0, gain=20.0, ceiling=200.0)
    assert small.hops(found) == ()
    assert small.frequency[-1] == pytest.approx(found.minima[1].frequency, abs=1e-3)
    ((before, after),) = large.hops(found)
    peak = found.maxima[1].frequency
    assert after < peak < before
    assert large.frequency[-1] == pytest.approx(found.minima[0].frequency, abs=0.5)
    assert {found.minima[0], found.minima[1]} <= set(found.minima)
    with pytest.raises(InvalidRequest):
        fixed_gain_descent(posed, 0.0, gain=1.0, ceiling=200.0)


# Posture and frequency together.


@pytest.mark.parametrize("name", ["six_link", "fanuc_s360", "ur5"])
def test_gradient_of_posture_with_frequency_free(robots, name):
    robot = robots[name]
    (z,) = directions(f"{robot.tool}:+z")
    problem = PostureProblem(robot, TunedObjective(z, (1.0, 60.0)))
    generator = np.random.default_rng(31)
    for _ in range(3):
        values = problem.random_vector(generator)
        _, gradient = problem.cost_and_gradient(values)
        expected = difference(lambda v: np.array(problem.cost_and_gradient(v)[0]), values, 1e-4)
        np.testing.assert_allclose(gradient, expected, atol=1e-6 * (1 + np.linalg.norm(gradient)) ** 2)


@pytest.mark.usefixtures("types_unchecked")
@pytest.mark.slow
def test_posture_and_frequency_together_beat_either(arm):
    (z,) = directions("tool:+z")
    hold, band = Hold.at(arm, (-2.0, 2.0)), (0.5, 4.0)
    both = optimise(PostureProblem(arm, TunedObjective(z, band), hold), start="start_2", starts=6)
    posed = arm.at(both.best.posture)
    best = tune(posed, band).best
    assert both.best.objective == pytest.approx(best.receptance, rel=1e-12)
    assert both.problem.objective.frequency_at(posed) == best.frequency
    assert both.best.objective < tune(arm.at("start_2"), band).best.receptance
    grid = np.geomspace(*band, 2000)
    scanned = np.abs(posed.frf(grid).value[:, 0, 0])
    assert both.best.objective <= scanned.min() * (1 + 1e-12)
    with pytest.raises(InvalidRequest, match="band"):
        TunedObjective(z, (4.0, 0.5))


def test_command(capsys):
    from flexmodal.cli.main import main

    with pytest.raises(SystemExit) as left:
        main(["tune", "fanuc_s360", "--posture", "configuration_1", "--band", "5:150", "--json"])
    assert left.value.code == 0
    found = json.loads(capsys.readouterr().out)
    expected = tune(flexmodal.load("fanuc_s360").at("configuration_1"), (5.0, 150.0))
    assert set(found) == {"frequency", "receptance", "minima"}
    assert (found["frequency"], found["receptance"]) == (expected.best.frequency, expected.best.receptance)
    assert found["minima"] == [vars(one) for one in expected.minima]
    with pytest.raises(SystemExit) as left:
        main(["tune", "fanuc_s360", "--posture", "configuration_1", "--band", "150:5"])
    assert left.value.code == 2
    assert "LOW < HIGH" in capsys.readouterr().err
