"""Pictures and films of pages, and the page in a notebook's cell."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest
from flexmodal_viewer import CellView, live_scene, robot_scene, show_robot, write_picture
from PIL import Image

from flexmodal.errors import InvalidRequest, MissingExtra, OutputExists
from flexmodal.model import load

_SPEC = importlib.util.spec_from_file_location("live_pages", Path(__file__).with_name("live.py"))
live = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(live)


@pytest.fixture(scope="module")
def arm():
    return load("fanuc_s360")


def pixels(image):
    return np.asarray(image.convert("RGB")).astype(int)


def test_a_picture_shows_the_arm_and_its_curve(arm, tmp_path):
    out = tmp_path / "arm.png"
    show_robot(arm, arm.posture("configuration_1"), frequency=9.0, out=out, announce=lambda _: None)
    with Image.open(out) as taken:
        picture = pixels(taken)
    assert picture.shape == (760, 1000, 3)
    upper, lower = picture[:480], picture[510:]
    assert 0.05 < np.any(upper < 200, axis=2).mean() < 0.5
    blue = (lower[..., 2] > 120) & (lower[..., 0] < 60)
    assert np.count_nonzero(blue.any(axis=0)) > 700  # the curve goes through nearly all columns
    with pytest.raises(OutputExists):
        show_robot(arm, arm.posture("configuration_1"), out=out, announce=lambda _: None)


@pytest.mark.parametrize("kind", ["live", pytest.param("still", marks=pytest.mark.slow)])
def test_a_film_swings_and_comes_back(arm, tmp_path, kind):
    posture = arm.posture("configuration_1")
    scene = (
        live_scene(arm, posture, swing="mode") if kind == "live" else robot_scene(arm, posture, modes=True)
    )
    frames = []
    with Image.open(write_picture(scene, tmp_path / "arm.gif")) as film:
        assert film.n_frames == 24
        for number in (0, 12, 23):
            film.seek(number)
            frames.append(pixels(film))
    across, near = (np.mean(np.any(np.abs(frames[0] - other) > 60, axis=2)) for other in frames[1:])
    assert across > 0.01
    assert near < across / 2


def test_a_film_of_what_stands_still_is_refused(arm, tmp_path):
    scene = live_scene(arm, arm.posture("configuration_1"))
    with pytest.raises(InvalidRequest, match="stands still"):
        write_picture(scene, tmp_path / "arm.gif")
    assert list(tmp_path.iterdir()) == []


def test_without_a_browser_it_says_what_is_missing(arm, tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(MissingExtra, match="Chromium"):
        write_picture(live_scene(arm, arm.posture("configuration_1")), tmp_path / "arm.png")
    assert list(tmp_path.iterdir()) == []


def test_a_cell_of_a_notebook_shows_the_same_view(arm, tmp_path):
    view = CellView(live_scene(arm, arm.posture("configuration_1")))
    page = tmp_path / "notebook.html"
    page.write_text(f"<!DOCTYPE html><meta charset=utf-8><p>cell</p>{view._repr_html_()}")
    with live.chromium() as browser:
        said = []
        tab = browser.new_page(viewport={"width": 1000, "height": 700})
        tab.on("console", lambda message: said.append(message.text))
        tab.on("pageerror", lambda error: said.append(str(error)))
        tab.goto(page.as_uri())
        inside = tab.frame_locator("iframe")
        inside.locator("#modes tbody tr").nth(3).wait_for()
        shown = inside.locator("#modes tbody td:nth-child(2)").all_inner_texts()
        assert shown == [f"{value:.4g} Hz" for value in arm.modes("configuration_1").frequency]
        assert inside.locator("canvas").count() == 1
        assert said == []
