"""Pictures and a short film of the live page, for the README and docs/live.md.

    python benchmarks/live_pictures.py [FOLDER]

They are taken of the page itself in headless Chromium: the six-axis arm swinging in its third mode; the page
on a telephone in the dark; a film in which two joints are moved and the receptance follows; the map of the
workspace; a posture search gone through, as a film; and the third step of a diagnosis of a simulated
campaign, in which a link that bends and a mass are hidden. Two minutes.
"""

from __future__ import annotations

import io
import shutil
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from flexmodal_viewer import show_diagnosis, show_outcome, show_robot
from PIL import Image
from playwright.sync_api import sync_playwright

import flexmodal
from flexmodal.diagnosis import diagnose
from flexmodal.rig import Hide, simulate

PICTURES = Path(__file__).resolve().parents[1] / "docs" / "pictures"
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
FRAMES = 24
FRAME_MS = 120
STANDS = 350
"""Until a picture made in software has all its pixels [ms]."""


@contextmanager
def opened(browser: Any, page: Path, fragment: str, **look: Any) -> Iterator[Any]:
    tab = browser.new_page(reduced_motion="reduce", **look)
    tab.goto(page.as_uri() + fragment)
    tab.wait_for_selector("#modes tbody tr")
    tab.wait_for_timeout(500)
    yield tab
    tab.close()


def small(tab: Any) -> Image.Image:
    taken = Image.open(io.BytesIO(tab.screenshot())).convert("RGB")
    return taken.resize((taken.width * 5 // 8, taken.height * 5 // 8)).quantize(64)


def save(frames: list[Image.Image], path: Path) -> None:
    frames[0].save(path, save_all=True, append_images=frames[1:], duration=FRAME_MS, loop=0, optimize=True)


def film(tab: Any, path: Path) -> None:
    """Second and third joint go to and fro once, the curve of the start stays dashed."""
    tab.get_by_role("button", name="Pin curve").click()
    second, third = tab.evaluate("[flexmodalLive.state.q[1], flexmodalLive.state.q[2]]")
    frames = []
    for phase in np.linspace(0, 2 * np.pi, FRAMES, endpoint=False):
        away = (1 - np.cos(phase)) / 2
        move = "(values) => values.forEach((value, k) => flexmodalLive.moveJoint(k + 1, value))"
        tab.evaluate(move, [second + 0.55 * away, third - 0.75 * away])
        tab.wait_for_timeout(STANDS)
        frames.append(small(tab))
    save(frames, path)


def search_film(tab: Any, path: Path) -> None:
    """All descents of a search, from their starts to their ends, where they stay a while."""
    most = tab.evaluate("Number(document.getElementById('step').max)")
    frames = []
    for step in [*np.linspace(0, most, FRAMES), *[most] * 5]:
        tab.evaluate("(step) => flexmodalLive.film.show(step)", float(step))
        tab.wait_for_timeout(STANDS)
        frames.append(small(tab))
    save(frames, path)


def searched(page: Path) -> None:
    arm = flexmodal.load("six_axis")
    judge = flexmodal.ReceptanceObjective("tool:+z", 20.0)
    problem = flexmodal.PostureProblem(arm, judge, flexmodal.Hold.at(arm, (0.9, 0.3, 0.8)))
    outcome = flexmodal.optimise(problem, start="work", starts=24)
    assert outcome.compared is not None
    show_outcome(outcome, start=outcome.compared.held, out=page, announce=lambda _: None)


def diagnosed(page: Path) -> None:
    arm = flexmodal.load("fanuc_s360_rigid_link")
    hidden = [replace(Hide.parse("link_flexibility@link_2"), height=10.0), Hide.parse("added_mass@link_3")]
    test: dict[str, Any] = {"postures": 3, "points": 3, "references": 2, "trials": 3, "record_length": 2.0}
    campaign = simulate(arm, hide=hidden, seed=1, band=(2.0, 150.0), **test).campaign
    found = diagnose(campaign, arm, effects=["link_flexibility@link_2", "added_mass@link_3"])
    show_diagnosis(found, out=page, announce=lambda _: None)


def take(browser: Any, scratch: Path, folder: Path) -> None:
    arm = flexmodal.load("six_axis")
    page = scratch / "page.html"
    show_robot(arm, arm.posture("work"), out=page, announce=lambda _: None)
    wide = {"viewport": {"width": 1240, "height": 820}}
    with opened(browser, page, "#mode=3", **wide) as tab:
        tab.screenshot(path=folder / "live.png")
    telephone = {"viewport": {"width": 390, "height": 780}, "color_scheme": "dark"}
    with opened(browser, page, "#mode=1", **telephone) as tab:
        tab.screenshot(path=folder / "live_telephone.png")
    with opened(browser, page, "#frequency=15", **wide) as tab:
        tab.evaluate("flexmodalLive.rest()")
        film(tab, folder / "live.gif")
    with opened(browser, page, "#map=1", **wide) as tab:
        tab.wait_for_selector("body:not(.busy)", timeout=120_000)
        tab.locator("#map-hertz").evaluate(
            "(range) => { range.value = 15; range.dispatchEvent(new Event('input')); }"
        )
        tab.wait_for_selector("body:not(.busy)", timeout=120_000)
        tab.locator("#map-places").select_option(index=20)
        tab.wait_for_selector("body:not(.busy)", timeout=120_000)
        tab.locator("#h-map").scroll_into_view_if_needed()
        tab.wait_for_timeout(600)
        tab.screenshot(path=folder / "live_workspace.png")
    searched(scratch / "search.html")
    with opened(browser, scratch / "search.html", "", **wide) as tab:
        search_film(tab, folder / "live_search.gif")
    diagnosed(scratch / "diagnosis.html")
    with opened(browser, scratch / "diagnosis.html", "", **wide) as tab:
        tab.evaluate("flexmodalLive.diagnosis.show(2)")
        tab.wait_for_timeout(600)
        tab.screenshot(path=folder / "live_diagnosis.png")


def main() -> None:
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else PICTURES
    program = next(filter(None, map(shutil.which, BROWSERS)), None)
    if program is None:
        raise SystemExit(f"none of {', '.join(BROWSERS)} is installed")
    with tempfile.TemporaryDirectory() as scratch, sync_playwright() as playwright:
        flags = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
        browser = playwright.chromium.launch(executable_path=program, args=flags)
        take(browser, Path(scratch), folder)
        browser.close()
    for path in sorted(folder.glob("live*")):
        print(f"{path}: {path.stat().st_size // 1000} kB")


if __name__ == "__main__":
    main()
