"""A campaign folder to fill in: its `campaign.toml` complete, with what each line is for."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence

from flexmodal.campaign.description.tested import USUAL

_TRIALS = (
    "# A trial is a kind of blow and has the version number of its records. Two trials of one kind tell",
    "# the noise; averages are the blows in each FRF; record_length tells where the record ends.",
    "[[trial]]",
    "id = 1",
    "force_peak = 100.0    # N",
    "averages = 3",
    'tip = "soft"',
    "record_length = 4.0   # s",
    'window = "none"       # or { kind = "exponential", decay = 3.0 }, 1/s',
    "",
    "[[trial]]",
    "id = 2",
    "force_peak = 100.0",
    "averages = 3",
    'tip = "soft"',
    "record_length = 4.0",
    "repeat_of = 1",
)


def new_campaign_toml(
    title: str,
    robot: str,
    postures: Mapping[str, Mapping[str, float]],
    points: Mapping[str, tuple[str, Sequence[float]]],
) -> str:
    """The text of a `campaign.toml` that reads as it stands.

    Args:
        title: of the test.
        robot: name of a card, or a path relative to the folder.
        postures: joint values by name [rad, m].
        points: link and place in its frame [m] by name.
    """
    lines = [
        "# A hammer test. Commands take from here what the data do not say: look at every line.",
        "format = 1",
        f"title = {_text(title)}",
        f"robot = {_text(robot)}     # a card's name, or a path relative to this file",
        "band = [2.0, 200.0]   # Hz: lines to compare, from what the sensor hears to what the tip excites",
        "# separate_modes = true   # where modes.csv was measured apart, not estimated from these FRFs",
        "",
        "# How well the test was set up: one standard deviation each. 0: exact; without the table all is.",
        "[tolerance]",
        f"posture = {USUAL.posture}      # rad, of each joint (m of a slide)",
        f"position = {USUAL.position}    # m, of hammer and sensor",
        f"direction = {USUAL.direction}    # rad, likewise",
        f"gain = {USUAL.gain}         # relative, of each sensor and the hammer",
        "",
        "# A posture has the load case number of its records. Angles in rad, not degrees; all joints.",
    ]
    for number, (name, q) in enumerate(postures.items(), start=1):
        angles = ", ".join(f"{_text(joint)} = {float(value)!r}" for joint, value in q.items())
        inside = f"{{ {angles} }}" if angles else "{}"
        lines += ["[[posture]]", f"id = {number}", f"name = {_text(name)}", f"q = {inside}", ""]
    lines += [
        "# A point has the node number of its records, and sits on a link: xyz in m, in the link's frame.",
        "# Directions 1, 2, 3 of its records are the world's x, y, z; of a sensor glued to the tool they are",
        '# those of its link, axes = "link"; three unit vectors are axes = [[…], […], […]] with a line',
        '# frame = "link" or "world".',
    ]
    for number, (name, (link, xyz)) in enumerate(points.items(), start=1):
        place = [float(value) for value in xyz]
        lines += ["[[point]]", f"id = {number}", f"name = {_text(name)}", f"link = {_text(link)}"]
        lines += [f"xyz = {place}", ""]
    lines += _TRIALS
    return "\n".join(lines) + "\n"


def _text(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)
