"""Files spoilt at random, each from its own seed: bytes, lines, and what a format is made of."""

from __future__ import annotations

import random
import re
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


def other_number(content: bytes, rng: random.Random) -> bytes:
    """Another number for a whole one, so that the file stays what it is."""
    places = list(_NUMBER.finditer(content))
    if not places:
        return content
    place = rng.choice(places)
    old = place[0]
    new = rng.choice((*NUMBERS, old + rng.choice((b"e3", b"e-3", b"e9", b"e-9", b"e150")), b"-" + old))
    return content[: place.start()] + new + content[place.end() :]


def other_word(content: bytes, rng: random.Random) -> bytes:
    """A word of the file in place of another."""
    places = list(_WORD.finditer(content))
    if not places:
        return content
    place = rng.choice(places)
    return content[: place.start()] + rng.choice(places)[0] + content[place.end() :]


def drop_lines(content: bytes, rng: random.Random) -> bytes:
    """A table, an element or a record less."""
    lines = content.split(b"\n")
    start = rng.randrange(len(lines))
    del lines[start : start + rng.choice((2, 3, 5, 9, 20))]
    return b"\n".join(lines)


def nest(content: bytes, rng: random.Random) -> bytes:
    """Deeper than anybody writes."""
    place = rng.randrange(len(content) + 1)
    depth = rng.choice((30, 300, 3000))
    return (
        content[:place] + rng.choice((b"[", b"{", b"<a>", b"(", b"a.", b'"', b"-")) * depth + content[place:]
    )


_NUMBER = re.compile(rb"(?<![\w.])-?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?(?![\w.])")
_WORD = re.compile(rb"[A-Za-z_][\w-]*")
NUMBERS = (
    b"0", b"-0.0", b"1e-320", b"1e-18", b"1e-9", b"1e-3", b"1", b"2", b"3", b"7", b"0.5", b"1e3", b"1e6",
    b"1e9", b"1e18", b"1e99", b"1e154", b"1e300", b"1e999", b"nan", b"inf", b"-1", b"-1e-9", b"-1e18",
    b"9007199254740993", b"18446744073709551616", b"0.1e1", b"1_000", b"0b1", b"0o7", b"+1", b"1.", b".5",
)  # fmt: skip
KINDS = (
    flip, flip, cut, remove, insert, overwrite, overwrite, spoil_number, spoil_number, spoil_number,
    spoil_double, swap_lines, repeat_line, drop_line, splice, other_number, other_number, other_number,
    other_number, other_number, other_word, other_word, drop_lines, nest,
)  # fmt: skip
