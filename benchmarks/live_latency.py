"""How long the live page takes from a slider to the new curve, and how often it draws a swinging arm.

    python benchmarks/live_latency.py [ROBOT …]

In headless Chromium, as it stands in the page: a joint's slider is moved a hundred times; each time the new
receptance over 400 lines, the modes, the ellipsoid and the picture's places are computed and the curve is
laid out before the clock stops. "painted" waits for the next frame as well, which here SwiftShader draws: a
picture in software, without a graphics card.

Then the arm swings for some seconds. "frames/s" counts its frames as they come, and on a busy machine says
how busy it is; "work" is the processor time that all processes of the browser spend on a frame [ms], whatever
else runs: below 33 ms one free processor makes 30 frames a second. "drawing" is SwiftShader's part of it,
waited for frame by frame. "lavish" is the same without what the page does to spare software: with every
triangle, all pixels and smooth edges.
"""

from __future__ import annotations

import argparse
import os
import shutil
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from flexmodal_viewer import show_robot
from playwright.sync_api import sync_playwright

import flexmodal

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
GOAL = 50.0
"""From slider to curve [ms]."""

MOVED = """(count) => {
  const range = document.getElementById("joint-1");
  const times = [];
  const start = Number(range.value);
  for (let k = 0; k < count; k++) {
    range.value = start + 0.004 * (k % 50);
    const before = performance.now();
    range.dispatchEvent(new Event("input"));
    document.querySelector(".curve.live").getBBox();
    times.push(performance.now() - before);
  }
  return times;
}"""
PAINTED = """(count) => new Promise((done) => {
  const range = document.getElementById("joint-1");
  const times = [];
  (function next(k) {
    if (k === count) { done(times); return; }
    range.value = Number(range.min) / 2 + 0.01 * k;
    const before = performance.now();
    range.dispatchEvent(new Event("input"));
    requestAnimationFrame(() => setTimeout(() => { times.push(performance.now() - before); next(k + 1); }));
  })(0);
})"""
FRAMES = """(seconds) => new Promise((done) => {
  let count = 0;
  const start = performance.now();
  (function next() {
    count += 1;
    const gone = performance.now() - start;
    if (gone > 1000 * seconds) done(count / gone * 1000);
    else requestAnimationFrame(next);
  })();
})"""


DRAWING = """(count) => {
  const gl = viewer.renderer.getContext();
  const pixel = new Uint8Array(4);
  const times = [];
  for (let k = 0; k < count; k++) {
    flexmodalLive.state.phase = 0.3 * k;
    flexmodalLive.stand();
    viewer.scene.updateMatrixWorld();
    const before = performance.now();
    viewer.renderer.render(viewer.scene, viewer.camera);
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel); // waits until it is drawn
    times.push(performance.now() - before);
  }
  return times;
}"""
LAVISH = "swiftshader|llvmpipe|softpipe|software|basic render"
"""Words of the page's script that tell software; a page without them draws as with a card."""


def family() -> dict[int, float]:
    """Processor time of each process below this one [s], by its number."""
    parents, spent = {}, {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                fields = (entry / "stat").read_text().rpartition(")")[2].split()
            except OSError:
                continue  # ended meanwhile
            parents[int(entry.name)] = int(fields[1])
            spent[int(entry.name)] = (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    own = os.getpid()

    def below(number: int) -> bool:
        while number in parents:
            number = parents[number]
            if number == own:
                return True
        return False

    return {number: seconds for number, seconds in spent.items() if below(number)}


def swinging(tab: Any, seconds: float) -> tuple[float, float, float]:
    """Frames a second, processor time of a frame and its drawing [ms]."""
    tab.evaluate("flexmodalLive.swingIn(0)")
    tab.wait_for_timeout(800)
    before = family()
    frames = float(tab.evaluate(FRAMES, seconds))
    after = family()
    work = sum(seconds - before.get(number, 0.0) for number, seconds in after.items())
    drawing = float(np.median(tab.evaluate(DRAWING, 15)))
    return frames, 1e3 * work / (frames * seconds), drawing


def page_of(name: str, folder: Path) -> Path:
    cards = {"six_axis", "fanuc_s360", "six_link"}
    arm = flexmodal.load(name) if name in cards else flexmodal.load(name, stiffness=2e4, damping=20.0)
    start = next(iter(arm.postures), None)
    middle = {joint: (one.lower + one.upper) / 2 for joint, one in arm.commanded.items()}
    path = folder / f"{name}.html"
    show_robot(arm, arm.posture(start or middle), out=path, announce=lambda _: None)
    return path


def main() -> None:
    asked = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    asked.add_argument("robots", nargs="*", default=["six_axis", "xarm7", "panda"])
    robots = asked.parse_args().robots
    program = next(filter(None, map(shutil.which, BROWSERS)), None)
    if program is None:
        raise SystemExit(f"none of {', '.join(BROWSERS)} is installed")
    columns = (
        "page [MB]",
        "median [ms]",
        "95 % [ms]",
        "painted [ms]",
        "frames/s",
        "work [ms]",
        "drawing [ms]",
    )
    print(f"{'robot':12} {' '.join(f'{column:>12}' for column in columns)}")
    late = []
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        flags = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
        browser = playwright.chromium.launch(executable_path=program, args=flags)
        for name in robots:
            path = page_of(name, Path(folder))
            tab = browser.new_page(viewport={"width": 1280, "height": 800})
            tab.goto(path.as_uri())
            tab.wait_for_selector("#modes tbody tr")
            tab.evaluate(MOVED, 20)  # the browser compiles what runs often
            times = np.array(tab.evaluate(MOVED, 100))
            painted = np.array(tab.evaluate(PAINTED, 20))
            swing = swinging(tab, 4.0)
            size = path.stat().st_size / 1e6
            middle, most = np.median(times), np.quantile(times, 0.95)
            figures = (size, middle, most, float(np.median(painted)), *swing)
            print(f"{name:12} {' '.join(f'{figure:12.4g}' for figure in figures)}")
            late += [name] if middle > GOAL else []
            tab.close()
            path.write_text(
                path.read_text(encoding="utf-8").replace(LAVISH, "no such name"), encoding="utf-8"
            )
            tab = browser.new_page(viewport={"width": 1280, "height": 800})
            tab.goto(path.as_uri())
            tab.wait_for_selector("#modes tbody tr")
            print(f"{'  lavish':12} {' ' * 51} {' '.join(f'{one:12.4g}' for one in swinging(tab, 4.0))}")
            tab.close()
        browser.close()
    if late:
        raise SystemExit(f"slower than {GOAL:g} ms: {', '.join(late)}")


if __name__ == "__main__":
    main()
