"""A posture search on its page: the descent on a slider, the optima a click away."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest
from flexmodal_viewer import show_outcome
from playwright.sync_api import expect

from flexmodal.frf import PointDirection
from flexmodal.model import load
from flexmodal.optimisation import Hold, Optimum, Outcome, PostureProblem, ReceptanceObjective, Start
from flexmodal.optimisation.pictures.traces import follow

_SPEC = importlib.util.spec_from_file_location("live_pages", Path(__file__).with_name("live.py"))
live = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(live)


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
    )


def test_the_film_goes_from_the_start_to_the_optimum(arm, outcome, tmp_path):
    start = outcome.compared.held
    page = show_outcome(outcome, start=start, out=tmp_path / "page.html", announce=lambda _: None)
    trace = follow(outcome.problem, start)
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
