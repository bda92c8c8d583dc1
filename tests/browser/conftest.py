"""A headless browser that takes pictures of pages."""

import importlib.util
import os
import re
import shutil
import subprocess
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")

FLAGS = (
    "--headless=new",
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


@dataclass(frozen=True)
class Browser:
    program: str
    folder: Path

    def _run(self, *arguments):
        profile = self.folder / f"profile_{time.monotonic_ns()}"
        command = [self.program, *FLAGS, f"--user-data-dir={profile}", *arguments]
        done = subprocess.run(command, capture_output=True, timeout=120, check=False)
        shutil.rmtree(profile, ignore_errors=True)
        return done

    def picture(self, page, fragment="", *, width=1200, height=760):
        """Pixels of a page as red, green, blue from 0 to 255."""
        out = self.folder / f"picture_{time.monotonic_ns()}.png"
        done = self._run(
            f"--window-size={width},{height}",
            "--virtual-time-budget=8000",
            f"--screenshot={out}",
            Path(page).as_uri() + fragment,
        )
        assert out.is_file(), f"{self.program} took no picture:\n{done.stderr.decode()[-2000:]}"
        keep = os.environ.get("FLEXMODAL_KEEP_PICTURES")
        if keep:
            name = f"{Path(page).stem}{fragment.replace('#', '_').replace('&', '_')}_{width}.png"
            shutil.copy(out, Path(keep) / name)
        return np.asarray(Image.open(out).convert("RGB")).astype(int)

    def measured(self, page, width, *, height=2400):
        """The page's elements after its scripts have run, in a window of that width."""
        done = self._run(
            f"--window-size={width},{height}", "--virtual-time-budget=8000", "--dump-dom", Path(page).as_uri()
        )
        return done.stdout.decode()

    def printed(self, page):
        """Number of pages of the page as a PDF, and its size in bytes."""
        out = self.folder / f"print_{time.monotonic_ns()}.pdf"
        self._run("--no-pdf-header-footer", f"--print-to-pdf={out}", Path(page).as_uri())
        content = out.read_bytes()
        return len(re.findall(rb"/Type\s*/Page\b(?!s)", content)), len(content)

    def document(self, page):
        """The page's elements after its scripts have run, and what the browser said."""
        done = self._run(
            "--virtual-time-budget=8000",
            "--enable-logging=stderr",
            "--v=0",
            "--dump-dom",
            Path(page).as_uri(),
        )
        return done.stdout.decode(), done.stderr.decode()


_SPEC = importlib.util.spec_from_file_location(
    "diagnosed_by_hand", Path(__file__).parents[1] / "diagnosis" / "conftest.py"
)
_made = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(_made)
campaign, observed, context = _made.campaign, _made.observed, _made.context
hinged, diagnosed = _made.hinged, _made.diagnosed


@pytest.fixture(scope="session")
def browser(tmp_path_factory):
    if os.environ.get("FLEXMODAL_NO_BROWSER") == "1":
        pytest.skip("FLEXMODAL_NO_BROWSER=1")
    program = next(filter(None, map(shutil.which, NAMES)), None)
    if program is None:
        pytest.fail(
            f"these tests look at pages in Chromium, and none of {', '.join(NAMES)} is installed; "
            "install one, or set FLEXMODAL_NO_BROWSER=1 to leave them out"
        )
    return Browser(program, tmp_path_factory.mktemp("browser"))
