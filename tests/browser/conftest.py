"""A headless browser that takes pictures of pages."""

import importlib.util
import io
import os
import re
import shutil
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")

FLAGS = (
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--hide-scrollbars",
    "--proxy-server=http://127.0.0.1:9",  # whatever asks the network fails
)

DRAWN = "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"


@dataclass(frozen=True)
class Browser:
    launched: Any

    @contextmanager
    def _opened(self, page, fragment="", *, width=1200, height=760):
        """A window of its own on a page that has been loaded and drawn, and what it said on its console."""
        said = []
        tab = self.launched.new_page(viewport={"width": width, "height": height})
        tab.on("console", lambda message: said.append(f"CONSOLE {message.type}: {message.text}"))
        tab.on("pageerror", lambda error: said.append(f"CONSOLE error: {error}"))
        tab.on("requestfailed", lambda request: said.append(f"CONSOLE error: no answer from {request.url}"))
        tab.goto(Path(page).as_uri() + fragment)
        tab.evaluate(DRAWN)
        yield tab, said
        tab.close()

    def picture(self, page, fragment="", *, width=1200, height=760):
        """Pixels of a page as red, green, blue from 0 to 255."""
        with self._opened(page, fragment, width=width, height=height) as (tab, _):
            content = tab.screenshot()
        keep = os.environ.get("FLEXMODAL_KEEP_PICTURES")
        if keep:
            name = f"{Path(page).stem}{fragment.replace('#', '_').replace('&', '_')}_{width}.png"
            (Path(keep) / name).write_bytes(content)
        return np.asarray(Image.open(io.BytesIO(content)).convert("RGB")).astype(int)

    def measured(self, page, width, *, height=2400):
        """The page's elements after its scripts have run, in a window of that width."""
        with self._opened(page, width=width, height=height) as (tab, _):
            return tab.content()

    def printed(self, page):
        """Number of pages of the page as a PDF, and its size in bytes."""
        with self._opened(page) as (tab, _):
            content = tab.pdf(print_background=True)
        return len(re.findall(rb"/Type\s*/Page\b(?!s)", content)), len(content)

    def document(self, page):
        """The page's elements after its scripts have run, and what it said on its console."""
        with self._opened(page) as (tab, said):
            return tab.content(), "\n".join(said)


_SPEC = importlib.util.spec_from_file_location(
    "diagnosed_by_hand", Path(__file__).parents[1] / "diagnosis" / "conftest.py"
)
_made = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(_made)
campaign, observed, context = _made.campaign, _made.observed, _made.context
hinged, diagnosed = _made.hinged, _made.diagnosed


@pytest.fixture(scope="module")
def browser():
    if os.environ.get("FLEXMODAL_NO_BROWSER") == "1":
        pytest.skip("FLEXMODAL_NO_BROWSER=1")
    program = next(filter(None, map(shutil.which, NAMES)), None)
    if program is None:
        pytest.fail(
            f"these tests look at pages in Chromium, and none of {', '.join(NAMES)} is installed; "
            "install one, or set FLEXMODAL_NO_BROWSER=1 to leave them out"
        )
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        launched = playwright.chromium.launch(executable_path=program, args=list(FLAGS))
        yield Browser(launched)
        launched.close()
