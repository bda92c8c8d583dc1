"""Cut files: what they say, and every fault of theirs at once."""

import math
from pathlib import Path

import numpy as np
import pytest

from flexmodal.errors import InvalidCut
from flexmodal.machining import Cut, CutFrame, Cutter, CuttingForce, Engagement, ToolMode, read_cut

SHIPPED = sorted((Path(__file__).parents[2] / "robots").glob("*/cuts/*.toml"))

TEXT = """format = 1
title = "A cut"
source = "made up"
[cutter]
teeth = 3
diameter = 0.02
helix = "30deg"
[force]
tangential = 7e8
radial_ratio = 0.3
tangential_edge = 2e4
[engagement]
milling = "up"
immersion = 0.25
spindle_speed = [2000, 18000]
feed_per_tooth = 1e-4
depth = 0.002
[frame]
relative_to = "tool"
axis = "+z"
feed = [1.0, 1.0, 0.0]
point = "tool"
offset = [0.0, 0.0, 0.1]
[[mode]]
direction = "x"
frequency = 800
damping_ratio = 0.03
stiffness = 1e7
"""


@pytest.fixture
def write(tmp_path):
    def run(*replacements):
        text = TEXT
        for old, new in replacements:
            assert old in text
            text = text.replace(old, new, 1)
        path = tmp_path / "cut.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return run


def test_everything_arrives(write):
    cut = read_cut(write())
    assert (cut.title, cut.source) == ("A cut", "made up")
    assert (cut.cutter.teeth, cut.cutter.diameter) == (3, 0.02)
    assert cut.cutter.helix == pytest.approx(math.radians(30))
    assert cut.cutter.approach == math.pi / 2
    np.testing.assert_allclose(cut.force.specific, [7e8, 2.1e8, 0])
    np.testing.assert_allclose(cut.force.edge, [2e4, 0, 0])
    assert cut.engagement.entry == 0
    assert cut.engagement.exit == pytest.approx(math.radians(60))  # acos(1 − 2 · 0.25)
    assert cut.engagement.spindle_speed == (2000, 18000)
    assert cut.engagement.leaves_entry_wall
    assert not cut.engagement.leaves_exit_wall
    half = math.sqrt(0.5)
    np.testing.assert_allclose(cut.frame.rows, [[half, half, 0], [-half, half, 0], [0, 0, 1]], atol=1e-15)
    assert cut.frame.offset == (0.0, 0.0, 0.1)
    assert cut.modes == (ToolMode("x", 800.0, 0.03, 1e7),)
    assert cut.tooth_period(1000.0) == pytest.approx(0.02)


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_what_ships(path):
    cut = read_cut(path)
    assert len(cut.source) > 30


def test_something_ships():
    assert SHIPPED


def test_angles_instead_of_the_immersion(write):
    cut = read_cut(write(('milling = "up"\nimmersion = 0.25', 'entry = 0.5\nexit = "180deg"')))
    assert (cut.engagement.entry, cut.engagement.exit) == (0.5, pytest.approx(math.pi))
    assert cut.engagement.leaves_exit_wall
    down = read_cut(write(('"up"', '"down"')))
    assert down.engagement.entry == pytest.approx(math.radians(120))


BAD = {
    "a mode of next to no frequency": (
        ("frequency = 800", "frequency = 1e-320"),
        "mode[0].frequency: found 1e-320; allowed: a number in Hz, above 0 (from 1e-6)",
    ),
    "a cutter of next to no size": (
        ("diameter = 0.02", "diameter = 1e-200"),
        "cutter.diameter: found 1e-200",
    ),
    "no format": (("format = 1\n", ""), "format: found nothing; allowed: 1"),
    "format 2": (("format = 1", "format = 2"), "format: found 2"),
    "format true": (("format = 1", "format = true"), "format: found true"),
    "no title": (('title = "A cut"\n', ""), "title: found nothing"),
    "empty source": (('"made up"', '" "'), "source"),
    "unknown section": (("[force]", "[forces]"), "forces: found an unknown key; allowed: did you mean"),
    "unknown key": (
        ("helix", "helixx"),
        'cutter.helixx: found an unknown key; allowed: did you mean "helix"?',
    ),
    "no tooth": (("teeth = 3", "teeth = 0"), "cutter.teeth: found 0; allowed: a whole number from 1 to 100"),
    "teeth 2.5": (("teeth = 3", "teeth = 2.5"), "cutter.teeth: found 2.5"),
    "teeth true": (("teeth = 3", "teeth = true"), "cutter.teeth: found true"),
    "no diameter": (("diameter = 0.02\n", ""), "cutter.diameter: found nothing; allowed: a number in m"),
    "diameter 0": (("0.02", "0"), "cutter.diameter: found 0"),
    "diameter nan": (("0.02", "nan"), "cutter.diameter: found nan"),
    "helix in text": (('"30deg"', '"30"'), "cutter.helix: found"),
    "helix of degrees without saying": (('"30deg"', "30"), "cutter.helix: found 30"),
    "helix negative": (('"30deg"', '"-3deg"'), "cutter.helix"),
    "force 0": (("7e8", "0.0"), "force.tangential: found 0.0"),
    "force inf": (("7e8", "inf"), "force.tangential: found inf"),
    "force text": (("7e8", '"hard"'), 'force.tangential: found "hard"'),
    "ratio": (("0.3", "70"), "force.radial_ratio: found 70"),
    "edge negative": (("2e4", "-2e4"), "force.tangential_edge"),
    "both ways": (("immersion", "entry = 0.1\nimmersion"), "engagement: found immersion, milling, entry"),
    "neither way": (('milling = "up"\nimmersion = 0.25\n', ""), "immersion and milling, or entry and exit"),
    "half a way": (('milling = "up"\n', ""), "engagement.milling: found nothing"),
    "half the other": (('milling = "up"\nimmersion = 0.25', "entry = 0.1"), "engagement.exit: found nothing"),
    "immersion 0": (("0.25", "0"), "engagement.immersion: found 0"),
    "immersion 2": (("0.25", "2"), "engagement.immersion: found 2"),
    "sideways": (('"up"', '"sideways"'), 'engagement.milling: found "sideways"; allowed: "up" or "down"'),
    "exit first": (
        ('milling = "up"\nimmersion = 0.25', 'entry = "90deg"\nexit = "80deg"'),
        "engagement.exit: found 80 degrees; allowed: more than entry, which is 90",
    ),
    "exit beyond": (('milling = "up"\nimmersion = 0.25', 'entry = 0\nexit = "190deg"'), "engagement.exit"),
    "speeds reversed": (("[2000, 18000]", "[18000, 2000]"), "engagement.spindle_speed: found [18000, 2000]"),
    "one speed": (("[2000, 18000]", "2000"), "engagement.spindle_speed: found 2000"),
    "three speeds": (("[2000, 18000]", "[1, 2, 3]"), "engagement.spindle_speed: found a list of 3"),
    "speed 0": (("[2000, 18000]", "[0, 3]"), "engagement.spindle_speed"),
    "feed alone": (("depth = 0.002\n", ""), "engagement.depth: found nothing; allowed: both"),
    "depth alone": (("feed_per_tooth = 1e-4\n", ""), "engagement.feed_per_tooth: found nothing"),
    "frame of nobody": (('"tool"', '"table"'), 'frame.relative_to: found "table"'),
    "axis 0": (('"+z"', "[0, 0, 0]"), "frame.axis: found a list of 3"),
    "axis w": (('"+z"', '"+w"'), 'frame.axis: found "+w"'),
    "feed along the axis": (('"+z"', "[1, 1, 0.0]"), "frame.feed: found 0 degrees from frame.axis"),
    "feed askew": (('"+z"', "[0, 1, 1]"), "frame.feed: found 60 degrees from frame.axis"),
    "offset": (("[0.0, 0.0, 0.1]", "[0, 0]"), "frame.offset"),
    "point": (('point = "tool"', "point = 3"), "frame.point: found 3"),
    "helix of a face mill": (('"30deg"', '"30deg"\napproach = 1.0'), "cutter.helix"),
    "mode elsewhere": (('direction = "x"', 'direction = "r"'), "mode[0].direction"),
    "mode undamped": (("0.03", "0"), "mode[0].damping_ratio: found 0"),
    "modes no list": (("[[mode]]", "[mode]"), "mode: found a table; allowed: tables [[mode]]"),
    "cutter no table": (
        ('[cutter]\nteeth = 3\ndiameter = 0.02\nhelix = "30deg"\n', ""),
        "cutter: found nothing",
    ),
    "no toml": (("[cutter]", "[cutter"), "not TOML"),
}


@pytest.mark.parametrize("kind", BAD)
def test_one_fault_at_a_time(write, kind):
    replacement, sentence = BAD[kind]
    path = write(replacement)
    with pytest.raises(InvalidCut) as caught:
        read_cut(path)
    assert all(fault.file == str(path) for fault in caught.value.faults)
    assert sentence in str(caught.value)
    if kind != "unknown section":  # of which force is missing
        assert len(caught.value.faults) == 1


def test_every_fault_at_once(write):
    path = write(
        ("format = 1", "format = 3"), ("teeth = 3", "teeth = -1"), ("7e8", "-7e8"), ("0.25", "7"),
        ('"+z"', '"up"'), ("0.03", "3"), ('"made up"', '""'), ("diameter", "diametre"),
    )  # fmt: skip
    with pytest.raises(InvalidCut) as caught:
        read_cut(path)
    keys = [fault.key for fault in caught.value.faults]
    assert keys == [
        "format", "source", "cutter.teeth", "cutter.diametre", "cutter.diameter", "force.tangential",
        "engagement.immersion", "frame.axis", "mode[0].damping_ratio",
    ]  # fmt: skip


def test_files_that_are_none(tmp_path):
    with pytest.raises(InvalidCut, match="no such file"):
        read_cut(tmp_path / "nothing.toml")
    with pytest.raises(InvalidCut, match="a folder"):
        read_cut(tmp_path)


def test_parts_made_by_hand_are_judged_too():
    with pytest.raises(InvalidCut) as caught:
        Cutter(0, -1.0)
    assert [fault.key for fault in caught.value.faults] == ["cutter.teeth", "cutter.diameter"]
    for make in (
        lambda: CuttingForce(-1.0),
        lambda: Engagement(1.0, 0.5, (1.0, 2.0)),
        lambda: CutFrame("tool", "+z", "-z"),
        lambda: ToolMode("x", 1.0, 2.0, 1.0),
    ):
        with pytest.raises(InvalidCut):
            make()
    cut = Cut(
        Cutter(2, 0.01), CuttingForce(1e8), Engagement(0.0, 1.0, (1.0, 2.0)), CutFrame("tool", "+z", "+y")
    )
    assert cut.frame.axis == (0.0, 0.0, 1.0)
