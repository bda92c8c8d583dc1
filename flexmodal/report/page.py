"""Pages: one shell and one style sheet, filled with parts.

A page needs no network: the style is in it, pictures are in it, and no script runs but those that `Live`
parts bring. Its content security policy says so to the browser, script by script, and whatever is not made
here is escaped.
"""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from flexmodal.files import whole_file
from flexmodal.report.parts import Live, Part, Parts, Section, Verdict, json_text

_HERE = Path(__file__).parent


def page_text(title: str, lead: Parts = (), sections: Sequence[Section] = ()) -> str:
    """A page as text.

    Args:
        title: heading of the page; small where a verdict leads.
        lead: what comes before the first heading.
        sections: headings with what stands under them.
    """
    kicker = any(isinstance(part, Verdict) for part in lead)
    template = _environment().get_template("base.html")
    scripts = _scripts([*lead, *(part for section in sections for part in section.parts)])
    return str(template.render(title=title, lead=lead, sections=sections, kicker=kicker, scripts=scripts))


def _scripts(parts: Sequence[Part | str]) -> list[dict[str, str]]:
    """Each script once, with the digest by which the policy lets it run."""
    found = []
    for text in dict.fromkeys(part.script for part in parts if isinstance(part, Live)):
        digest = base64.b64encode(hashlib.sha256(text.encode("utf-8")).digest()).decode("ascii")
        found.append({"text": text, "digest": f"sha256-{digest}"})
    return found


def write_page(path: Path, text: str, *, overwrite: bool = False) -> None:
    """Write a page, whole or not at all.

    Args:
        path: a new file.
        text: as `page_text` gives it.
        overwrite: replace a file that stands there.

    Raises:
        OutputExists: the file exists.
        NotWritten: the disk is full, or the folder may not be written.
    """
    with whole_file(path, overwrite=overwrite) as scratch:
        scratch.write_text(text, encoding="utf-8")


def write_json(value: Mapping[str, Any], path: Path, *, overwrite: bool = False) -> None:
    """Write an object as a JSON file; it may hold finite numbers only.

    Args:
        value: the object.
        path: a new file.
        overwrite: replace a file that stands there.

    Raises:
        OutputExists: the file exists.
        NotWritten: the disk is full, or the folder may not be written.
    """
    write_page(path, json_text(value), overwrite=overwrite)


@cache
def _environment() -> Any:
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    environment = Environment(
        loader=FileSystemLoader(_HERE), autoescape=True, undefined=StrictUndefined, trim_blocks=True,
        lstrip_blocks=True,
    )  # fmt: skip
    environment.tests["part"] = lambda value, kind: type(value).__name__ == kind
    environment.globals["style"] = (_HERE / "page.css").read_text(encoding="utf-8")
    return environment
