"""A scene as a picture or a film, taken of its page in a browser without a window."""

from __future__ import annotations

import io
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from flexmodal.errors import Fault, InvalidRequest, MissingExtra
from flexmodal.files import whole_file
from flexmodal_viewer.commands import CYCLE
from flexmodal_viewer.page import page_html
from flexmodal_viewer.scene import Scene

if TYPE_CHECKING:
    from PIL.Image import Image

KINDS = (".png", ".gif")
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
_FLAGS = ("--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-quic")
_SIZE = (1000, 760)
"""Of the window [pixels]."""
_FRAMES = 24
"""Pictures of one cycle in a film."""
_COLOURS = 128
_PATIENCE = 120_000
"""For what a page still works out, such as a map of the workspace [ms]."""


def write_picture(scene: Scene, path: str | Path, *, overwrite: bool = False) -> Path:
    """Take a picture of a scene, or a film of one cycle of its first swing, whole or not at all.

    Args:
        scene: as it stands on its page, without the words beside it.
        path: ends in .png or .gif.
        overwrite: replace a file that stands there already.

    Raises:
        OutputExists: the file exists and `overwrite` is false, or its folder does not exist.
        InvalidRequest: a film of a scene in which nothing swings.
        MissingExtra: Playwright or Chromium is not installed.
    """
    target = Path(path)
    film = target.suffix.lower() == ".gif"
    swings = [number for number, motion in enumerate(scene.motions) if motion.tracks]
    if film and not swings and not (scene.live or {}).get("swing"):
        allowed = "--modes or --frequency beside a .gif, which shows one cycle; or a .png"
        raise InvalidRequest(Fault(str(target), "", "a film of an arm that stands still", allowed))
    fragment = f"&motion={swings[0]}" if film and swings else ""
    with whole_file(target, overwrite=overwrite) as scratch, _opened(scene, fragment) as tab:
        if film:
            pictures = [_taken(tab, frame / _FRAMES) for frame in range(_FRAMES)]
            one, *others = [picture.quantize(_COLOURS) for picture in pictures]
            times = {"duration": round(1000 * CYCLE / _FRAMES), "loop": 0}
            one.save(scratch, format="GIF", save_all=True, append_images=others, **times)
        else:
            _taken(tab, None).save(scratch, format="PNG")
    return target


def _taken(tab: Any, phase: float | None) -> Image:
    from PIL import Image

    if phase is not None:
        tab.evaluate("(phase) => window.flexmodalPage.hold(phase)", phase)
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
