"""Paths: against enumeration, against a scan of the self-motion, within limits and speeds; tables."""

import itertools
import json

import numpy as np
import pytest

import flexmodal
from flexmodal.errors import InvalidRequest, Unreachable
from flexmodal.optimisation import Hold
from flexmodal.optimisation.path import PathProblem, arc, greedy_path, line, plan_path, read_toolpath
from flexmodal.optimisation.path.dynamic import best_sequence
from flexmodal.optimisation.path.local import _cost, improve, path_cost
from flexmodal.optimisation.path.nodes import nodes_of

from ..agreement.planar_chain import PlanarChain
from ..model.writing import planar

pytestmark = pytest.mark.usefixtures("types_unchecked")

CHAIN = PlanarChain([1.0, 0.8, 0.5], [8.0, 6.0, 3.0], [0.7, 0.35, 0.08], [0.45, 0.4, 0.2])


@pytest.fixture(scope="module")
def three(tmp_path_factory):
    """Three links, one redundancy: the self-motion is a line."""
    path = planar(
        tmp_path_factory.mktemp("three") / "three.urdf",
        CHAIN.lengths,
        CHAIN.masses,
        CHAIN.inertias,
        CHAIN.coms,
        limits=[(-3.1, 3.1)] * 3,
    )
    return flexmodal.load(
        path,
        stiffness={"q1": 3e4, "q2": 1.5e4, "q3": 5e3},
        damping={"q1": 60.0, "q2": 40.0, "q3": 10.0},
    )


def straight(robot, points=6, **rest):
    return PathProblem.along(robot, line((1.1, 0.4), (0.8, 0.9), points, 0.05), 12.0, **rest)


def self_motion(target, count):
    """All postures of the three links with the tool on a target, by the direction of the last link."""
    first, second, third = CHAIN.lengths
    found = []
    for turn in np.linspace(-np.pi, np.pi, count, endpoint=False):
        x, z = np.array(target) - third * np.array([np.cos(turn), np.sin(turn)])
        cosine = (x * x + z * z - first**2 - second**2) / (2 * first * second)
        if abs(cosine) > 1:
            continue
        for elbow in (np.arccos(cosine), -np.arccos(cosine)):
            q1 = np.arctan2(z, x) - np.arctan2(second * np.sin(elbow), first + second * np.cos(elbow))
            q = np.array([q1, elbow, (turn - q1 - elbow + np.pi) % (2 * np.pi) - np.pi])
            if np.all(np.abs(q) <= 3.1):
                found.append(q)
    return np.array(found)


@pytest.mark.parametrize("way", ["sum", "worst"])
@pytest.mark.parametrize("seed", range(3))
def test_dynamic_programming_against_enumeration(three, way, seed):
    """Five nodes at each of four points: all 625 sequences are looked at."""
    problem = straight(three, 4, way=way, stride=1.5, smoothness=0.0 if way == "worst" else 0.01)
    generator = np.random.default_rng(seed)
    nodes = []
    for at in problem.at:
        found = []
        while len(found) < 5:
            values = at.retract(generator.uniform(-1.5, 1.5, 3))
            found += [] if values is None else [values]
        nodes.append(np.array(found))
    sequences = [np.array(one) for one in itertools.product(*nodes)]
    allowed = [one for one in sequences if np.all(problem.shares(one) <= 1)]
    if not allowed:
        with pytest.raises(Unreachable, match="times as long"):
            best_sequence(problem, nodes)
        return
    # values are taken relative to the least that the point whose least is greatest has
    scale = max(
        min(at.objective.value(at.posed(q)) for q in group)
        for at, group in zip(problem.at, nodes, strict=True)
    )

    def judged(one):
        values = problem.values(one) / scale
        if way == "worst":
            return values.max()
        return values.sum() + problem.smoothness * np.sum(np.mean(problem.shares(one) ** 2, axis=1))

    found = best_sequence(problem, nodes)
    assert np.all(problem.shares(found) <= 1)
    assert judged(found) == pytest.approx(min(map(judged, allowed)), rel=1e-12)


@pytest.mark.parametrize("way", [pytest.param("sum", marks=pytest.mark.slow), "worst"])
@pytest.mark.slow
def test_as_good_as_a_dense_scan_of_the_self_motion(three, way):
    """Dynamic programming over 3000 postures a point, written out here, is not better than the plan."""
    problem = straight(three, way=way, smoothness=0.0)
    outcome = plan_path(problem, nodes=30, seed=1)
    line_of = [point.hold.target for point in problem.points]
    total = None
    for place, target in enumerate(line_of):
        postures = self_motion(target, 300)
        at = problem.at[place]
        values = np.array([at.objective.value(at.posed(q)) for q in postures])
        if total is None:
            total, last = values, postures
            continue
        near = np.max(np.abs(last[:, None] - postures[None]), axis=2) <= problem.reach[place - 1][0]
        best = np.min(np.where(near, total[:, None], np.inf), axis=0)
        total = best + values if way == "sum" else np.maximum(best, values)
        last = postures
    found = outcome.total if way == "sum" else outcome.worst
    assert found <= np.min(total) * (1 + 1e-6)
    # and the scan, 20 mrad fine, is not much worse: nothing was gained by breaking a rule
    assert found >= np.min(total) * 0.97
    assert np.all(problem.shares(outcome.postures) <= 1)


@pytest.mark.slow
def test_hold_limits_and_speeds_are_kept(three):
    """Speeds so low that they are in the way all along; the greedy sequence pays for its start."""
    tight = straight(three, 6, way="worst", speed=np.array([0.025, 0.04, 0.1]))
    outcome = plan_path(tight, nodes=30, seed=2)
    shares = tight.shares(outcome.postures)
    assert shares.max() <= 1.0
    assert shares.max() > 0.5
    assert outcome.fastest <= 1.0
    for at, values in zip(tight.at, outcome.postures, strict=True):
        assert np.linalg.norm(at.held(values)[0]) <= 1e-9
        assert np.all((at.lower <= values) & (values <= at.upper))
    with pytest.raises(Unreachable, match="times as long"):
        plan_path(straight(three, 3, speed=np.full(3, 1e-3)), nodes=8, seed=2)


@pytest.mark.slow
def test_never_worse_than_greedy(three, arm):
    for robot, problem in (
        (three, straight(three, way="worst")),
        (three, straight(three, way="sum")),
        (arm, PathProblem.along(arm, line((-2.5, 1.5), (-2.0, 2.0), 4, 0.05), 5.0, way="worst")),
    ):
        greedy = greedy_path(problem, starts=4)
        planned = plan_path(problem, nodes=6, iterations=25)
        assert planned.cost <= greedy.cost + 1e-12, robot.name
        assert np.all(problem.shares(planned.postures) <= 1)


@pytest.mark.slow
def test_interrupted_with_the_best_so_far(three):
    """Greedy comes first, within a second; then whatever is better is kept."""
    problem, told = straight(three), []

    def stop_after(count):
        told.clear()
        left = iter(range(count))

        def advance():
            if next(left, None) is None:
                raise KeyboardInterrupt

        return plan_path(problem, nodes=4, advance=advance, improved=told.append)

    early = stop_after(1)
    assert early.interrupted
    assert len(told) == 1
    assert early.total == pytest.approx(greedy_path(problem).total) == pytest.approx(told[0])
    late = stop_after(len(problem.points) + 6)
    assert late.interrupted
    assert late.total <= early.total
    whole = plan_path(problem, nodes=4)
    assert not whole.interrupted
    assert path_cost(problem, whole.postures) <= path_cost(problem, late.postures)
    assert told == sorted(told, reverse=True)


@pytest.mark.slow
def test_the_local_solver_only_goes_down_and_ends_at_a_minimum(three):
    for way in ("sum", "worst"):
        problem = straight(three, way=way)
        start = best_sequence(problem, nodes_of(problem, 15, 3))
        costs = [path_cost(problem, improve(problem, start, iterations=count)) for count in (0, 5, 60)]
        assert costs == sorted(costs, reverse=True)
        end = improve(problem, start, iterations=60)
        best, generator = path_cost(problem, end), np.random.default_rng(4)
        for _ in range(60):
            nudged = end + generator.normal(scale=generator.choice([1e-3, 1e-2]), size=end.shape)
            near = [at.retract(values) for at, values in zip(problem.at, nudged, strict=True)]
            if all(values is not None for values in near) and np.all(problem.shares(np.array(near)) <= 1):
                assert path_cost(problem, np.array(near)) >= best - 1e-5


@pytest.mark.slow
def test_the_cost_is_what_it_says(three):
    problem = straight(three, smoothness=0.3)
    postures = best_sequence(problem, nodes_of(problem, 6, 3))
    values = problem.values(postures)
    smooth = 0.3 * np.mean(problem.shares(postures) ** 2)
    assert path_cost(problem, postures) == pytest.approx(np.log(values.sum()) + smooth, rel=1e-12)
    worst = straight(three, smoothness=0.3, way="worst")
    assert path_cost(worst, postures) == pytest.approx(np.log(values.max()) + smooth, rel=1e-12)
    assert _cost(worst, postures)[1] == pytest.approx(np.log(values), rel=1e-10)


def test_the_vibration_is_that_under_the_force(three):
    """‖α f‖ with the force direction of the table, a different one at each point."""
    toolpath = line((1.1, 0.4), (1.05, 0.45), 3, 0.05)
    force = np.array([[1.0, 0, 0], [0, 0, 1.0], [0.6, 0, -0.8]])
    problem = PathProblem.along(three, type(toolpath)(toolpath.position, toolpath.time, force), 12.0)
    postures = greedy_path(problem, starts=3).postures
    for place, (at, values) in enumerate(zip(problem.at, postures, strict=True)):
        alpha = at.posed(values).frf([12.0], response=["tool:+x", "tool:+z"]).value[0]
        expected = np.linalg.norm(alpha @ force[place][[0, 2]])
        assert problem.values(postures)[place] == pytest.approx(expected, rel=1e-12)


@pytest.mark.slow
def test_with_the_tool_held_upright(arm):
    hold = lambda place: Hold.at(arm, place, orientation=(np.pi / 2,))  # noqa: E731
    problem = PathProblem.along(arm, line((-2.5, 1.5), (-2.3, 1.7), 3, 0.05), 5.0, hold=hold)
    outcome = plan_path(problem, nodes=6, iterations=10)
    for at, values in zip(problem.at, outcome.postures, strict=True):
        np.testing.assert_allclose(at.posed(values).rotation("tool")[[0, 2], 0], [0, 1], atol=1e-9)


def test_between_points(three):
    """Joints that go straight leave the path by its curvature, the less the closer the points."""
    coarse, fine = (greedy_path(straight(three, points), starts=3) for points in (4, 16))
    assert 0 < fine.deviation < coarse.deviation / 4


# Lines, arcs, tables.


def test_line():
    found = line((0.0, 1.0), (0.0, 3.0), 5, 0.5)
    np.testing.assert_allclose(found.position, [[0, 1], [0, 1.5], [0, 2], [0, 2.5], [0, 3]])
    np.testing.assert_allclose(found.time, [0, 1, 2, 3, 4])


@pytest.mark.parametrize("sweep", [0.4, 2.0, 3.5, 6.0, -1.0, -5.0])
def test_arc(sweep):
    """Through three places of a known circle in space, the short way or the long."""
    generator = np.random.default_rng(int(10 * abs(sweep)))
    along, across = np.linalg.qr(generator.normal(size=(3, 2)))[0].T
    centre = generator.normal(size=3)

    def place(angle):
        return centre + 0.7 * (np.cos(angle) * along + np.sin(angle) * across)

    found = arc(tuple(place(0.3)), tuple(place(0.3 + 0.37 * sweep)), tuple(place(0.3 + sweep)), 9, 0.1)
    expected = np.array([place(0.3 + share * sweep) for share in np.linspace(0, 1, 9)])
    np.testing.assert_allclose(found.position, expected, atol=1e-9)
    chord = 2 * 0.7 * np.sin(abs(sweep) / 16)
    np.testing.assert_allclose(np.diff(found.time), chord / 0.1, rtol=1e-9)


def test_a_table(tmp_path):
    file = tmp_path / "path.csv"
    file.write_text("time,x,z,fx,fz\n1,0.5,0.4,2,0\n2,0.6,0.4,0,-3\n")
    found = read_toolpath(file, planar=True)
    np.testing.assert_allclose(found.position, [[0.5, 0.4], [0.6, 0.4]])
    np.testing.assert_allclose(found.time, [0, 1])
    np.testing.assert_allclose(found.force, [[1, 0, 0], [0, 0, -1]])
    file.write_text("x,y,z\n0,0,0\n0,3,4\n0,3,5\n")
    timed = read_toolpath(file, planar=False, feed=0.5)
    np.testing.assert_allclose(timed.time, [0, 10, 12])
    assert timed.force is None


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", ["no column x", "no column z"]),
        ("x,w\n1,2\n", ["no column z", '"w"']),
        ("x,x,z,time\n1,1,2,0\n", ["x"]),
        ("x,z\n1,2\n", ["a column time [s], or a feed"]),
        ("x,z,time\n1,2,0\n", ["2 to 2000 points"]),
        ("x,z,time\n1,2,0\n1,b,1\n1,nan,2\n", ["row 3: z", "row 4: z"]),
        ("x,z,time\n1,2,0\n1,2\n", ["row 3", "2 cells"]),
        ("x,z,time\n1,2,0\n1,3,0\n", ["row 3: time"]),
        ("x,z,time,fx\n1,2,0,1\n1,3,1,0\n", ["row 3", "fx, fy, fz"]),
    ],
)
def test_bad_tables(tmp_path, text, says):
    file = tmp_path / "path.csv"
    file.write_text(text)
    with pytest.raises(InvalidRequest) as caught:
        read_toolpath(file, planar=True)
    for word in (*says, "path.csv"):
        assert word in str(caught.value)
    with pytest.raises(InvalidRequest, match="no such file"):
        read_toolpath(tmp_path / "none.csv", planar=True)


def test_bad_requests(three):
    place = (1.0, 0.5)
    toolpath = line((1.1, 0.4), (0.8, 0.9), 3, 0.05)
    for build, says in (
        (lambda: line(place, place, 3, 0.1), "two places"),
        (lambda: line(place, (1.0, 0.6), 1, 0.1), "2 to 2000"),
        (lambda: line(place, (1.0, 0.6), 3, 0.0), "feed"),
        (lambda: line(place, (1.0, np.nan), 3, 1.0), "finite"),
        (lambda: arc((0.0, 0.0), (1.0, 0.0), (2.0, 0.0), 3, 0.1), "span a circle"),
        (lambda: PathProblem.along(three, toolpath, 5.0, force=(0.0, 1.0, 0.0)), "inside the plane"),
        (lambda: PathProblem.along(three, toolpath, 5.0, way="best"), "sum or worst"),
        (lambda: PathProblem.along(three, toolpath, 5.0, speed=np.zeros(3)), "speed above 0"),
        (lambda: PathProblem.along(three, toolpath, 5.0, stride=0.0), "stride"),
        (lambda: PathProblem.along(three, toolpath, 5.0, smoothness=-1.0), "smoothness"),
    ):
        with pytest.raises(InvalidRequest, match=says):
            build()
    with pytest.raises(Unreachable, match="nearest was"):
        plan_path(PathProblem.along(three, line((2.0, 0.0), (3.0, 0.0), 3, 0.05), 5.0), nodes=4)


@pytest.mark.slow
def test_command(capsys, tmp_path):
    from flexmodal.cli.main import main

    out = tmp_path / "path.csv"
    words = [
        "path",
        "six_link",
        "--line=-2.5,1.5:-2.4,1.6",
        "--points",
        "3",
        "--feed",
        "0.05",
        "--nodes",
        "4",
    ]
    with pytest.raises(SystemExit) as left:
        main([*words, "--frequency", "5", "--compare", "--json", "--out", str(out)])
    assert left.value.code == 0
    found = json.loads(capsys.readouterr().out)
    keys = {"unit", "sum", "worst", "fastest", "deviation", "points", "collisions", "compare"}
    assert set(found) == keys
    assert set(found["compare"]) <= {"greedy", "static stiffness"}
    assert len(found["points"]) == 3
    assert sum(point["value"] for point in found["points"]) == pytest.approx(found["sum"])
    table = np.genfromtxt(out, delimiter=",", names=True)
    np.testing.assert_allclose(table["value"], [point["value"] for point in found["points"]])
    np.testing.assert_allclose(table["x"], [-2.5, -2.45, -2.4], atol=1e-9)
    for rest, says in (
        ([], "exactly one of"),
        (["--line=0,1:1,0", "--arc=0,1:1,0:1,1"], "exactly one of"),
        (["--line=0,1:1,0"], "--feed"),
        (["--line=0,1", "--feed", "1"], "1 places"),
        (["--line=0,1:1,0", "--feed", "1", "--push", "0,0,0"], "--push"),
        (["--line=0,1:1,0", "--feed", "1", "--speed", "q9=1"], "q9"),
    ):
        with pytest.raises(SystemExit) as left:
            main(["path", "six_link", "--frequency", "5", *rest])
        assert left.value.code == 2
        assert says in capsys.readouterr().err
