"""The stabilisation diagram of a fit's page under somebody's hands: its numbers are Python's, its file
repeats."""

import contextlib
import importlib.util
import io
import json
import re
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import expect

from flexmodal.campaign import (
    Campaign,
    CampaignPoint,
    CampaignPosture,
    FrfRecords,
    Trial,
    read_campaign,
    write_campaign,
)
from flexmodal.cli.main import main
from flexmodal.ema import Choices, fit, records_of
from flexmodal.ema.live import choosing
from flexmodal.ema.page import write_fit_page

_SPEC = importlib.util.spec_from_file_location("live_pages", Path(__file__).with_name("live.py"))
live = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(live)

HOSTILE = "</script><script>alert(1)</script><img src=x onerror=alert(2)>"
AXIS = np.arange(5.0, 120.1, 0.25)
READY = ".live tbody tr"
ROOT = "document.querySelector('[data-live]')"
PANEL = "document.querySelectorAll('.posture')"


def frfs(shift, rng):
    """Mobilities of four points under two hammers: five modes, two of them close, noise of half a per
    cent."""
    frequency = np.array([20.0, 41.0, 44.0, 70.0, 95.0]) * shift
    damping = np.array([0.02, 0.02, 0.025, 0.03, 0.015])
    omega = 2 * np.pi * frequency
    shapes = np.random.default_rng(5).normal(size=(4, 5))
    hammers = np.random.default_rng(6).normal(size=(2, 5))
    s = 2j * np.pi * AXIS[:, None, None, None]
    value = (np.einsum("om,im->oim", shapes, hammers) * s / (omega**2 + s**2 + 2 * damping * omega * s)).sum(
        -1
    )
    value = value.reshape(len(AXIS), 8)
    noise = 0.005 * np.abs(value).max(axis=0)
    return (value + noise * (rng.normal(size=value.shape) + 1j * rng.normal(size=value.shape))).T


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    rng = np.random.default_rng(1)
    place = [(out, 3, into, 3) for out in (1, 2, 3, 4) for into in (1, 2)]
    records = FrfRecords(
        frequency=AXIS,
        value=np.concatenate([frfs(1.0, rng), frfs(1.05, rng)]),
        form="mobility",
        posture=np.repeat([1, 2], 8),
        trial=np.ones(16, dtype=int),
        response=np.tile([one[:2] for one in place], (2, 1)),
        reference=np.tile([one[2:] for one in place], (2, 1)),
        coherence=None,
    )
    made = Campaign(
        title=f"chosen {HOSTILE}",
        robot="none",
        band=(5.0, 120.0),
        postures=(CampaignPosture(1, f"one {HOSTILE}", {}), CampaignPosture(2, "two", {})),
        points=tuple(CampaignPoint(k, f"point {k}", "beam", (0.1 * k, 0.0, 0.0)) for k in (1, 2, 3, 4)),
        trials=(Trial(1, 100.0, 3, "soft"),),
        frfs=records,
    )
    return write_campaign(made, tmp_path_factory.mktemp("chosen") / "campaign")


def run(*arguments):
    """What a command prints; it has to succeed."""
    out, said = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(said), pytest.raises(SystemExit) as end:
        main([str(one) for one in arguments])
    assert not end.value.code, said.getvalue()
    return out.getvalue()


@pytest.fixture(scope="module")
def page(campaign, tmp_path_factory):
    """As the command writes it, but for the pictures, which take their time."""
    out = tmp_path_factory.mktemp("page") / "fit.html"
    measured = read_campaign(campaign)
    choices = Choices(vary=False)
    fits = fit(measured, per="posture", choices=choices)
    live_part = choosing(fits, records_of(measured), measured, choices)
    write_fit_page(fits, (), (), measured, out, live=live_part)
    return out


@pytest.fixture(scope="module")
def browser():
    with live.chromium() as found:
        yield found


@pytest.fixture
def tab(browser, page):
    with live.opened(browser, page, ready=READY, width=1200, height=900) as found:
        yield found


def chosen(tab, posture=0):
    return tab.evaluate(f"{PANEL}[{posture}].flexmodal.chosen()")


def saved(tab, folder):
    with tab.expect_download() as waiting:
        tab.get_by_role("button", name="Save the choice").click()
    path = folder / "choice.toml"
    waiting.value.save_as(path)
    assert path.read_text(encoding="utf-8") == tab.evaluate(f"{ROOT}.choice()")
    return path


def agrees(tab, campaign, choice):
    """Residues and residual terms of the page against those of `fit --choice`, for both postures."""
    rows = json.loads(run("fit", campaign, "--choice", choice, "--json"))["modes"]
    for number in (0, 1):
        poles = chosen(tab, number)
        theirs = tab.evaluate(f"{PANEL}[{number}].flexmodal.fit()")
        ours = [row for row in rows if row["posture"] == number + 1]
        assert len(ours) == len(poles) * len(theirs)
        for mode, (frequency, damping) in enumerate(poles):
            some = [row for row in ours if row["mode"] == mode + 1]
            assert {row["frequency"] for row in some} == {frequency}
            assert {row["damping_ratio"] for row in some} == {damping}
            here = np.array([row["residue"] for row in some]) @ [1, 1j]
            there = np.array([frf["residue"][mode] for frf in theirs]) @ [1, 1j]
            np.testing.assert_allclose(there, here, rtol=1e-9, atol=1e-9 * np.abs(here).max())


def click_pole(tab, posture, frequency, *, least=0):
    """Click the stable pole nearest to a frequency, of that order or above; gives its pole."""
    panel = f"{PANEL}[{posture}].flexmodal"
    stable = tab.evaluate(f"{panel}.stable()")
    orders = tab.evaluate(f"{panel}.raw.pole.order")
    able = [one for one in stable if orders[one[0]] >= least]
    place, f, z = min(able, key=lambda one: abs(one[1] - frequency))
    across, down = tab.evaluate(f"{panel}.place({place})")
    diagram = tab.locator(".diagram").nth(posture)
    diagram.scroll_into_view_if_needed()
    box = diagram.bounding_box()
    tab.mouse.click(box["x"] + across * box["width"], box["y"] + down * box["height"])
    return [f, z]


def test_begins_with_the_modes_of_the_fit(tab, campaign):
    rows = json.loads(run("fit", campaign, "--per", "posture", "--no-vary", "--json"))["modes"]
    for number in (0, 1):
        found = sorted({(r["frequency"], r["damping_ratio"]) for r in rows if r["posture"] == number + 1})
        assert len(found) == 5
        np.testing.assert_allclose(chosen(tab, number), found, rtol=1e-12)


def test_numbers_are_pythons_and_the_file_repeats_them(tab, campaign, tmp_path):
    agrees(tab, campaign, saved(tab, tmp_path))


def test_a_pole_is_dropped_exchanged_and_chosen(tab, campaign, tmp_path):
    misfit = tab.evaluate(f"{PANEL}[0].flexmodal.misfit()")
    tab.get_by_role("button", name=re.compile("drop the mode at 70")).click()
    assert len(chosen(tab)) == 4
    assert tab.evaluate(f"{PANEL}[0].flexmodal.misfit()") > 1.3 * misfit
    expect(tab.locator(".said").first).to_contain_text("4 modes chosen")
    taken = click_pole(tab, 0, 70.0, least=20)
    assert taken in chosen(tab)
    assert tab.evaluate(f"{PANEL}[0].flexmodal.misfit()") < 1.1 * misfit
    other = click_pole(tab, 0, 20.0, least=30)  # of a mode that is chosen already: exchanged
    assert len(chosen(tab)) == 5
    assert other in chosen(tab)
    expect(tab.locator(".said").first).to_contain_text("in place of")
    agrees(tab, campaign, saved(tab, tmp_path))
    click_pole(tab, 0, 20.0, least=30)
    assert len(chosen(tab)) == 4
    tab.get_by_role("button", name="Back to the modes of the fit").first.click()
    assert len(chosen(tab)) == 5


def test_keys_alone_choose_and_drop(tab):
    diagram = tab.locator(".diagram").first
    tab.get_by_role("button", name="Drop all").first.click()
    assert chosen(tab) == []
    diagram.focus()
    tab.keyboard.press("ArrowRight")
    expect(tab.locator(".said").first).to_contain_text("not chosen")
    tab.keyboard.press("Enter")
    assert len(chosen(tab)) == 1
    tab.keyboard.press("ArrowRight")
    tab.keyboard.press("ArrowUp")
    tab.keyboard.press("Enter")
    first, second = chosen(tab)
    assert second[0] > 1.005 * first[0]
    tab.keyboard.press("Enter")
    assert chosen(tab) == [first]
    tab.get_by_text("All stable poles").first.click()
    boxes = tab.locator(".columns").first.get_by_role("checkbox")
    assert boxes.count() >= 5
    boxes.nth(boxes.count() - 1).focus()
    tab.keyboard.press("Space")
    assert len(chosen(tab)) == 2


def test_a_posture_without_modes_is_left_out(tab, tmp_path):
    tab.get_by_role("button", name="Drop all").nth(1).click()
    assert tab.locator(".live .note").inner_text().endswith("left out: Posture 2, two")
    assert "id = 2" not in saved(tab, tmp_path).read_text(encoding="utf-8")
    tab.get_by_role("button", name="Drop all").first.click()
    expect(tab.get_by_role("button", name="Save the choice")).to_be_disabled()


def test_names_are_no_markup(tab):
    """Hostile titles and postures run nothing: the fixture fails on any word of the console."""
    assert HOSTILE in tab.locator(".posture h3").first.inner_text()
    assert tab.locator(".live img").count() == 0


def test_no_other_script_may_run(browser, page):
    tab = browser.new_page()
    said = []
    tab.on("console", lambda message: said.append(message.text))
    tab.goto(page.as_uri())
    before = tab.title()
    tab.evaluate(
        "const one = document.createElement('script'); one.text = 'title = 1'; document.body.append(one)"
    )
    assert tab.title() == before
    assert any("Content Security Policy" in line for line in said)
    tab.close()


@pytest.mark.parametrize("dark", [False, True])
def test_looks_right_in_light_and_dark(browser, page, dark):
    with live.opened(browser, page, ready=READY, width=1200, height=900, dark=dark) as tab:
        ground = tab.evaluate("getComputedStyle(document.body).backgroundColor")
        for look in ("kind2", "kind1", "synthesised", "measured"):
            stroke = tab.evaluate(f"getComputedStyle(document.querySelector('.live path.{look}')).stroke")
            assert contrast(stroke, ground) >= 3, look


def contrast(one, other):
    """Of two colours, as WCAG counts it."""

    def luminance(text):
        parts = np.array([int(n) for n in re.findall(r"\d+", text)[:3]]) / 255
        linear = np.where(parts <= 0.03928, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
        return float(linear @ [0.2126, 0.7152, 0.0722])

    light, dim = sorted([luminance(one), luminance(other)], reverse=True)
    return (light + 0.05) / (dim + 0.05)


def test_print_keeps_the_pictures_and_leaves_the_tools(tab):
    tab.emulate_media(media="print")
    assert not tab.locator(".live .tools").first.is_visible()
    assert tab.locator(".live .diagram").first.is_visible()
    assert tab.locator(".live .curves").first.is_visible()


@pytest.mark.slow
def test_narrow_screens_scroll_the_pictures_alone(browser, page):
    with live.opened(browser, page, ready=READY, width=390, height=800) as tab:
        assert tab.evaluate("document.documentElement.scrollWidth") <= 390
