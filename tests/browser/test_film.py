"""A posture search on its page: the descent on a slider, the optima a click away."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest
from flexmodal_viewer import show_outcome
from flexmodal_viewer.units import quantity
from playwright.sync_api import expect

from flexmodal.frf import PointDirection
from flexmodal.model import load
from flexmodal.optimisation import Hold, Optimum, Outcome, PostureProblem, ReceptanceObjective, Start
from flexmodal.optimisation.pictures.traces import follow
from flexmodal.optimisation.search import random_starts

_SPEC = importlib.util.spec_from_file_location("live_pages", Path(__file__).with_name("live.py"))
live = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(live)


STICKS = """() => {
  const drawn = flexmodalPage.node("/flexmodal/sticks").children[0];
  const matrix = drawn.matrix.clone();
  return Array.from({ length: drawn.count }, (_, k) => {
    drawn.getMatrixAt(k, matrix);
    const e = matrix.elements; // the middle, and half the way to the end, of each stick
    return [e[12] + e[4] / 2, e[13] + e[5] / 2, e[14] + e[6] / 2];
  });
}"""


@pytest.fixture(scope="module")
def arm():
    return load("six_link")


@pytest.fixture(scope="module")
def outcome(arm):
    """Two postures as optima, the one that a descent from the start reaches and one made up."""
    judge = ReceptanceObjective((PointDirection("tool", "z"),), np.array([5.0]))
    problem = PostureProblem(arm, judge, Hold.at(arm, (-2.0, 2.0)))
    start = arm.posture("start_2")
    trace = follow(problem, start)
    best = arm.posture(dict(zip(arm.commanded, map(float, trace.values[-1]), strict=True)))
    held = arm.posture(dict(zip(arm.commanded, map(float, trace.values[0]), strict=True)))
    first = float(trace.objective[0])
    return Outcome(
        problem=problem,
        optima=(Optimum(best, float(trace.objective[-1]), 3), Optimum(held, first, 1)),
        compared=Start(start, first, 0.0, held, first),
        converged=True,
        starts=4,
        unbounded=0,
        method="newton",
        tried=2,
        seed=3,
    )


@pytest.mark.slow
def test_the_film_goes_from_the_start_to_the_optimum(arm, outcome, tmp_path):
    start, problem = outcome.compared.held, outcome.problem
    page = show_outcome(outcome, start=start, out=tmp_path / "page.html", announce=lambda _: None)
    drawn = random_starts(problem, 1, np.random.default_rng(3))
    traces = [follow(problem, one) for one in (start, *(problem.posture(vector) for vector in drawn))]
    trace, most = traces[0], max(len(one.values) for one in traces) - 1
    with live.chromium() as browser, live.opened(browser, page) as tab:
        names = list(arm.commanded)

        def values():
            return np.array(tab.evaluate("flexmodalLive.state.q"), dtype=float)

        def slide(step):
            tab.locator("#step").evaluate(
                "(range, at) => { range.value = at; range.dispatchEvent(new Event('input')); }", step
            )

        assert values() == pytest.approx([outcome.best.posture.values[name] for name in names])
        for step in (0, len(trace.values) // 2, len(trace.values) - 1):
            slide(step)
            assert values() == pytest.approx(trace.values[step], abs=1e-12)
            size = tab.evaluate("Math.hypot(...flexmodalLive.found().value)")
            assert size == pytest.approx(trace.objective[step], rel=1e-6)  # the search's own smooth size
        assert tab.evaluate("flexmodalLive.film.descents.length") == 2
        for number, one in enumerate(traces):
            tab.locator("#film-of").select_option(str(number))
            for step in (1, most):  # a descent that has ended stays
                slide(step)
                assert values() == pytest.approx(one.values[min(step, len(one.values) - 1)], abs=1e-12)
        ends = tab.evaluate("flexmodalLive.film.descents.map((one) => one.end)")
        last = [
            problem.objective.value(arm.at(dict(zip(names, one.values[-1], strict=True)))) for one in traces
        ]
        near = [abs(value / outcome.best.objective - 1) < 1e-5 for value in last]
        assert ends[0] == 0
        assert [end == 0 for end in ends] == near
        sticks = tab.evaluate(STICKS)
        assert len(sticks) == 2 * (len(arm.moving) + 1)
        ends = np.array(sticks).reshape(2, -1, 3)
        for number, one in enumerate(traces[:-1]):  # the last is the arm itself
            tool = arm.at(dict(zip(names, one.values[-1], strict=True))).position("tool")
            assert np.linalg.norm(ends[number, -1] - tool) < 1e-5
        assert tab.evaluate("flexmodalPage.node('/flexmodal/sticks').visible")
        tab.locator("#film-all").uncheck()
        assert not tab.evaluate("flexmodalPage.node('/flexmodal/sticks').visible")
        tab.locator("#film-of").select_option("0")
        ghosts = tab.locator("#labels .mark").all_inner_texts()
        value = quantity(float(trace.objective[0]), "m/N")
        assert {f"start: {value}", f"optimum 2: {value}"} <= set(ghosts)
        slide(0)
        tab.get_by_role("button", name="Play").click()
        expect(tab.get_by_role("button", name="Stop")).to_be_visible()
        expect(tab.locator("#step")).not_to_have_value("0", timeout=20_000)
        tab.get_by_role("button", name="go to optimum 2").click()  # which ends the film
        tab.wait_for_timeout(100)
        assert values() == pytest.approx([start.values[name] for name in names])
        assert tab.locator("#optima td").all_inner_texts()[1::2] == ["3", "1"]
        pinned = tab.locator("#chart .curve.pinned").get_attribute("d")
        assert pinned == tab.locator("#chart .curve.live").get_attribute("d")  # it stands at the start again


@pytest.mark.slow
def test_the_self_motion_shows_the_objective(arm, tmp_path):
    """Of several directions and frequencies, at the posture found, beside Python's."""
    ways = tuple(PointDirection("tool", axis) for axis in "xz")
    judge = ReceptanceObjective(ways, np.array([3.0, 5.0]), "force", (1.0, 2.0), line_weights=(1.0, 0.5))
    problem = PostureProblem(arm, judge, Hold.at(arm, (-2.0, 2.0)))
    held = arm.posture("e6_final")
    found = Outcome(problem, (Optimum(held, judge.value(arm.at(held)), 1),), None, True, 1, 0, "newton")
    page = show_outcome(found, start=None, out=tmp_path / "page.html", announce=lambda _: None)
    with live.chromium() as browser, live.opened(browser, page) as tab:
        assert tab.get_by_label("hold place").is_checked()
        tab.wait_for_selector("#self-motion:not([hidden])")
        said = tab.locator("#objective-says").inner_text()
        assert said.startswith("The search's objective along the self-motion: here ")
        way = tab.evaluate("flexmodalLive.motionOf.way().map(({ q }) => [...q])")
        sizes = tab.evaluate("flexmodalLive.motionOf.sizes()")
        for q, value in list(zip(way, sizes, strict=True))[:: len(way) // 5]:
            posed = arm.at(dict(zip(arm.moving, map(float, q), strict=True)))
            assert value == pytest.approx(judge.value(posed), rel=1e-9)
        tab.locator("#judge").select_option("size")
        expect(tab.locator("#objective-says")).to_contain_text("|α| along the self-motion")
