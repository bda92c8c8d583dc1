"""One input of each target of the fuzz: made from its number, handed in, and judged.

Readers are called as the commands call them, in this process; every `AGAIN`-th input goes through the command
itself as well, which has to come to the same end. What is judged of every input: it is accepted or refused
with sentences, each shorter than 2 kB, that steer no terminal and name the file; what is accepted, a second
reader of `fuzz_judges` accepts too, with the same numbers.
"""

from __future__ import annotations

import contextlib
import io
import json
import random
import re
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import fuzz_campaign
from fuzz_judges import AT, JUDGES, SOUND, Misread
from mutations import mutated

import flexmodal
from flexmodal.cards import catalogue
from flexmodal.cli.main import main as flexmodal_command
from flexmodal.cli.options import posture_of
from flexmodal.cli.printing import plain
from flexmodal.errors import FlexmodalError, InvalidInput
from flexmodal.optimisation.path import read_toolpath

LONGEST = 2000
"""Characters of one sentence."""
MOST_SENTENCES = 400
AGAIN = {"urdf": 20, "card": 20, "cut": 15, "toolpath": 1000, "posture": 20}
"""Of each so many inputs one goes through the command, which for a path or for lobes takes its time."""
ENDS = ("accepted", "answered no", "refused")
JOINTS = ("q1", "q2", "q3", "rho", "q9", "", "tool", "ΩÅ")
VALUES = (
    "0", "1", "-1", "0.5", "50deg", "-30deg", "1e999", "nan", "inf", "-inf", "1e-320", "1_0", "0x10",
    "²", "1,2", "",
    " ", "1e", "--", "deg", "180deg", "1e308deg", "9" * 400, "\x1b[31m", "\u202e1", "1:2:3", "٣",
    "true", "None",
)  # fmt: skip
WORDS = (
    "fanuc_s360", "six_link", "six_axis", "nobody", "", ".", "/", "/dev/null", "~", "tool:+z",
    "tool:+q", ":", "tool:",
    "configuration_1", "1:20:1", "1:2", "5", "1,5,20", "1:1e9:1e-9", "-1", "0", "nan", "1e999",
    "0.9,0.6", "x,y",
    "second_link_horizontal", "zero-order", "receptance", "best", "\x1b]0;x\x07", "a" * 3000, "q1=1",
    "q1=1:2:3",
)  # fmt: skip
OPTIONS = {
    "frf": ("--posture", "--frequencies", "--response", "--reference", "--form", "--json"),
    "modes": ("--posture", "--json"),
    "measures": ("--posture", "--direction", "--frequency", "--task", "--json"),
    "tune": ("--posture", "--band", "--direction", "--json"),
    "check": ("--json",),
    "lobes": ("--posture", "--cut", "--method", "--speeds", "--json"),
    "optimise": ("--hold", "--family", "--free", "--frequency", "--starts", "--seed", "--json", "--quiet"),
    "path": ("--toolpath", "--line", "--arc", "--feed", "--points", "--frequency", "--json", "--quiet"),
    "atlas": (
        "--grid", "--sample", "--range", "--frequencies", "--direction", "--quantity", "--workers", "--json",
    ),
    "lookup": ("--nearest", "--interpolate", "--best", "--frequency", "--near", "--radius", "--json"),
}  # fmt: skip
FLAGS = {"--json", "--free", "--quiet"}
SMALL = {"--starts": ("1", "2"), "--speeds": ("5", "20"), "--points": ("2", "4"), "--sample": ("1", "20")}
"""Sound values that keep a run short; others are tried as well."""


def run(words: list[str]) -> tuple[int, str, str]:
    """A command in this process."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            flexmodal_command(words)
        except SystemExit as left:
            return int(left.code or 0), out.getvalue(), err.getvalue()
    raise Misread("a command that did not end by its own status")


def check_told(status: int, out: str, err: str, *, quoted: bool = False) -> None:
    """What a command may say.

    Raises:
        Misread: it says too much, or not what it should.
    """
    if status not in (0, 1, 2):
        raise Misread(f"status {status}")
    if "Traceback" in err or "Warning" in err:
        raise Misread(f"a traceback or a warning: {err[-800:]}")
    if status == 2 and not err.strip():
        raise Misread("a refusal without a word")
    _check_sentences(err.splitlines())
    steering = [sign for sign in out + err if ord(sign) < 32 and sign not in "\n\t"]
    if steering and not quoted:
        raise Misread(f"{steering[0]!r} goes to the terminal")
    if status == 0 and re.search(r"\b(NaN|Infinity)\b", out):
        raise Misread("NaN or Infinity in JSON")


def refusal(error: FlexmodalError, names: tuple[str, ...]) -> str:
    """How a refusal ends, checked as the command line would say it.

    Raises:
        Misread: it is too long, or names neither the file nor what is asked for.
    """
    told = plain(str(error))
    if not told.strip():
        raise Misread("a refusal without a word")
    _check_sentences(told.splitlines())
    if not isinstance(error, InvalidInput):
        return "answered no"
    if not error.faults or not all(fault.found and fault.allowed for fault in error.faults):
        raise Misread(f"a refusal without its evidence: {told[:400]}")
    if names and not any(name in told for name in names):
        raise Misread(f"a refusal that does not name the file: {told[:400]}")
    return "refused"


def _check_sentences(lines: list[str]) -> None:
    longest = max(map(len, lines), default=0)
    if longest > LONGEST or len(lines) > MOST_SENTENCES:
        start = max(lines, key=len)[:200]
        raise Misread(f"{len(lines)} lines, the longest of {longest} characters: {start!r}")


def spoilt_file(target: str, rng: random.Random, number: int, folder: Path) -> str:
    """A spoilt file, read."""
    for text, file, _ in SOUND.values():
        if not (folder / file).is_file():
            (folder / file).write_bytes(text)
    sound, name, _ = SOUND[target]
    (folder / name).write_bytes(mutated(sound, rng))
    try:
        return read_file(target, folder, again=number % AGAIN[target] == 0)
    finally:
        (folder / name).write_bytes(sound)


def read_file(target: str, folder: Path, *, again: bool = False) -> str:
    """What comes of a target's file in a folder that holds all of them."""
    _, name, words = SOUND[target]
    try:
        told = READERS[target](folder / name)
    except FlexmodalError as error:
        ended = refusal(error, (name, str(folder), "--posture"))  # limits that the posture lies beyond
    else:
        JUDGES[target](folder / name, told)
        ended = "accepted"
    if again:
        status, out, err = run([word.replace("FOLDER", str(folder)) for word in words])
        check_told(status, out, err)
        if status == 0:
            JUDGES[target](folder / name, json.loads(out))
        if (status == 0) < (ended == "accepted") and status == 2 and name in err:
            raise Misread(f"accepted here, and refused by the command: {err[:400]}")
    return ended


def _measures(path: Path) -> dict[str, Any]:
    robot = flexmodal.load(path.with_name("robot.toml"))
    found = robot.measures(posture_of(robot, AT[1]), frequency=5.0)
    receptance = complex(found.receptance or 0)
    return {
        "_read": robot,
        "stiffness": found.stiffness,
        "mobility": found.mobility,
        "static_receptance": found.static_receptance,
        "receptance": [receptance.real, receptance.imag],
        "tool": list(found.tool),
    }


READERS: dict[str, Callable[[Path], dict[str, Any]]] = {
    "urdf": _measures,
    "card": _measures,
    "cut": lambda path: {"_read": flexmodal.read_cut(path)},
    "toolpath": lambda path: {"_read": read_toolpath(path, planar=True, feed=0.1)},
}
"""What is read of a file, and what is told of it."""


@cache
def _arm() -> flexmodal.Robot:
    return flexmodal.load("fanuc_s360")


def posture(rng: random.Random, number: int) -> str:
    """A posture in words, which has its own grammar."""
    parts = [
        f"{rng.choice(JOINTS)}{rng.choice('====: ')}{rng.choice(VALUES)}"
        for _ in range(rng.choice((1, 1, 2, 3)))
    ]
    return read_posture(
        rng.choice((",", ",", ",", ";", ",,")).join(parts), again=number % AGAIN["posture"] == 0
    )


def read_posture(text: str, *, again: bool = False) -> str:
    """What comes of a posture in words."""
    arm = _arm()
    try:
        told = arm.measures(posture_of(arm, text))
    except FlexmodalError as error:
        ended = refusal(error, ())
    else:
        JUDGES["posture"](text, {"tool": list(told.tool)}, arm)
        ended = "accepted"
    if again:
        status, out, err = run(["measures", "fanuc_s360", "--posture", text, "--json"])
        check_told(status, out, err)
        if status == 0:
            JUDGES["posture"](text, json.loads(out), arm)
        if (status == 0) != (ended == "accepted"):
            raise Misread(f"{ended}, and status {status} of the command: {err[:400]}")
    return ended


def arguments(rng: random.Random, folder: Path) -> str:
    """Options of a command in any order, with values that fit and that do not."""
    command = rng.choice([*OPTIONS] * 5 + ["robots"])
    words = [command]
    if command != "robots":
        words.append(rng.choice(WORDS[:3]) if rng.random() < 0.7 else rng.choice(WORDS))
    options = OPTIONS.get(command, ("--json",))
    for option in rng.sample(options, rng.randrange(len(options) + 1)):
        words.append(option)
        if option not in FLAGS:
            sound = SMALL.get(option)
            words.append(rng.choice(sound) if sound and rng.random() < 0.7 else rng.choice(WORDS + VALUES))
    if command == "atlas":
        words += ["--out", str(folder / "a.zarr")]
    return read_arguments(words)


def read_arguments(words: list[str]) -> str:
    """What comes of a call."""
    status, out, err = run(words)
    check_told(status, out, err, quoted=words[0] == "lookup")
    if status == 0 and "--json" in words:
        JUDGES["arguments"](words, json.loads(out))
    return ENDS[status]


def campaign(rng: random.Random, number: int, folder: Path) -> str:
    """A spoilt file of a campaign, read with the sound others."""
    names = fuzz_campaign.names()
    name = names[number % len(names)]
    try:
        fuzz_campaign.read_one(name, mutated(fuzz_campaign.sound()[name][0], rng), folder)
    except FlexmodalError as error:
        return refusal(error, ("campaign.toml", str(folder)))
    return "accepted"


TARGETS: dict[str, Callable[[random.Random, int, Path], str]] = {
    "urdf": lambda rng, number, folder: spoilt_file("urdf", rng, number, folder),
    "card": lambda rng, number, folder: spoilt_file("card", rng, number, folder),
    "cut": lambda rng, number, folder: spoilt_file("cut", rng, number, folder),
    "toolpath": lambda rng, number, folder: spoilt_file("toolpath", rng, number, folder),
    "posture": lambda rng, number, folder: posture(rng, number),
    "arguments": lambda rng, number, folder: arguments(rng, folder),
    "campaign": campaign,
}


def one(target: str, seed: int, number: int, folder: Path) -> str:
    """Input `number` of a target, in a folder that is empty, or of a spoilt file holds the sound others.

    Raises:
        Misread: something happened that may not.
    """
    return TARGETS[target](random.Random(f"{seed} {target} {number}"), number, folder)


example_arms, shipped_cards = cache(catalogue.example_arms), cache(catalogue.shipped_cards)


def warm() -> None:
    """What is imported or made on first use is there before memory and time are looked at.

    The lists of robots that ship and of example arms are looked up once instead of for each input.
    """
    catalogue.example_arms, catalogue.shipped_cards = example_arms, shipped_cards
    read_posture("q1=1", again=True)
    fuzz_campaign.names()
    run(["lobes", "fanuc_s360", "--posture", "q1=1", "--cut", "aluminium", "--speeds", "5", "--json"])
