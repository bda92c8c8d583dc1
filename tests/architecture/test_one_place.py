"""One rule in one place: what would be easy to write again, and then drifts apart."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = (ROOT / "flexmodal", ROOT / "viewer" / "flexmodal_viewer")

RULES = {
    "whether a joint slides": (r"""(==|!=|\bin\b)\s*\(?["']prismatic["']""", {"cards/urdf/urdf.py"}),
    "the power of iω of a form": (r"""["']inertance["']:\s*2""", {"frf/form.py"}),
    "raising iω to a power": (r"2j \* np\.pi \* [\w.]+\) \*\* ", {"frf/form.py"}),
    "the suffixes of universal files": (r"""["']\.unv["']""", {"campaign/uff/export.py"}),
    "what numba is asked to compile": (r"\bn?jit\(|@n?jit\b", {"frf/kernels/compiled.py"}),
    "the least coherence of a line": (r"^COHERENT\b.*=", {"campaign/coherence.py"}),
    "whether a line is coherent": (r"[<>]=?\s*COHERENT\b", {"campaign/coherence.py"}),
    "a coherence compared with a number": (r"coheren\w*\s*[<>]=?\s*0?\.\d", set()),
}


def places(pattern: str) -> set[str]:
    """Modules that match, within their package."""
    return {
        path.relative_to(package).as_posix()
        for package in PACKAGES
        for path in package.rglob("*.py")
        if re.search(pattern, path.read_text(encoding="utf-8"), re.MULTILINE)
    }


@pytest.mark.parametrize("rule", RULES)
def test_a_rule_stands_in_one_place(rule: str) -> None:
    pattern, there = RULES[rule]
    assert places(pattern) == there


@pytest.mark.parametrize(
    ("rule", "text"),
    [
        ("whether a joint slides", 'if joint.type == "prismatic":'),
        ("the power of iω of a form", '{"receptance": 0, "mobility": 1, "inertance": 2}'),
        ("raising iω to a power", "value * (2j * np.pi * axis) ** (power - 1)"),
        ("the suffixes of universal files", 'if path.suffix in (".uff", ".unv"):'),
        ("the least coherence of a line", "COHERENT = 0.8"),
        ("what numba is asked to compile", "@njit(cache=True)"),
        ("whether a line is coherent", "kept = coherence[row] >= COHERENT"),
        ("a coherence compared with a number", "coherence >= 0.8"),
    ],
)
def test_a_second_place_would_be_noticed(rule: str, text: str) -> None:
    assert re.search(RULES[rule][0], text, re.MULTILINE)
