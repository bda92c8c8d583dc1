"""Pictures and films of pages, and the page in a notebook's cell."""

import importlib.util
import sys
from pathlib import Path

import av
import numpy as np
import pytest
from flexmodal_viewer import CellView, live_scene, robot_scene, show_robot, write_picture
from flexmodal_viewer.film_file import write_film
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


@pytest.mark.slow
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


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["live", "still"])
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


def frames_of(path):
    with av.open(str(path)) as film:
        (stream,) = film.streams.video
        assert stream.codec_context.name == "h264"
        assert stream.codec_context.pix_fmt == "yuv420p"
        return [pixels(frame.to_image()) for frame in film.decode(stream)], float(stream.average_rate)


def test_pictures_become_an_mp4(tmp_path):
    """Grey from dark to light, with an odd side and slower than players like."""
    shades = [20, 90, 160, 230]
    pictures = [Image.new("RGB", (65, 48), (shade, shade, shade)) for shade in shades]
    write_film(pictures, tmp_path / "grey.mp4", ".mp4", seconds=2.0, rounds=2)
    frames, rate = frames_of(tmp_path / "grey.mp4")
    assert frames[0].shape == (48, 64, 3)
    assert rate == 10
    assert len(frames) == 2 * 20
    found = [float(frame.mean()) for frame in frames]
    assert found == pytest.approx([shade for shade in shades for _ in range(5)] * 2, abs=4)


@pytest.mark.slow
def test_a_picture_of_the_map_has_its_colour_bar(tmp_path):
    arm = load("six_axis")
    scene = live_scene(arm, arm.posture("work"), workspace=True)
    with Image.open(write_picture(scene, tmp_path / "map.png")) as taken:
        picture = pixels(taken)
    corner = picture[380:500, :360].reshape(-1, 3)
    for end in ((254, 232, 56), (0, 34, 78)):
        assert np.min(np.max(np.abs(corner - end), axis=1)) < 8


@pytest.mark.slow
def test_a_film_as_mp4_swings_as_the_gif_does(arm, tmp_path):
    scene = live_scene(arm, arm.posture("configuration_1"), swing="mode")
    frames, rate = frames_of(write_picture(scene, tmp_path / "arm.mp4"))
    assert len(frames) == 4 * 24
    assert rate == pytest.approx(15)
    across, near = (np.mean(np.any(np.abs(frames[0] - frames[k]) > 60, axis=2)) for k in (12, 24))
    assert across > 0.01
    assert near < across / 10  # a cycle later it is back


def test_an_mp4_without_its_encoder_says_what_is_missing(arm, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.raises(MissingExtra, match=r"flexmodal\[films\]"):
        write_picture(live_scene(arm, arm.posture("configuration_1"), swing="mode"), tmp_path / "arm.mp4")
    assert list(tmp_path.iterdir()) == []


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


@pytest.mark.slow
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
