"""A diagnosis gone through on its robot: gap, curves, points and place at each step."""

import importlib.util
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from flexmodal_viewer import diagnosis_scene, show_diagnosis
from playwright.sync_api import expect

from flexmodal.identification.frf_fit import residual
from flexmodal.report.words import size

_SPEC = importlib.util.spec_from_file_location("live_pages", Path(__file__).with_name("live.py"))
live = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(live)


TOLD = "JSON.parse(document.getElementById('robot').textContent).diagnosis"


@pytest.fixture(scope="module")
def browser():
    with live.chromium() as found:
        yield found


@pytest.fixture(scope="module")
def tab(browser, diagnosed, tmp_path_factory):
    out = tmp_path_factory.mktemp("diagnosis") / "page.html"
    page = show_diagnosis(diagnosed, out=out, announce=lambda _: None)
    with live.opened(browser, page, width=1000, height=800) as found:
        yield found


def curve(tab, kind):
    """Heights of a curve's points in the chart [pixels], by their places across."""
    drawn = tab.locator(f"#chart .curve.{kind}").get_attribute("d")
    return np.array([part.split(" ") for part in drawn[1:].replace("M", "L").split("L")], dtype=float)


def test_the_steps_go_from_the_card_to_the_effect(tab, diagnosed):
    gaps = diagnosed.gaps
    rows = tab.locator("#stages tbody tr").all_inner_texts()
    told = [gaps.believed, gaps.before, gaps.after, gaps.noise_floor]
    assert [row.split("\t")[1] for row in rows] == [size(gap) for gap in told]
    assert "link flexibility (link_2)" in rows[2]
    back, on = (tab.get_by_role("button", name=name, exact=True) for name in ("Back", "Next"))
    expect(back).to_be_disabled()
    mark = f"flexmodalPage.node('{tab.evaluate(TOLD)['marks'][0][0]}').visible"
    assert not tab.evaluate(mark)
    on.click()
    assert "re-tuned, nothing added" in tab.locator("#diagnosis-says").inner_text()
    before = curve(tab, "stage")
    on.click()
    expect(on).to_be_disabled()
    assert tab.evaluate(mark)
    assert "confidence 93 %" in tab.locator("#diagnosis-says").inner_text()
    assert np.array_equal(curve(tab, "stage-before"), before)  # the step before stays, dashed
    measured, after = curve(tab, "measured"), curve(tab, "stage")
    assert np.array_equal(measured[:, 0], after[:, 0])
    assert np.mean(np.abs(after - measured)[:, 1]) < 0.5 * np.mean(np.abs(before - measured)[:, 1])
    tab.get_by_role("button", name="step 1: the card as it came").click()
    own = curve(tab, "live")  # computed in the page, of the card
    stage = curve(tab, "stage")  # predicted in Python, on the lines that were measured
    apart = np.abs(np.interp(stage[:, 0], *own.T) - stage[:, 1])
    assert np.median(apart) < 0.2
    assert np.quantile(apart, 0.9) < 3


def test_points_have_the_colour_of_their_misfit(tab, diagnosed):
    seen = diagnosed.observations
    told = tab.evaluate(TOLD)
    for stage, predicted in diagnosed.predicted.items():
        far = np.where(seen.used, np.abs(residual(predicted, seen.value)) ** 2, 0.0)
        noise = np.where(seen.used, seen.variance, 0.0)
        for number, posture in enumerate(seen.postures):
            for point in seen.campaign.points:
                rows = (seen.posture == number) & (seen.response[:, 0] == point.id)
                if rows.any():
                    wanted = np.sqrt(far[rows].sum() / noise[rows].sum())
                    assert told["misfit"][stage][posture.name][point.name] == pytest.approx(wanted, rel=1e-3)
    colour = """(path) => {
      const at = flexmodalPage.node(path);
      let found = null;
      at.traverse((object) => { if (object.material) found = object.material.color.getHex(); });
      return found;
    }"""
    paths = [path for path, _ in told["points"]]
    before = [tab.evaluate(colour, path) for path in paths]
    tab.get_by_role("button", name="step 3").click()
    after = [tab.evaluate(colour, path) for path in paths]
    assert before != after
    last = told["misfit"]["after"][told["pairs"][0]["posture"]]
    worst = max(last, key=last.get)
    said = tab.locator("#diagnosis-far").inner_text()
    assert said == f"Farthest in this posture: {worst}, {float(f'{last[worst]:.3g}'):g} × the noise."


def test_another_frf_moves_the_arm_to_its_posture(tab, diagnosed):
    pairs = tab.evaluate(TOLD)["pairs"]
    names = list(diagnosed.model.context.robot.moving)
    for number in range(len(pairs)):
        tab.locator("#diagnosis-pair").select_option(str(number))
        q = tab.evaluate("flexmodalLive.state.q")
        assert dict(zip(names, q, strict=True)) == pytest.approx(pairs[number]["q"])
        assert tab.locator("#reference").input_value() == pairs[number]["reference"].rpartition(":")[0]
        assert tab.locator("#chart .curve.measured").count() == 1
    bands = [band for pair in pairs for band in pair["bands"]["before"]]
    assert [band["says"] for band in bands] == [one.says for one in diagnosed.disagreement][: len(bands)]


def test_of_modes_alone_the_steps_have_their_gaps(browser, diagnosed, tmp_path):
    alone = replace(diagnosed, frfs=None, predicted={})
    page = show_diagnosis(alone, out=tmp_path / "page.html", announce=lambda _: None)
    with live.opened(browser, page) as tab:
        tab.get_by_role("button", name="step 3").click()
        assert size(diagnosed.gaps.after) in tab.locator("#diagnosis-says").inner_text()
        assert tab.locator("#step-pair").is_hidden()


def test_names_of_a_diagnosis_harm_nothing(browser, diagnosed, tmp_path):
    hostile = "</script><img src=x onerror=alert(1)>\"'"
    verdict = replace(diagnosed.verdict, says=hostile)
    (step,) = diagnosed.steps
    named = replace(diagnosed, campaign=hostile, verdict=verdict, steps=(replace(step, where=hostile),))
    page = show_diagnosis(named, out=tmp_path / "page.html", announce=lambda _: None)
    with live.opened(browser, page, width=390) as tab:
        assert tab.locator("#diagnosis-verdict").inner_text() == hostile
        assert hostile in tab.locator("#stages").inner_text()
        assert tab.locator("img").count() == 0
        assert tab.evaluate("document.documentElement.scrollWidth <= innerWidth")


@pytest.mark.slow
def test_each_effect_is_a_step(diagnosed):
    (first,) = diagnosed.steps
    second = replace(first, effect="added_mass", where="link_3", confidence=0.99)
    predicted = {**diagnosed.predicted, "step 1": diagnosed.predicted["before"]}
    told = diagnosis_scene(replace(diagnosed, steps=(first, second), predicted=predicted)).live["diagnosis"]
    assert [one["key"] for one in told["stages"]] == ["believed", "before", "step 1", "after"]
    assert [one["marks"] for one in told["stages"]] == [0, 0, 1, 2]
    assert [one["gap"] for one in told["stages"][2:]] == [size(first.gaps.after), size(diagnosed.gaps.after)]
    assert all(set(pair["stages"]) == set(predicted) for pair in told["pairs"])
    assert [len(paths) for paths in told["marks"]] == [1, 1]
