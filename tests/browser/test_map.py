"""The map of the workspace: receptance over the places of the tool, the best posture a click away."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest
from flexmodal_viewer import show_robot
from matplotlib import colormaps

from flexmodal.frf import PointDirection
from flexmodal.model import load
from flexmodal.optimisation import Hold, PostureProblem, ReceptanceObjective, optimise

_SPEC = importlib.util.spec_from_file_location("live_pages", Path(__file__).with_name("live.py"))
live = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(live)

CLOSE = 1e-9
JUDGED = """() => flexmodalLive.map.map().places.map(({ at, known }, number) => {
  const { value, posed } = flexmodalLive.map.judged()[number];
  const least = Math.min(...known.map((one) => flexmodalLive.size(one)));
  return { at, value, q: posed.q, least };
})"""


@pytest.fixture(scope="module")
def browser():
    with live.chromium() as found:
        yield found


@pytest.fixture(
    scope="module",
    params=[
        ("six_axis", 5),
        pytest.param(("fanuc_s360", None), marks=pytest.mark.slow),
        pytest.param(("six_link", None), marks=pytest.mark.slow),
    ],
    ids=["six_axis, few places", "fanuc_s360", "six_link"],
)
def asked(request):
    """An arm, and how many cells go along the widest side."""
    return request.param


@pytest.fixture(scope="module")
def arm(asked):
    return load(asked[0])


@pytest.fixture(scope="module")
def tab(browser, arm, asked, tmp_path_factory):
    out = tmp_path_factory.mktemp("map") / "page.html"
    posture = next(iter(arm.postures))
    page = show_robot(arm, arm.posture(posture), workspace=True, out=out, announce=lambda _: None)
    fragment = "" if asked[1] is None else f"#cells={asked[1]}"
    with live.opened(browser, page, fragment, width=800, height=700) as found:
        settled(found)
        yield found


def settled(tab):
    tab.wait_for_selector("body:not(.busy)", timeout=90_000)


def posture(tab, arm, q=None):
    q = tab.evaluate("flexmodalLive.state.q") if q is None else q
    values = dict(zip(arm.moving, map(float, q), strict=True))
    return {name: values[name] for name in arm.commanded}


def size(arm, values, hertz):
    return float(np.abs(arm.at(values).frf([float(hertz)]).value[0, 0, 0]))


def test_every_place_has_the_value_that_python_computes(tab, arm, asked):
    for hertz in (None, 4.0):
        if hertz is not None:
            tab.locator("#map-hertz").evaluate(
                "(range) => { range.value = 4; range.dispatchEvent(new Event('input')); }"
            )
            settled(tab)
        now = tab.evaluate("flexmodalLive.state.hertz")
        assert hertz is None or now == hertz
        places = tab.evaluate(JUDGED)
        assert len(places) > (300 if asked[1] is None else 40)
        for one in places[:: len(places) // 20]:
            values = posture(tab, arm, one["q"])
            assert np.linalg.norm(arm.at(values).position("tool") - one["at"]) < 2e-8
            assert one["value"] == pytest.approx(size(arm, values, now), rel=CLOSE)
            assert one["value"] == pytest.approx(one["least"], rel=1e-12)
            for name, joint in arm.commanded.items():
                assert joint.lower - 1e-12 <= values[name] <= joint.upper + 1e-12


def test_a_place_is_shown_in_the_colour_of_its_value(tab):
    said = tab.locator("#map-scale").get_attribute("aria-label")
    assert said.startswith("Colours: light is ")
    assert "m/N" in said
    assert "[m/N]" in tab.locator("#map-scale").text_content()
    stops = tab.locator("#map-scale rect").evaluate_all("(all) => all.map((x) => x.getAttribute('fill'))")
    for number in (0, 20, 59):  # cividis, to what its ninths leave
        wanted = 255 * np.array(colormaps["cividis"](1 - number / 59)[:3])
        found = [int(part) for part in stops[number].removeprefix("rgb(").removesuffix(")").split(",")]
        assert np.max(np.abs(wanted - found)) < 6


def test_a_click_on_a_place_brings_the_arm_to_its_best_posture(tab, arm):
    hertz = float(tab.evaluate("flexmodalLive.state.hertz"))
    numbers = [
        int(x) for x in tab.locator("#map-places option").evaluate_all("(all) => all.map((x) => x.value)")[1:]
    ]
    places = tab.evaluate(JUDGED)
    number = next(one for one in numbers[len(numbers) // 3 :] if np.linalg.norm(places[one]["at"]) > 0.5)
    at = tab.evaluate("(at) => flexmodalLive.picture.project(at)", places[number]["at"])
    tab.mouse.click(at["x"], at["y"])
    settled(tab)
    went = arm.at(posture(tab, arm)).position("tool")
    place = min(
        places, key=lambda one: np.linalg.norm(one["at"] - went)
    )  # in front, where several lie in line
    assert np.linalg.norm(place["at"] - went) < 2e-8
    found = size(arm, posture(tab, arm), hertz)
    assert found <= place["value"] * (1 + CLOSE)
    hold = Hold.at(arm, tuple(went[[0, 2]]) if arm.is_planar else tuple(went))
    judge = ReceptanceObjective((PointDirection("tool", "z"),), np.array([hertz]))
    best = optimise(PostureProblem(arm, judge, hold), starts=16).best.objective
    assert found < 1.05 * best
    assert "the best of 16 descents" in tab.locator("#map-says").inner_text()


def test_a_place_can_be_chosen_with_keys(tab, arm):
    tab.locator("#map-places").select_option(index=3)
    settled(tab)
    before = arm.at(posture(tab, arm)).position("tool")
    tab.locator("#map-places").focus()
    tab.keyboard.press("ArrowDown")
    settled(tab)
    assert np.linalg.norm(arm.at(posture(tab, arm)).position("tool") - before) > 0.05
    assert tab.locator("#map-says").get_attribute("role") == "status"
    tab.get_by_role("button", name="Hide the map").click()
    assert not tab.evaluate("flexmodalPage.node('/flexmodal/map').visible")
    tab.get_by_role("button", name="Show the map").click()
    assert tab.evaluate("flexmodalPage.node('/flexmodal/map').visible")
    settled(tab)


@pytest.mark.slow
def test_a_force_that_moves_nothing_has_a_map_too(browser, tmp_path):
    """Across the plane of a planar arm every receptance is zero."""
    arm = load("fanuc_s360")
    page = show_robot(
        arm, arm.posture("configuration_1"), out=tmp_path / "page.html", announce=lambda _: None
    )
    with live.opened(browser, page, "#map=1&cells=3") as tab:
        settled(tab)
        assert tab.locator("#map-slices").is_hidden()
        tab.locator("#reference-axis").select_option("+y")
        settled(tab)
        assert {one["value"] for one in tab.evaluate(JUDGED)} == {0}
        tab.locator("#map-places").select_option(index=1)
        settled(tab)
        assert ": 0 m/N, the best of " in tab.locator("#map-says").inner_text()
