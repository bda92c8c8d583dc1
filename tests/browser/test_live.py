"""The live page under somebody's hands: sliders, the tool, clicks, keys, small and dark windows."""

import importlib.util
import io
import json
import tomllib
from pathlib import Path

import numpy as np
import pytest
import yaml
from flexmodal_viewer import close_all, show_robot
from PIL import Image
from playwright.sync_api import expect

from flexmodal.campaign import Campaign, CampaignPoint, CampaignPosture, FrfRecords, Trial
from flexmodal.model import load

_SPEC = importlib.util.spec_from_file_location("live_pages", Path(__file__).with_name("live.py"))
live = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(live)

HOSTILE = "</script><script>alert(1)</script><img src=x onerror=alert(2)>\"'"
NAMES = ["q1", "q2", "q3", "q4", "q5", "q6"]


@pytest.fixture(scope="module")
def browser():
    with live.chromium() as found:
        yield found


@pytest.fixture(scope="module")
def arm():
    return load("six_axis")


@pytest.fixture(scope="module")
def page(arm, tmp_path_factory):
    out = tmp_path_factory.mktemp("live") / "page.html"
    return show_robot(arm, arm.posture("work"), out=out, announce=lambda _: None)


@pytest.fixture
def tab(browser, page):
    with live.opened(browser, page) as found:
        yield found


def stage(tab):
    """Pixels of the picture."""
    tab.wait_for_timeout(150)
    return np.asarray(Image.open(io.BytesIO(tab.locator("#stage").screenshot())).convert("RGB")).astype(int)


def joints(tab):
    return dict(zip(NAMES, map(float, tab.evaluate("flexmodalLive.state.q")), strict=True))


def slide(tab, number, value):
    """What the browser does when a slider is dragged."""
    drag(tab, f"#joint-{number}", value)


def drag(tab, place, value):
    """Put a slider somewhere."""
    tab.locator(place).evaluate(
        "(range, value) => { range.value = value; range.dispatchEvent(new Event('input')); }", value
    )


def off(re, im, wanted):
    """How far numbers of the page are from Python's, beside the largest of these."""
    return np.max(np.abs(np.array(re) + 1j * np.array(im) - wanted)) / np.max(np.abs(wanted))


def test_a_slider_moves_the_arm_and_the_curve(tab, arm):
    before = stage(tab)
    drawn = tab.locator("#chart .curve.live").get_attribute("d")
    slide(tab, 1, 0.9)
    assert np.mean(np.any(np.abs(stage(tab) - before) > 40, axis=2)) > 0.02
    assert tab.locator("#chart .curve.live").get_attribute("d") != drawn
    assert tab.locator("#joint-1").get_attribute("aria-valuetext") == "51.6°"
    lines, re, im = tab.evaluate(
        "(({ curve, lines }) => [lines, curve.re, curve.im].map((x) => [...x]))(flexmodalLive.found())"
    )
    assert len(lines) == 400
    assert off(re, im, arm.at(joints(tab)).frf(lines).value[:, 0, 0]) < 1e-9
    shown = tab.locator("#modes tbody td:nth-child(2)").all_inner_texts()
    assert shown == [f"{value:.4g} Hz" for value in arm.modes(joints(tab)).frequency]


def test_a_click_on_the_curve_swings_the_arm_as_it_does_there(tab, arm):
    box = tab.locator("#chart").bounding_box()
    tab.mouse.click(box["x"] + 0.33 * box["width"], box["y"] + 0.6 * box["height"])
    assert tab.evaluate("flexmodalLive.state.swing.mode") is None
    hertz = tab.evaluate("flexmodalLive.state.hertz")
    assert 20 < hertz < 45
    shape = tab.evaluate("(({ re, im }) => [[...re], [...im]])(flexmodalLive.motion().shape)")
    posed = arm.at(joints(tab))
    system, s = posed.system, 2j * np.pi * hertz
    stiff = system.stiffness + s * system.damping + s**2 * system.mass
    assert off(*shape, np.linalg.solve(stiff, posed.jacobian("tool")[2])) < 1e-9
    assert f"Operating deflection at {hertz:.4g} Hz" in tab.locator("#swing-says").inner_text()
    pictures = []
    for phase in (0.5, 2.1):
        tab.evaluate("(phase) => { flexmodalLive.state.phase = phase; flexmodalLive.stand(); }", phase)
        pictures.append(stage(tab))
    assert np.mean(np.any(np.abs(pictures[0] - pictures[1]) > 30, axis=2)) > 0.005


def test_a_click_on_a_peak_chooses_the_mode_and_shows_its_energy(tab, arm):
    box = tab.locator("#chart").bounding_box()
    at = tab.locator("text.peak").nth(2).bounding_box()
    tab.mouse.click(at["x"] + at["width"] / 2, box["y"] + 60)
    assert tab.evaluate("flexmodalLive.state.swing.mode") == 2
    modes = arm.modes(joints(tab))
    assert tab.evaluate("flexmodalLive.state.hertz") == pytest.approx(modes.frequency[2], rel=1e-9)
    shape, stiffness = modes.shape[:, 2], np.diag(arm.stiffness)
    energy = stiffness * np.abs(shape) ** 2
    shares = [f"{round(100 * value)} %" for value in energy / energy.sum()]
    assert tab.locator(".joint .share").all_inner_texts() == shares
    assert tab.get_by_role("button", name="swing in mode 3").get_attribute("aria-pressed") == "true"
    tab.get_by_role("button", name="Rest").click()
    assert tab.evaluate("flexmodalLive.motion()") is None


def test_the_tool_follows_the_pointer(tab):
    where = "flexmodalLive.picture.project(flexmodalLive.posed().position('tool'))"
    at = tab.evaluate(where)
    tab.mouse.move(at["x"], at["y"])
    tab.mouse.down()
    tab.mouse.move(at["x"] + 30, at["y"] - 40, steps=5)
    tab.mouse.up()
    now = tab.evaluate(where)
    assert (now["x"] - at["x"], now["y"] - at["y"]) == pytest.approx((30, -40), abs=0.1)


def test_a_joint_moves_and_the_tool_stays(tab, arm):
    before = arm.at(joints(tab))
    tab.get_by_label("hold place").check()
    slide(tab, 2, joints(tab)["q3"] + 0.1)
    after = arm.at(joints(tab))
    assert joints(tab)["q3"] == pytest.approx(before.posture.values["q3"] + 0.1, abs=1e-12)
    assert np.linalg.norm(after.position("tool") - before.position("tool")) < 1e-8
    tab.wait_for_selector("#self-motion:not([hidden])")
    least = float(tab.locator("#along").get_attribute("min"))
    drag(tab, "#along", least / 2)
    moved = arm.at(joints(tab))
    assert max(abs(moved.posture.values[name] - after.posture.values[name]) for name in NAMES) > 0.1
    assert np.linalg.norm(moved.position("tool") - before.position("tool")) < 1e-8


def test_a_wrist_of_six_joints_cannot_move_with_the_tool_held_altogether(tab):
    tab.get_by_label("and turn").check()
    expect(tab.locator("#hold-says")).to_have_text("No joint can move while the tool is held so.")


def test_the_tool_goes_where_its_numbers_say(tab, arm):
    tab.locator("#place input").nth(2).fill("0.7")
    tab.locator("#place input").nth(2).press("Enter")
    assert arm.at(joints(tab)).position("tool")[2] == pytest.approx(0.7, abs=1e-8)


def test_everything_goes_with_keys(tab):
    tab.locator("#joint-0").focus()
    tab.keyboard.press("ArrowRight")
    tab.keyboard.press("Shift+ArrowRight")
    assert joints(tab)["q1"] == pytest.approx(np.deg2rad(11), abs=1e-12)
    tab.locator("#chart").focus()
    tab.keyboard.press("Home")
    assert tab.evaluate("flexmodalLive.state.hertz") == 0
    tab.keyboard.press("PageUp")
    chart = tab.locator("#chart")
    assert float(chart.get_attribute("aria-valuenow")) == pytest.approx(10 * 115 / 399)
    assert "hertz" in chart.get_attribute("aria-valuetext")
    nameless = tab.evaluate(
        """[...document.querySelectorAll("#live input, #live select, #live button, #live textarea")]
           .filter((x) => !x.labels?.length && !x.ariaLabel && !x.textContent).map((x) => x.outerHTML)"""
    )
    assert nameless == []


def test_the_posture_can_be_kept(tab):
    slide(tab, 4, -1.25)
    values = joints(tab)
    texts = {}
    for kind in ("toml", "yaml", "json", "typed"):
        tab.locator(f"[data-keep={kind}]").click()
        texts[kind] = tab.locator("#kept").input_value()
    assert tomllib.loads(texts["toml"])["posture"]["kept"] == values
    state = yaml.safe_load(texts["yaml"])
    assert dict(zip(state["name"], state["position"], strict=True)) == values
    assert json.loads(texts["json"])["posture"] == values
    typed = (part.split("=") for part in texts["typed"].split(","))
    assert {name: float(value) for name, value in typed} == values


def test_a_picture_in_software_is_rough_only_while_it_moves(tab):
    ratio = "viewer.renderer.getPixelRatio()"
    assert tab.evaluate("flexmodalPage.software")  # SwiftShader draws here
    tab.wait_for_timeout(400)
    assert tab.evaluate(ratio) == 2
    now = tab.evaluate(f"() => {{ flexmodalLive.moveJoint(1, 0.3); return {ratio}; }}")
    assert now == 2  # what moves once need not be quick
    now = tab.evaluate(
        f"() => {{ for (let k = 0; k < 3; k++) flexmodalLive.moveJoint(1, 0.1 * k); return {ratio}; }}"
    )
    assert now == 0.6
    tab.wait_for_timeout(600)
    assert tab.evaluate(ratio) == 2


def test_a_pinned_curve_stays(tab):
    tab.get_by_role("button", name="Pin curve").click()
    before = tab.locator("#chart .curve.pinned").get_attribute("d")
    slide(tab, 1, 0.4)
    assert tab.locator("#chart .curve.pinned").get_attribute("d") == before
    assert tab.locator("#chart .curve.live").get_attribute("d") != before


@pytest.mark.parametrize(("width", "height"), [(390, 844), (1280, 720)])
def test_small_and_dark_windows(browser, page, width, height):
    with live.opened(browser, page, "#mode=2&phase=0.2", width=width, height=height, dark=True) as tab:
        assert tab.evaluate("document.documentElement.scrollWidth <= innerWidth")
        broken = tab.evaluate(
            "[...document.querySelectorAll('.joint .name')].filter((x) => x.offsetHeight > 24).length"
        )
        assert broken == 0
        picture = stage(tab)
        assert picture[3, 3].max() < 40
        assert (picture.max(axis=2) > 120).mean() > 0.02
        ink, ground = tab.evaluate(
            "[getComputedStyle(document.body).color, getComputedStyle(document.body).backgroundColor]"
            ".map((c) => c.match(/\\\\d+/g).map(Number))".replace("\\\\", "\\")
        )
        assert min(ink) - max(ground) > 150


def test_the_address_sets_posture_and_swing(browser, page, arm):
    with live.opened(browser, page, "#q=q2:0.5,q3:9,nobody:1&frequency=30&phase=0.25") as tab:
        found = joints(tab)
        assert found["q2"] == 0.5
        assert found["q3"] == arm.commanded["q3"].upper  # not beyond its limit
        assert tab.evaluate("flexmodalLive.state.hertz") == 30
        assert tab.evaluate("flexmodalLive.state.playing") is False


def test_hostile_names_are_text(browser, tmp_path):
    text = (Path(__file__).parents[2] / "urdf" / "six_axis.urdf").read_text()
    name = HOSTILE.replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;").replace("'", "&apos;")
    urdf = tmp_path / "hostile.urdf"
    urdf.write_text(text.replace('"q2"', f'"{name}"').replace('"q3"', f'"{"q" * 300}"'))
    robot = load(urdf, stiffness=1e5, damping=10.0)
    path = show_robot(robot, robot.posture({}), out=tmp_path / "page.html", announce=lambda _: None)
    with live.opened(browser, path) as tab:
        assert HOSTILE in tab.locator(".joint .name").all_inner_texts()
        assert tab.locator("img").count() == 0
        assert tab.evaluate("document.documentElement.scrollWidth <= innerWidth")
        tab.locator("[data-keep=toml]").click()
        assert HOSTILE in tomllib.loads(tab.locator("#kept").input_value())["posture"]["kept"]


@pytest.fixture
def compared(tmp_path):
    """Two cards and a campaign whose FRFs are those of a third, so that the curves have to differ."""
    arm, other = load("fanuc_s360"), load("fanuc_s360_table_2_8")
    measured = load("fanuc_s360_rigid_link")
    where = arm.posture("configuration_1")
    lines = np.arange(2.0, 60.0, 0.5)
    points = (CampaignPoint(1, "location_1", "link_3", (0.23, 0.0, 0.0)),)
    value = measured.at(where.values).frf(lines, response="location_1:+z").value[:, 0, 0]
    records = FrfRecords(
        frequency=lines,
        value=value[None],
        posture=np.array([1]),
        trial=np.array([1]),
        response=np.array([[1, 3]]),
        reference=np.array([[1, 3]]),
        form="receptance",
        coherence=None,
    )
    campaign = Campaign(
        title="made by hand",
        robot="fanuc_s360",
        band=(2.0, 60.0),
        postures=(CampaignPosture(1, "configuration_1", dict(where.values)),),
        points=points,
        trials=(Trial(1, 100.0, 3, "steel"),),
        frfs=records,
    )
    asked = {"response": "location_1:+z", "others": {"other": other}, "measured": campaign}
    show_robot(arm, where, out=tmp_path / "page.html", announce=lambda _: None, **asked)
    return tmp_path / "page.html", other, lines, np.abs(value)


def test_other_models_and_measurements_stand_on_the_same_axes(browser, compared):
    page, other, lines, sizes = compared
    with live.opened(browser, page) as tab:
        names = tab.locator("#curve-legend li").all_inner_texts()
        assert names == ["fanuc_s360", "other", "measured"]
        theirs = "flexmodalLive.others[0].robot"
        found = tab.evaluate(
            f"(({{ at }}, d) => {theirs}.at(flexmodalLive.state.q).frf([9, 50], d, d).re)"
            f"({theirs}, {theirs}.direction('location_6:+z'))"
        )
        wanted = other.at("configuration_1").frf([9.0, 50.0], response="location_6:+z").value[:, 0, 0].real
        assert list(found) == pytest.approx(wanted, rel=1e-9, abs=0)
        assert tab.locator("#chart .curve.measured").count() == 1
        drawn = tab.evaluate("JSON.parse(document.getElementById('robot').textContent).measured[0]")
        assert drawn["sizes"] == pytest.approx(sizes, rel=1e-3)
        assert drawn["frequencies"] == pytest.approx(lines)
        slide(tab, 0, 1.2)  # nothing was measured there
        assert tab.locator("#chart .curve.measured").count() == 0
        tab.locator("#postures").select_option(label="configuration_1 (measured)")
        assert tab.locator("#chart .curve.measured").count() == 1


def test_a_served_page_shows_pythons_curve(browser, arm):
    url = show_robot(arm, arm.posture("work"), open_browser=False, announce=lambda _: None, block=False)
    try:
        said, asked = [], []
        tab = browser.new_page(viewport={"width": 700, "height": 500}, reduced_motion="reduce")
        tab.on("console", lambda message: said.append(message.text))
        tab.on("request", lambda request: asked.append(request.url))
        tab.goto(url)
        expect(tab.locator("#python-says")).to_contain_text("Python's curve")
        slide(tab, 1, 0.8)
        tab.wait_for_timeout(500)
        lines, re, im = tab.evaluate(
            "(({ curve, lines }) => [lines, curve.re, curve.im].map((x) => [...x]))(flexmodalLive.found())"
        )
        wanted = arm.at(joints(tab)).frf(lines).value[:, 0, 0]
        assert off(re, im, wanted) < 1e-14  # Python's own, through JSON
        assert tab.evaluate("flexmodalLive.state.python.off") < 1e-9
        assert said == []
        assert all(address.startswith((url, "blob:", "data:")) for address in asked)
        tab.close()
    finally:
        close_all()


@pytest.mark.slow
def test_a_warning_goes_with_another_address(arm):
    said = []
    where = {"open_browser": False, "announce": said.append, "block": False, "host": "127.0.0.2"}
    try:
        url = show_robot(arm, arm.posture("work"), **where)
    finally:
        close_all()
    assert url.startswith("http://127.0.0.2:")
    assert said[0].startswith("Warning: whoever can reach 127.0.0.2")
