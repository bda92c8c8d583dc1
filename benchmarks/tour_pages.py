"""What a reader of a page of the documentation does with it, in the order in which it stands there.

Fenced blocks, by the word after the fence:

- `console`: each line that begins with `$ ` is a command; `sh`: each line;
- `python`: run in order, the blocks of a page sharing their names;
- any kind with `title="FILE"`: the reader writes that file; with `title="FILE, added at its end"`, its end;
- `output`, straight after one of these: what it prints, all of it after Python; after commands each of its
  words, wherever the table of the day puts them.
"""

from __future__ import annotations

import re
import shlex
from dataclasses import dataclass
from pathlib import Path

FENCE = re.compile(r"^```(\w+)([^\n]*)\n(.*?)^```\s*$", re.MULTILINE | re.DOTALL)
TITLE = re.compile(r'title="([^",]+)(, added at its end)?"')
RULES = re.compile(r"[─━│┃|┌┐└┘├┤┬┴┼]+")


@dataclass(frozen=True)
class Step:
    """One thing to do."""

    kind: str
    """"commands", "python", "file", or "addition" to a file."""
    text: str
    title: str = ""
    expected: str | None = None
    """What it prints, where the page says so."""

    @property
    def writes(self) -> bool:
        """Whether the reader writes a file, or into one."""
        return self.kind in ("file", "addition")

    def write(self, folder: Path) -> None:
        """Do as the reader does: write the file, or go to its end and add a blank line and the text."""
        target = folder / self.title
        target.parent.mkdir(parents=True, exist_ok=True)
        before = target.read_text(encoding="utf-8") + "\n" if self.kind == "addition" else ""
        target.write_text(before + self.text, encoding="utf-8")

    @property
    def commands(self) -> list[str]:
        """The command lines, those that a backslash breaks put together again."""
        lines = self.text.replace("\\\n", " ").splitlines()
        if any(line.startswith("$ ") for line in lines):
            return [line[2:] for line in lines if line.startswith("$ ")]
        return [line for line in lines if line.strip() and not line.startswith("#")]

    def missing(self, printed: str) -> list[str]:
        """Words the page shows that were not printed; after Python the whole has to be the same."""
        if self.expected is None:
            return []
        if self.kind == "python":
            return [] if printed.strip() == self.expected.strip() else [self.expected.strip()]
        there = set(RULES.sub(" ", printed).split())
        return [word for word in RULES.sub(" ", self.expected).split() if word not in there]


def steps(page: Path) -> list[Step]:
    """What a page asks its reader to do."""
    found: list[Step] = []
    text = page.read_text(encoding="utf-8")
    end = 0
    for block in FENCE.finditer(text):
        kind, rest, content = block.groups()
        title = TITLE.search(rest)
        if title:
            found.append(Step("addition" if title[2] else "file", content, title[1]))
        elif kind in ("console", "sh"):
            found.append(Step("commands", content))
        elif kind == "python":
            found.append(Step("python", content))
        elif kind == "output":
            if not found or found[-1].writes or text[end : block.start()].strip():
                raise ValueError(f"{page}: output that follows nothing that prints")
            last = found.pop()
            found.append(Step(last.kind, last.text, last.title, content))
        end = block.end()
    return found


def words(command: str) -> list[str]:
    """The words of a command line, without comments."""
    return shlex.split(command, comments=True)
