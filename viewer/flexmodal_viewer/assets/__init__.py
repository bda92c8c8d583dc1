"""The texts that pages are made of: markup, style sheets, scripts."""

from functools import cache
from importlib.resources import files


@cache
def asset(name: str) -> str:
    """One of them, such as "page.css" or "live/chain.js"."""
    return (files("flexmodal_viewer") / "assets" / name).read_text(encoding="utf-8")
