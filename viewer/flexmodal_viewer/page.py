"""A scene as one HTML file that needs nothing else, not even a network."""

from __future__ import annotations

import importlib.util
import json
import re
from functools import cache
from html import escape
from importlib.resources import files
from pathlib import Path

from flexmodal.errors import MissingExtra
from flexmodal.files import whole_file
from flexmodal_viewer.caption import caption_html
from flexmodal_viewer.commands import payload
from flexmodal_viewer.scene import Scene


def write_page(scene: Scene, path: str | Path, *, overwrite: bool = False) -> Path:
    """Write a scene as a page, whole or not at all.

    Raises:
        OutputExists: the file exists and `overwrite` is false, or its folder does not exist.
    """
    target = Path(path)
    with whole_file(target, overwrite=overwrite) as scratch:
        scratch.write_text(page_html(scene), encoding="utf-8")
    return target


def page_html(scene: Scene) -> str:
    """The page as text; of one scene always the same."""
    viewer = _meshcat()
    parts = {
        "title": escape(scene.caption.title),
        "css": _asset("page.css"),
        "caption": caption_html(scene),
        "scene": _json(payload(scene)),
        "licences": (viewer / "main.min.js.LICENSE.txt").read_text(encoding="utf-8").replace("*/", ""),
        "meshcat": (viewer / "main.min.js").read_text(encoding="utf-8"),
        "js": _asset("page.js"),
    }
    # One pass: nothing that is put in is looked at again.
    return re.sub(r"\{\{(\w+)\}\}", lambda match: parts[match[1]], _asset("page.html"))


def _json(value: object) -> str:
    """JSON that cannot end the script element it stands in."""
    text = json.dumps(value, separators=(",", ":"), ensure_ascii=True, allow_nan=False)
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


@cache
def _asset(name: str) -> str:
    return (files("flexmodal_viewer") / "assets" / name).read_text(encoding="utf-8")


@cache
def _meshcat() -> Path:
    """Where the script of meshcat's viewer lies; meshcat itself, which brings a server, is not imported."""
    found = importlib.util.find_spec("meshcat")
    folder = None if found is None or found.origin is None else Path(found.origin).parent / "viewer" / "dist"
    if folder is None or not (folder / "main.min.js").is_file():
        raise MissingExtra("meshcat's viewer is not installed: pip install meshcat")
    return folder
