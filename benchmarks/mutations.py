"""Campaign files spoilt at random, each from its own seed."""

from __future__ import annotations

import random
import struct

NASTY = (
    b"nan", b"inf", b"-inf", b"1e999", b"-1", b"0", b"100000000", b"99999999999999999999", b"1_0", b"0x10",
    b"true", b"''", b'"', b"[", b"]", b"{", b"}", b"=", b",", b"\xff\xfe", b"\0", b"\r", b"\x0b", b"\x85",
    b"    -1\n", b"    58\n", b"    58b     1     2          11          16\n",
)  # fmt: skip
DOUBLES = (float("nan"), float("inf"), 1e300, -1e300, 5e-324, 0.0, -0.0)


def mutated(content: bytes, rng: random.Random) -> bytes:
    """The file with one to four things wrong with it."""
    for _ in range(rng.choice((1, 1, 1, 2, 4))):
        content = rng.choice(KINDS)(content, rng)
    return content


def flip(content: bytes, rng: random.Random) -> bytes:
    if not content:
        return content
    place = rng.randrange(len(content))
    return content[:place] + bytes([rng.randrange(256)]) + content[place + 1 :]


def cut(content: bytes, rng: random.Random) -> bytes:
    return content[: rng.randrange(len(content) + 1)]


def remove(content: bytes, rng: random.Random) -> bytes:
    start = rng.randrange(len(content) + 1)
    return content[:start] + content[start + rng.choice((1, 2, 8, 13, 80, 200)) :]


def insert(content: bytes, rng: random.Random) -> bytes:
    start = rng.randrange(len(content) + 1)
    return content[:start] + rng.choice(NASTY) + content[start:]


def overwrite(content: bytes, rng: random.Random) -> bytes:
    """Keeps every column where it is."""
    word = rng.choice(NASTY)
    start = rng.randrange(len(content) + 1)
    return content[:start] + word + content[start + len(word) :]


def spoil_number(content: bytes, rng: random.Random) -> bytes:
    """Another digit, sign or exponent in one place that holds a digit."""
    places = [place for place, byte in enumerate(content) if 48 <= byte <= 57]
    if not places:
        return content
    place = rng.choice(places)
    return content[:place] + rng.choice((b"0", b"9", b"-", b"e", b" ", b".", b"7")) + content[place + 1 :]


def spoil_double(content: bytes, rng: random.Random) -> bytes:
    start = rng.randrange(len(content) + 1)
    return content[:start] + struct.pack(rng.choice("<>") + "d", rng.choice(DOUBLES)) + content[start + 8 :]


def swap_lines(content: bytes, rng: random.Random) -> bytes:
    lines = content.split(b"\n")
    one, other = rng.randrange(len(lines)), rng.randrange(len(lines))
    lines[one], lines[other] = lines[other], lines[one]
    return b"\n".join(lines)


def repeat_line(content: bytes, rng: random.Random) -> bytes:
    lines = content.split(b"\n")
    place = rng.randrange(len(lines))
    return b"\n".join(lines[:place] + [lines[place]] * rng.choice((2, 3, 50)) + lines[place + 1 :])


def drop_line(content: bytes, rng: random.Random) -> bytes:
    lines = content.split(b"\n")
    del lines[rng.randrange(len(lines))]
    return b"\n".join(lines)


def splice(content: bytes, rng: random.Random) -> bytes:
    """A part of the file once more, somewhere else."""
    start = rng.randrange(len(content) + 1)
    part = content[start : start + rng.choice((40, 400, 2000))]
    place = rng.randrange(len(content) + 1)
    return content[:place] + part + content[place:]


KINDS = (
    flip, flip, cut, remove, insert, overwrite, overwrite, spoil_number, spoil_number, spoil_number,
    spoil_double, swap_lines, repeat_line, drop_line, splice,
)  # fmt: skip
