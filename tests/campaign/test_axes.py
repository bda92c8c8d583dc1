"""Axes of a point: what may stand in campaign.toml, what is refused, and what comes back."""

from dataclasses import replace

import numpy as np
import pytest

from flexmodal.campaign import Campaign, CampaignPoint, check_campaign, read_campaign, write_campaign
from flexmodal.errors import InvalidCampaign

TURNED = ((0.6, 0.0, 0.8), (0.0, 1.0, 0.0), (-0.8, 0.0, 0.6))


def with_axes(campaign: Campaign, **own: object) -> Campaign:
    """The first point with axes of its own."""
    return replace(campaign, points=(replace(campaign.points[0], **own), *campaign.points[1:]))  # type: ignore[arg-type]


def written_with(campaign, folder, text):
    """A campaign's folder with more lines in its first point."""
    write_campaign(campaign, folder)
    file = folder / "campaign.toml"
    lines = file.read_text().splitlines()
    at = next(k for k, line in enumerate(lines) if line.startswith("xyz"))
    file.write_text("\n".join([*lines[: at + 1], text, *lines[at + 1 :]]))
    return folder


@pytest.mark.parametrize(
    "own",
    [
        {"frame": "link"},
        {"axes": TURNED, "frame": "link"},
        {"axes": TURNED, "frame": "world"},
        {
            "axes": ((1.0, 0.0, 0.0), (0.6, 0.8, 0.0), (0.0, 0.0, 1.0)),
            "frame": "link",
        },  # aslant, and yet unit vectors
    ],
)
def test_axes_are_written_and_read(campaign, tmp_path, own):
    given = with_axes(campaign, **own)
    assert read_campaign(write_campaign(given, tmp_path / "c")).points == given.points


@pytest.mark.parametrize(
    ("text", "axes", "frame"),
    [
        ('axes = "link"', None, "link"),
        (
            'axes = [[1, 0, 0], [0, 0, 1], [0, -1, 0]]\nframe = "link"',
            ((1, 0, 0), (0, 0, 1), (0, -1, 0)),
            "link",
        ),
        (
            'axes = [[0.7071, 0, 0.7071], [0, 1, 0], [-0.7071, 0, 0.7071]]\nframe = "world"',
            ((0.7071, 0, 0.7071), (0, 1, 0), (-0.7071, 0, 0.7071)),
            "world",
        ),
    ],
)
def test_what_may_stand_in_the_file(campaign, tmp_path, text, axes, frame):
    point = read_campaign(written_with(campaign, tmp_path / "c", text)).points[0]
    assert (point.axes, point.frame) == (axes, frame)
    np.testing.assert_allclose(np.linalg.norm(point.rows(), axis=1), 1, rtol=1e-15)


@pytest.mark.parametrize(
    ("text", "key", "found"),
    [
        ('axes = "world"', "point[0].axes", '"world"'),
        ('axes = "base"', "point[0].axes", '"base"'),
        ("axes = 3", "point[0].axes", "3"),
        ('axes = [[1, 0, 0], [0, 1, 0]]\nframe = "link"', "point[0].axes", "2 rows"),
        ('axes = [[1, 0, 0], [0, 1], [0, 0, 1]]\nframe = "link"', "point[0].axes", "row 2: a list of 2"),
        ('axes = [[1, 0, 0], [0, "1", 0], [0, 0, 1]]\nframe = "link"', "point[0].axes", 'row 2 with "1"'),
        (
            'axes = [[2, 0, 0], [0, 1, 0], [0, 0, 0]]\nframe = "link"',
            "point[0].axes",
            "row 1 of length 2, row 3 of length 0",
        ),
        (
            'axes = [[1, 0, 0], [0, nan, 0], [0, 0, 1]]\nframe = "link"',
            "point[0].axes",
            "row 2 of length nan",
        ),
        ("axes = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]", "point[0].frame", "nothing"),
        (
            'axes = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\nframe = "base"',
            "point[0].frame",
            '"base"',
        ),
        ('frame = "link"', "point[0].frame", '"link" beside no axes'),
        ('axes = "link"\nframe = "world"', "point[0].frame", '"world" beside axes = "link"'),
    ],
)
def test_what_is_refused(campaign, tmp_path, text, key, found):
    with pytest.raises(InvalidCampaign) as raised:
        read_campaign(written_with(campaign, tmp_path / "c", text))
    (fault,) = raised.value.faults
    assert (fault.key, fault.found) == (key, found)
    assert fault.file.endswith("campaign.toml")
    assert ("length 1" if key.endswith("axes") else '"world" or "link"') in fault.allowed


def test_all_faults_at_once(campaign, tmp_path):
    folder = written_with(
        campaign, tmp_path / "c", 'axes = [[2, 0, 0], [0, 1, 0], [0, 0, 1]]\nframe = "link"'
    )
    file = folder / "campaign.toml"
    file.write_text(file.read_text().replace("averages = 3", "averages = 0", 1))
    with pytest.raises(InvalidCampaign) as raised:
        read_campaign(folder)
    assert {fault.key for fault in raised.value.faults} == {"point[0].axes", "trial[0].averages"}


def test_a_campaign_in_memory_is_judged_likewise(campaign):
    with pytest.raises(InvalidCampaign) as raised:
        with_axes(campaign, axes=((2.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))
    assert [(one.key, one.found) for one in raised.value.faults] == [("point[0].axes", "row 1 of length 2")]


@pytest.mark.parametrize(
    ("rows", "says"),
    [
        (((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -1.0)), "left-handed"),
        (((1.0, 0.0, 0.0), (0.6, 0.8, 0.0), (0.0, 0.0, 1.0)), "directions 1 and 2 are 53.1° apart"),
    ],
)
def test_odd_axes_are_a_word_and_no_fault(campaign, tmp_path, rows, says):
    name = campaign.points[0].name
    report = check_campaign(write_campaign(with_axes(campaign, axes=rows, frame="link"), tmp_path / "c"))
    assert report.is_sound
    (said,) = report.warnings
    assert says in said
    assert f"point {name}:" in said


def test_square_axes_are_not_odd(campaign, tmp_path):
    report = check_campaign(write_campaign(with_axes(campaign, axes=TURNED, frame="link"), tmp_path / "c"))
    assert report.warnings == ()


def test_a_direction_of_a_link_turns_with_it():
    quarter = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    still = CampaignPoint(1, "tip", "hand", (0.0, 0.0, 0.0), TURNED, "world")
    fixed = replace(still, frame="link")
    np.testing.assert_allclose(still.way(-1, quarter), [-0.6, 0, -0.8])
    np.testing.assert_allclose(fixed.way(-1, quarter), [0, -0.6, -0.8])
    several = fixed.way(2, np.array([np.eye(3), quarter]))
    np.testing.assert_allclose(several, [[0, 1, 0], [-1, 0, 0]])
    assert (
        still.axes_text() == "x = (0.6, 0, 0.8), y = (0, 1, 0), z = (-0.8, 0, 0.6) in the frame of the world"
    )
    assert replace(fixed, axes=None).axes_text() == "the axes of hand"
