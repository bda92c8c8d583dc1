"""A scene as a picture or a film, taken of its page in a browser without a window."""

from __future__ import annotations

import io
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from flexmodal.errors import Fault, InvalidRequest, MissingExtra
from flexmodal.files import whole_file
from flexmodal_viewer.commands import CYCLE
from flexmodal_viewer.film_file import FILMS, refuse_without_encoder, write_film
from flexmodal_viewer.page import page_html
from flexmodal_viewer.scene import Scene

if TYPE_CHECKING:
    from PIL.Image import Image

KINDS = (".png", *FILMS)
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
_FLAGS = ("--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-quic")
_SIZE = (1000, 760)
"""Of the window [pixels]."""
_FRAMES = 24
"""Pictures of one cycle in a film."""
_ROUNDS = 4
"""Cycles in an MP4; a GIF goes on by itself."""
_SEARCH, _SEARCHED = 48, 6.0
"""Pictures of a posture search gone through, and how long that takes [s]."""
_STEP = 2.0
"""How long each step of a diagnosis is shown [s]."""
_PATIENCE = 120_000
"""For what a page still works out, such as a map of the workspace [ms]."""


def write_picture(scene: Scene, path: str | Path, *, overwrite: bool = False) -> Path:
    """Take a picture of a scene, or a film, whole or not at all.

    A film shows one cycle of what swings; of a posture search its descents, of a diagnosis its steps.

    Args:
        scene: as it stands on its page, without the words beside it.
        path: ends in .png, .gif or .mp4.
        overwrite: replace a file that stands there already.

    Raises:
        OutputExists: the file exists and `overwrite` is false, or its folder does not exist.
        InvalidRequest: a film of a scene in which nothing moves.
        MissingExtra: Playwright or Chromium is not installed, or for an .mp4 PyAV.
    """
    target = Path(path)
    kind = target.suffix.lower()
    course = _course(scene)
    if kind in FILMS:
        refuse_without_encoder(kind)
        if course is None:
            allowed = f"--modes or --frequency beside a {kind}, which shows one cycle; or a .png"
            raise InvalidRequest(Fault(str(target), "", "a film of an arm that stands still", allowed))
    fragment = course.fragment if course is not None and kind in FILMS else ""
    with whole_file(target, overwrite=overwrite) as scratch, _opened(scene, fragment) as tab:
        if course is not None and kind in FILMS:
            pictures = [_taken(tab, course.script, part) for part in course.parts]
            write_film(pictures, scratch, kind, seconds=course.seconds, rounds=course.rounds)
        else:
            _taken(tab).save(scratch, format="PNG")
    return target


@dataclass(frozen=True)
class _Course:
    """What a film goes through."""

    script: str
    """Told each part, from 0 to 1."""
    parts: tuple[float, ...]
    seconds: float
    rounds: int = 1
    fragment: str = ""


def _course(scene: Scene) -> _Course | None:
    """Of a search, a diagnosis or a swing; None of what stands still."""
    live = scene.live or {}
    descents = (live.get("search") or {}).get("descents", ())
    if any(len(one["steps"]) > 1 for one in descents):
        parts = tuple(k / (_SEARCH - 1) for k in range(_SEARCH))
        return _Course("(part) => window.flexmodalPage.film(part)", parts, _SEARCHED)
    if live.get("diagnosis"):
        count = len(live["diagnosis"]["stages"])
        parts = tuple(k / max(count - 1, 1) for k in range(count))
        return _Course("(part) => window.flexmodalPage.film(part)", parts, _STEP * count)
    swings = [number for number, motion in enumerate(scene.motions) if motion.tracks]
    if not swings and not live.get("swing"):
        return None
    parts = tuple(k / _FRAMES for k in range(_FRAMES))
    fragment = f"&motion={swings[0]}" if swings else ""
    return _Course("(phase) => window.flexmodalPage.hold(phase)", parts, CYCLE, _ROUNDS, fragment)


def _taken(tab: Any, script: str = "", part: float = 0.0) -> Image:
    from PIL import Image

    if script:
        tab.evaluate(script, part)
    tab.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    return Image.open(io.BytesIO(tab.screenshot())).convert("RGB")


@contextmanager
def _opened(scene: Scene, fragment: str) -> Iterator[Any]:
    """The page of a scene in a browser, its swing held at the extreme."""
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        raise MissingExtra("pictures need Playwright: pip install 'flexmodal[pictures]'") from None
    program = next(filter(None, map(shutil.which, BROWSERS)), None)
    if program is None:
        raise MissingExtra(
            "pictures need Chromium or Chrome, which is not installed; a page (.html) does not"
        )
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        page = Path(folder) / "page.html"
        page.write_text(page_html(scene), encoding="utf-8")
        browser = playwright.chromium.launch(executable_path=program, args=list(_FLAGS))
        tab = browser.new_page(
            viewport={"width": _SIZE[0], "height": _SIZE[1]}, reduced_motion="reduce", color_scheme="light"
        )
        tab.goto(f"{page.as_uri()}#picture=1{fragment}", wait_until="load")
        tab.wait_for_selector("body:not(.busy)", timeout=_PATIENCE)
        yield tab
        browser.close()
