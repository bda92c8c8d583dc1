"""Pictures and a short film of the live page, for the README and docs/live.md.

    python benchmarks/live_pictures.py [FOLDER]

They are taken of the page itself in headless Chromium: the six-axis arm swinging in its third mode; the page
on a telephone in the dark; and a film in which two joints are moved and the receptance follows.
"""

from __future__ import annotations

import io
import shutil
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from flexmodal_viewer import show_robot
from PIL import Image
from playwright.sync_api import sync_playwright

import flexmodal

PICTURES = Path(__file__).resolve().parents[1] / "docs" / "pictures"
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
FRAMES = 24
FRAME_MS = 120


@contextmanager
def opened(browser: Any, page: Path, fragment: str, **look: Any) -> Iterator[Any]:
    tab = browser.new_page(reduced_motion="reduce", **look)
    tab.goto(page.as_uri() + fragment)
    tab.wait_for_selector("#modes tbody tr")
    tab.wait_for_timeout(500)
    yield tab
    tab.close()


def film(tab: Any, path: Path) -> None:
    """Second and third joint go to and fro once, the curve of the start stays dashed."""
    tab.get_by_role("button", name="Pin curve").click()
    second, third = tab.evaluate("[flexmodalLive.state.q[1], flexmodalLive.state.q[2]]")
    frames = []
    for phase in np.linspace(0, 2 * np.pi, FRAMES, endpoint=False):
        away = (1 - np.cos(phase)) / 2
        move = "(values) => values.forEach((value, k) => flexmodalLive.moveJoint(k + 1, value))"
        tab.evaluate(move, [second + 0.55 * away, third - 0.75 * away])
        tab.wait_for_timeout(120)
        taken = Image.open(io.BytesIO(tab.screenshot())).convert("RGB")
        frames.append(taken.resize((taken.width * 5 // 8, taken.height * 5 // 8)).quantize(64))
    frames[0].save(path, save_all=True, append_images=frames[1:], duration=FRAME_MS, loop=0, optimize=True)


def main() -> None:
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else PICTURES
    program = next(filter(None, map(shutil.which, BROWSERS)), None)
    if program is None:
        raise SystemExit(f"none of {', '.join(BROWSERS)} is installed")
    arm = flexmodal.load("six_axis")
    with tempfile.TemporaryDirectory() as scratch, sync_playwright() as playwright:
        page = Path(scratch) / "page.html"
        show_robot(arm, arm.posture("work"), out=page, announce=lambda _: None)
        flags = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
        browser = playwright.chromium.launch(executable_path=program, args=flags)
        wide = {"viewport": {"width": 1240, "height": 820}}
        with opened(browser, page, "#mode=3", **wide) as tab:
            tab.screenshot(path=folder / "live.png")
        small = {"viewport": {"width": 390, "height": 780}, "color_scheme": "dark"}
        with opened(browser, page, "#mode=1", **small) as tab:
            tab.screenshot(path=folder / "live_telephone.png")
        with opened(browser, page, "#frequency=15", **wide) as tab:
            tab.evaluate("flexmodalLive.rest()")
            film(tab, folder / "live.gif")
        browser.close()
    for name in ("live.png", "live_telephone.png", "live.gif"):
        print(f"{folder / name}: {(folder / name).stat().st_size // 1000} kB")


if __name__ == "__main__":
    main()
