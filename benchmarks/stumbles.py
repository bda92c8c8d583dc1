"""The stumbles of a newcomer's first afternoon, each tried again: docs/tables/stumbles.md.

    python benchmarks/stumbles.py

Every command runs in a pseudo-terminal of 80 columns, in a folder of its own that holds a universal file, an
empty table and a faulty card. It has to end as it should, to show what it should, and to cut no number. The
tour runs them too, in its empty environment, and so do the tests.
"""

from __future__ import annotations

import os
import re
import shutil
import sys
import tempfile
import textwrap
from dataclasses import dataclass
from pathlib import Path

from terminal import COLUMNS, CUT, in_terminal

ROOT = Path(__file__).resolve().parents[1]
OUT = ROOT / "docs" / "tables" / "stumbles.md"
MEASURED = ROOT / "tests" / "data" / "real" / "laboratory_hammer" / "frf.uff"
_FIRST, _LAST = 13, 5
"""Lines of a long output that are shown."""
_BAR = re.compile(r"\d+%\||left$|^\w+ \d\d:\d\d$|: \d+%")
_TABLE = """
[obstacle.table]
box = [1.6, 1.6, 0.05]
xyz = [0.0, 0.0, -0.03]

[obstacle.fixture]
box = [0.2, 0.3, 0.25]
xyz = [0.6, 0.2, 0.12]
"""
_UR5 = "--stiffness 2e4 --damping 30"


@dataclass(frozen=True)
class Stumble:
    """Something that went wrong, and the command that shows that it does not."""

    name: str
    before: str
    """What was met."""
    command: str
    shows: tuple[str, ...]
    """Words of the output."""
    status: int = 0
    hides: str = ""
    """What must not be in the output."""

    def faults(self, status: int, printed: str) -> list[str]:
        """Sentences about an outcome that is not as it should be."""
        one_line = " ".join(printed.split())
        found = [f"{self.name}: not shown: {words}" for words in self.shows if words not in one_line]
        found += [
            f"{self.name}: cut off: {line.strip()}" for line in printed.splitlines() if CUT.search(line)
        ]
        if status != self.status:
            found.append(f"{self.name}: exit status {status}, not {self.status}")
        if "Traceback" in printed or (self.hides and self.hides in one_line):
            found.append(f"{self.name}: shown, though it should not be\n{printed}")
        return found


def python(code: str) -> str:
    """A command that runs some lines of Python."""
    return f"python -c '{code}'"


STUMBLES = (
    Stumble(
        "An example arm that was not installed",
        "The command of the README failed for want of the extra `arms`; its message named neither.",
        f"flexmodal frf ur5 {_UR5} --posture elbow_joint=80deg --frequencies 1:50:10",
        ("ur5 at", "amplitude [m/N]", "elbow_joint=80deg"),
    ),
    Stumble(
        "Shipped data, outside a checkout",
        "The cut was a path that only a checkout has.",
        "flexmodal lobes fanuc_s360 --posture configuration_1 --cut aluminium",
        ("critical depth over the range of speeds", "Side milling aluminium"),
    ),
    Stumble(
        "A posture as an array",
        "`robot.at(q)` ended in an AttributeError.",
        python("import flexmodal; arm = flexmodal.load(\"six_link\"); "
               "print(arm.at([0.5, 0.2, 0.1, 0.1, 0.1, 0.1]).position(\"tool\").round(3))"),
        ("[3.955 0. 4.357]",),
    ),
    Stumble(
        "A direction as a text",
        "`tool:+z` was understood by some functions, `PointDirection(\"tool\", \"+z\")` by none.",
        python("import flexmodal; print(flexmodal.PointDirection(\"tool\", \"+z\"), "
               "flexmodal.load(\"six_link\").frf(\"start_2\", [5.0], response=\"tool:+z\").response)"),
        ("tool:+z (PointDirection('tool:+z'),)",),
    ),
    Stumble(
        "A robot printed",
        "Its `repr` had 14 460 characters.",
        python("import flexmodal; arm = flexmodal.load(\"six_link\"); print(len(repr(arm)) < 200, arm)"),
        ("True <Robot six_link, joints q1 q2 q3 q4 q5 q6",),
    ),
    Stumble(
        "Functions where they are looked for",
        "Beside `load` and `optimise` everything had to be imported from rooms inside.",
        python("import flexmodal as f; print(all(map(callable, (f.read_campaign, f.fit, f.identify, "
               "f.diagnose, f.simulate, f.tune, f.lobes))))"),
        ("True",),
    ),
    Stumble(
        "Numbers that were cut",
        "At 80 columns a stiffness was `1.539…`, and four rows were called `stiffness.…`.",
        "flexmodal identify fanuc_s360/thesis --kinds stiffness,damping",
        ("stiffness.rho 209910 N·m/rad", "damping.q3"),
    ),
    Stumble(
        "Angles in another unit than was typed",
        "A posture typed in radians was answered in degrees.",
        f"flexmodal optimise ur5 {_UR5} --hold 0.4,0.1,0.5 --frequency 10 --starts 8 "
        "--start shoulder_lift_joint=-1.0,elbow_joint=1.2",
        ("[rad]",),
        hides="°",
    ),
    Stumble(
        "American spelling",
        "`optimize` was no command, and nothing said what was.",
        "flexmodal optimize six_link --free",
        ("Did you mean 'optimise'?",),
        status=2,
    ),
    Stumble(
        "A posture that is not there",
        "The complaint did not say which there are.",
        "flexmodal modes six_link --posture nowhere",
        ("found 'nowhere'", "start_1, start_2, start_3"),
        status=2,
    ),
    Stumble(
        "Work without a sign",
        "`fit`, `identify` and `lobes` were silent until they were done.",
        "flexmodal fit mine.uff --per posture",
        ("fitting", "frequency"),
    ),
    Stumble(
        "A direction that a planar arm cannot move in",
        "The receptance was 0, without a word.",
        "flexmodal frf six_link --posture start_2 --frequencies 5 --response tool:+y",
        ("no flexible joint moves tool:+y", "the receptance there is zero"),
    ),
    Stumble(
        "A measured file shown",
        "It was taken for a robot.",
        "flexmodal show mine.uff",
        ("a universal file by itself", "flexmodal fit FILE --out modes.html"),
        status=2,
    ),
    Stumble(
        "A table of numbers fitted",
        "It was no campaign, and nothing said how it becomes one.",
        "flexmodal fit x.csv",
        ("flexmodal import x.csv --draft map.toml",),
        status=2,
    ),
    Stumble(
        "JSON without a description",
        "`modes --json` had keys that had to be guessed.",
        "flexmodal modes --json-schema",
        ("\"title\": \"flexmodal modes --json\"",),
    ),
    Stumble(
        "Faults one at a time",
        "`check` told those of the card, and those of the URDF when the card was mended.",
        "flexmodal check faulty",
        ("damping: found -1.0", "mass"),
        status=1,
    ),
    Stumble(
        "A default that did not exist",
        "`tool:+z` worked where a link has that name only.",
        f"flexmodal measures ur5 {_UR5} --posture elbow_joint=1",
        ("ee_link:+z", "stiffness measure"),
    ),
    Stumble(
        "A card for an arm of one's own",
        "It had to be written by hand.",
        "flexmodal card new ur5 --out my_ur5",
        ("stiffness, guessed", "next: flexmodal modes my_ur5 --posture middle"),
    ),
    Stumble(
        "A start that does not hold the target",
        "It was compared with the best posture of another place: a factor of 3.6 or 8.2.",
        "flexmodal optimise six_link --hold -2,2 --frequency 5 --start start_2 --starts 16",
        ("start as given: 5.5102e-05 m/N, but its tool is 193.3 mm from the target, so it is not compared",
         "start brought to the target 4.8851e-05 m/N"),
    ),
    Stumble(
        "Nine best postures that are one",
        "Postures that differ in an idle wrist were listed each, and angles beyond a turn; \"converged\" "
        "stood beside \"try more starts\".",
        f"flexmodal optimise ur5 {_UR5} --hold 0.4,0.1,0.5 --frequency 10 --starts 8",
        ("stand for several postures of one value", "converged;"),
        hides="more starts may find",
    ),
    Stumble(
        "An elbow in the table",
        "Nothing looked for collisions, and nothing said so.",
        "flexmodal optimise beside_a_table --hold 0.4,0.1,0.3 --frequency 10 --starts 4",
        ("pairs checked against table, fixture and itself", "(10 mm asked)"),
        hides="none checked",
    ),
    Stumble(
        "Arms drawn as sticks",
        "Meshes in COLLADA could not be read.",
        f"flexmodal show panda {_UR5} --out panda.html; ! grep \"is not shown\" panda.html",
        ("panda.html",),
    ),
    Stumble(
        "A way to other programs",
        "There was none.",
        "flexmodal export six_axis --posture work --as mujoco --out arm.xml",
        ("wrote arm.xml",),
    ),
)  # fmt: skip


def prepare(folder: Path) -> None:
    """Put what the commands are about into a folder: a measured file, an empty table, two cards."""
    from flexmodal.model.guess import guess_card

    shutil.copy(MEASURED, folder / "mine.uff")
    (folder / "x.csv").write_text("", encoding="utf-8")
    sound = guess_card("ur5", folder / "beside_a_table").write()
    sound.write_text(sound.read_text(encoding="utf-8") + _TABLE, encoding="utf-8")
    card = guess_card("ur5", folder / "faulty").write()
    text = card.read_text(encoding="utf-8")
    card.write_text(
        re.sub(r"^damping = .*$", "damping = -1.0", text, count=1, flags=re.MULTILINE), encoding="utf-8"
    )
    (urdf,) = card.parent.glob("*.urdf")
    bodies = urdf.read_text(encoding="utf-8")
    urdf.write_text(re.sub(r'<mass value="[^"]*"', '<mass value="-2"', bodies, count=1), encoding="utf-8")


def page(told: list[tuple[Stumble, str]]) -> str:
    """The table as a page."""
    head = """
        What a newcomer met in one afternoon, and what the same command does now in a terminal of 80 columns.
        `python benchmarks/stumbles.py` writes this page; `make tour` and the tests run each command. Three
        more have no command: the documentation was no site (`make docs`), labels of fit pages and of
        self-motion pictures were clipped (drawn again and looked at), and a Python started in the folder
        above the clone found an empty package (`tests/distribution/test_above_the_clone.py`).
    """
    parts = ["# Stumbles mended\n", textwrap.fill(" ".join(head.split()), 118, break_on_hyphens=False) + "\n"]
    for number, (stumble, printed) in enumerate(told, start=1):
        lines = [line.rstrip() for line in printed.splitlines() if not _BAR.search(line)]
        lines = [line for line in lines if line.strip()]
        is_long = len(lines) > _FIRST + _LAST + 1
        shown = [*lines[:_FIRST], "[…]", *lines[-_LAST:]] if is_long else lines
        block = "\n".join(shown)
        parts.append(
            f"## {number}. {stumble.name}\n\nThen: {stumble.before}\n\n"
            f"```text\n$ {stumble.command}\n{block}\n```\n"
        )
    return "\n".join(parts)


def main() -> int:
    """Try each, write the page, say what is not as it should be."""
    told, faults = [], []
    with tempfile.TemporaryDirectory() as scratch:
        prepare(Path(scratch))
        for stumble in STUMBLES:
            words = ["bash", "-c", stumble.command]
            environment = {**os.environ, "TERM": "xterm-256color"}
            status, printed, silence = in_terminal(words, Path(scratch), environment, give_up=300.0)
            print(f"{stumble.name}: {silence:.1f} s the longest silence", flush=True)
            told.append((stumble, printed.replace(f"{scratch}/", "")))
            faults += stumble.faults(status, printed)
    for fault in faults:
        print(f"FAULT {fault}")
    if not faults:
        OUT.write_text(page(told), encoding="utf-8")
        print(f"{len(told)} commands of {COLUMNS} columns; wrote {OUT.relative_to(ROOT)}")
    return int(bool(faults))


if __name__ == "__main__":
    sys.exit(main())
