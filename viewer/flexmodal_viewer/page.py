"""A scene as one HTML file that needs nothing else, not even a network."""

from __future__ import annotations

import importlib.util
import json
import re
from collections.abc import Mapping
from functools import cache
from html import escape
from pathlib import Path
from typing import Any

from flexmodal.errors import MissingExtra
from flexmodal.files import whole_file
from flexmodal_viewer.assets import asset
from flexmodal_viewer.caption import caption_html
from flexmodal_viewer.commands import payload
from flexmodal_viewer.scene import Scene

SCRIPTS = (
    *("complex", "symmetric", "chain", "pencil", "modes", "robot", "hold"),
    *(
        "units",
        "colours",
        "chart",
        "swing",
        "picture",
        "keep",
        "panel",
        "selfmotion",
        "objective",
        "descent",
        "workspace",
        "cloud",
        "map",
        "python",
        "live",
        "sticks",
        "film",
        "diagnosis",
        "wiring",
    ),
)
"""What a live page runs, in the order in which each needs those before it."""


def write_page(scene: Scene, path: str | Path, *, overwrite: bool = False) -> Path:
    """Write a scene as a page, whole or not at all.

    Args:
        scene: what is drawn.
        path: of the new file.
        overwrite: replace a file that stands there.

    Raises:
        OutputExists: the file exists and `overwrite` is false, or its folder does not exist.
    """
    target = Path(path)
    with whole_file(target, overwrite=overwrite) as scratch:
        scratch.write_text(page_html(scene), encoding="utf-8")
    return target


def page_html(scene: Scene, *, served: bool = False) -> str:
    """The page as text; of one scene always the same.

    Args:
        scene: what it shows.
        served: whether it may talk to the server that it comes from; otherwise it may talk to nobody.
    """
    viewer = _meshcat()
    parts = {
        "connect": "connect-src 'self'; " if served else "",
        "title": escape(scene.caption.title),
        "css": asset("page.css") + ("" if scene.live is None else asset("live/live.css")),
        "caption": caption_html(scene),
        "scene": _json(payload(scene)),
        "licences": (viewer / "main.min.js.LICENSE.txt").read_text(encoding="utf-8").replace("*/", ""),
        "meshcat": (viewer / "main.min.js").read_text(encoding="utf-8"),
        "js": asset("page.js"),
        "curve": "" if scene.live is None else asset("live/curve.html"),
        "live": "" if scene.live is None else _live(scene.live),
    }
    # One pass: nothing that is put in is looked at again.
    return re.sub(r"\{\{(\w+)\}\}", lambda match: parts[match[1]], asset("page.html"))


def _json(value: object) -> str:
    """JSON that cannot end the script element it stands in."""
    text = json.dumps(value, separators=(",", ":"), ensure_ascii=True, allow_nan=False)
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _live(numbers: Mapping[str, Any]) -> str:
    """The robot in numbers, and the scripts that put it in postures; one scope for all of them."""
    scripts = "".join(asset(f"live/{name}.js") for name in SCRIPTS)
    return (
        f'<script type="application/json" id="robot">{_json(numbers)}</script>\n'
        f"<script>(function () {{\n{scripts}}})();</script>"
    )


@cache
def _meshcat() -> Path:
    """Where the script of meshcat's viewer lies; meshcat itself, which brings a server, is not imported."""
    found = importlib.util.find_spec("meshcat")
    folder = None if found is None or found.origin is None else Path(found.origin).parent / "viewer" / "dist"
    if folder is None or not (folder / "main.min.js").is_file():
        raise MissingExtra("meshcat's viewer is not installed: pip install meshcat")
    return folder
