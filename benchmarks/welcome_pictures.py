"""The picture of the README: the UR5 of the first tutorial before and after, its FRFs, the diagnosis's page.

And two of the tutorials.

Drawn from the pages as chromium shows them; run by `make pictures`.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from flexmodal_viewer import show_outcome, show_robot
from PIL import Image
from tour_pages import steps

import flexmodal
from flexmodal.diagnosis.write import write_diagnosis
from flexmodal.frf.plot import draw_frf
from flexmodal.model import load
from flexmodal.model.guess import guess_card
from flexmodal.report import write_figure
from flexmodal.rig import Hide, simulate

ROOT = Path(__file__).resolve().parents[1]
PICTURES = ROOT / "docs" / "pictures"
HEIGHT = 640


def screenshot(page: Path, size: tuple[int, int], fragment: str = "") -> Image.Image:
    """A page as chromium draws it at a size [px]."""
    picture = page.with_suffix(".png")
    command = [
        shutil.which("chromium") or "chromium", "--headless", "--no-sandbox", "--hide-scrollbars",
        "--use-gl=swiftshader", "--enable-unsafe-swiftshader", "--virtual-time-budget=8000",
        f"--window-size={size[0]},{size[1]}", f"--screenshot={picture}", page.as_uri() + fragment,
    ]  # fmt: skip
    subprocess.run(command, check=True, capture_output=True, timeout=120)
    return Image.open(picture).convert("RGB")


def tutorial_arm(folder: Path) -> flexmodal.Robot:
    """The arm of the first tutorial: a guessed card, with the posture and the table that the reader adds."""
    guess_card("ur5", folder / "my_ur5", tool="tool0").write()
    for step in steps(ROOT / "docs" / "tutorials" / "posture.md"):
        if step.writes:
            step.write(folder)
    return load(folder / "my_ur5")


def posture_panels(arm: flexmodal.Robot, folder: Path) -> list[Image.Image]:
    """The arm in both postures, and its receptance in both."""
    start = arm.posture("bench")
    hold = flexmodal.Hold.at(arm, tuple(arm.at(start).position("tool0")), axis=(0.0, 0.0, -1.0))
    objective = flexmodal.ReceptanceObjective("tool0:+z", 10.0)
    problem = flexmodal.PostureProblem(arm, objective, hold, clearance=flexmodal.Clearance.of(arm, 0.01))
    outcome = flexmodal.optimise(problem, start=start, starts=24)
    print(f"{outcome.start / outcome.best.objective:.2f} times less in the best posture")
    page = folder / "best.html"
    show_outcome(outcome, start=start, live=False, out=page, open_browser=False, announce=lambda text: None)
    lines = np.geomspace(2, 100, 800)
    curves = {"before": arm.frf(start, lines), "after": arm.frf(outcome.best.posture, lines)}
    figure = draw_frf(curves, title="The tool's receptance, before and after", mark=10.0)
    write_figure(figure, folder / "frf.png")
    scene = screenshot(page, (1100, 760), "#motion=-1").crop((0, 0, 760, 760))
    return [scene, Image.open(folder / "frf.png").convert("RGB")]


def diagnosis_panel(folder: Path) -> Image.Image:
    """The head of the page that `flexmodal demo` writes of a hidden, bending link."""
    card = load("fanuc_s360_rigid_link")
    hide = [Hide("link_flexibility", "link_2", height=10.0)]
    test = simulate(
        card, hide=hide, postures=4, points=4, references=2, seed=1, record_length=2.0, band=(2.0, 150.0)
    )
    write_diagnosis(flexmodal.diagnose(test.campaign, card), folder / "diagnosis")
    return screenshot(folder / "diagnosis" / "report.html", (820, 820))


def modes_page(arm: flexmodal.Robot, folder: Path) -> Image.Image:
    """The page of `flexmodal show … --modes`, in the middle of a swing of the first mode."""
    page = folder / "modes.html"
    quietly = {"open_browser": False, "announce": lambda text: None}
    show_robot(arm, arm.posture("bench"), modes=True, live=False, out=page, **quietly)
    return screenshot(page, (1000, 640), "#motion=0&phase=0.25")


def save(picture: Image.Image, name: str) -> None:
    """Write a picture of few colours into docs/pictures."""
    picture.quantize(128).save(PICTURES / name, optimize=True)
    print(f"wrote {PICTURES / name}")


def main() -> int:
    """Draw the three, put them side by side, write the picture."""
    with tempfile.TemporaryDirectory() as scratch:
        arm = tutorial_arm(Path(scratch))
        panels = [*posture_panels(arm, Path(scratch)), diagnosis_panel(Path(scratch))]
        scaled = [panel.resize((round(panel.width * HEIGHT / panel.height), HEIGHT)) for panel in panels]
        whole = Image.new("RGB", (sum(panel.width for panel in scaled), HEIGHT), "white")
        left = 0
        for panel in scaled:
            whole.paste(panel, (left, 0))
            left += panel.width
        save(whole, "welcome.png")
        save(panels[2].crop((0, 0, 820, 390)), "tutorial_diagnosis.png")
        save(modes_page(arm, Path(scratch)), "tutorial_modes.png")
    return 0


if __name__ == "__main__":
    sys.exit(main())
