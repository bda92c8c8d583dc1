"""A column map drafted from a table: what each column seems to be, to be looked at before it is believed."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from flexmodal.campaign.description.tested import FORCE_TOO, OUTPUT_ONLY
from flexmodal.campaign.tables.arrays import SUFFIXES
from flexmodal.campaign.tables.sniff import Sniffed, sniff
from flexmodal.errors import Fault, InvalidCampaign

GRAVITY = 9.80665
_SCALES = {"g": GRAVITY, "mm/s²": 1e-3, "mm/s^2": 1e-3, "mm/s": 1e-3, "mm": 1e-3, "µm": 1e-6}
"""Of responses over time, to SI units."""
_KINDS: tuple[tuple[str, str], ...] = (
    ("coherence", r"coh|kohä|γ|gamma"),
    ("phase", r"phase|phi\b|φ|\barg|angle|winkel"),
    ("im", r"imag|\bim\b|_im\b|\bim[ _\[(]"),
    ("re", r"real|\bre\b|_re\b|\bre[ _\[(]"),
    ("frequency", r"freq|\bf\b|^f[ _\[(]|\bhz\b|abscissa"),
    ("time", r"time|zeit|^t\b|\bt \[|^t[ _\[(]"),
    ("force", r"force|kraft|hammer|impact|\bin\b|input"),
    ("magnitude", r"magn|ampl|\babs|mod\b|modulus|\|h\||\bdb\b"),
    ("response", r"acc|beschl|resp|sensor|velo|disp|output|\bout\b|\ba\d*\b|ch\s*\d"),
)
"""What a column is, by its header: the first that fits."""


@dataclass
class _Frf:
    """One FRF as it is put together from columns."""

    keys: dict[str, str] = field(default_factory=dict)
    unit: str = ""
    notes: list[str] = field(default_factory=list)


def draft_map(table: str | os.PathLike[str], *, beside: str | os.PathLike[str] | None = None) -> str:
    """The text of a column map for a table; what is guessed says so.

    Args:
        table: text, .xlsx, .mat, HDF5 or TDMS.
        beside: where the map will stand, to which the address of the table is relative; the table's folder if
            None.

    Raises:
        InvalidCampaign: no table can be found in the file, or no frequency and no time in it.
        MissingExtra: a kind of file whose reader is not installed.
    """
    file = Path(os.path.abspath(table))
    seen = sniff(file)
    in_groups = file.suffix.lower() in SUFFIXES  # "hammer/acceleration" is no force
    names = [name.rpartition("/")[2] if in_groups else name for name in seen.headers]
    kinds = [_kind(name, unit) for name, unit in zip(names, seen.units, strict=True)]
    axes = [k for k, kind in enumerate(kinds) if kind in ("frequency", "time")]
    if not axes:
        found = f"columns {', '.join(map(repr, seen.headers[:12]))}"
        allowed = "one whose header says frequency or time"
        raise InvalidCampaign(Fault(str(file), "", found, allowed))
    home = file.parent if beside is None else Path(os.path.abspath(beside)).parent
    lines = _head(os.path.relpath(file, home), file, seen, seen.headers[axes[0]])
    if kinds[axes[0]] == "time":
        lines += _blow(seen, kinds, file)
    else:
        found_frfs = _frfs(seen, kinds)
        if not found_frfs:
            found = f"columns {', '.join(map(repr, seen.headers[:12]))}"
            allowed = "real and imaginary part, or magnitude and phase; a magnitude alone lacks the phase"
            raise InvalidCampaign(Fault(str(file), "", found, allowed))
        for number, one in enumerate(found_frfs, start=1):
            lines += _frf(one, number)
    return "\n".join(lines) + "\n"


def _kind(name: str, unit: str) -> str:
    text = name.lower()
    for kind, pattern in _KINDS:
        if re.search(pattern, text):
            return kind
    by_unit = {"hz": "frequency", "s": "time", "n": "force", "deg": "phase", "°": "phase", "db": "magnitude"}
    return by_unit.get(unit.lower(), "unknown")


def _head(address: str, file: Path, seen: Sniffed, abscissa: str) -> list[str]:
    lines = [
        "# Drafted from the table; look at every line, above all at places, units and senses.",
        "format = 1",
        'campaign = "campaign.toml"   # what was tested: flexmodal campaign new writes one to fill in',
        f"table = {_text(address)}",
    ]
    if file.suffix.lower() not in (*SUFFIXES, ".xlsx"):
        lines += [f"delimiter = {_text(seen.delimiter)}", f"decimal = {_text(seen.decimal)}"]
    if seen.sheet is not None:
        lines.append(f"sheet = {_text(seen.sheet)}")
    if seen.skip:
        lines.append(f"skip = {seen.skip}")
    if seen.units_rows:
        lines.append(f"units_rows = {seen.units_rows}")
    if seen.transposed:
        lines.append("transposed = true")
    return [*lines, f"abscissa = {_text(abscissa)}"]


def _frfs(seen: Sniffed, kinds: Sequence[str]) -> list[_Frf]:
    """Columns put together in their order: a part that is there already begins the next FRF."""
    found: list[_Frf] = []
    for name, unit, called in zip(seen.headers, seen.units, kinds, strict=True):
        if called not in ("re", "im", "magnitude", "phase", "coherence", "response", "complex"):
            continue
        kind = "value" if called in ("response", "complex") else called
        if not found or kind in found[-1].keys or (kind == "value" and found[-1].keys):
            found.append(_Frf())
        found[-1].keys[kind] = name
        if kind in ("re", "magnitude", "value") and unit:
            found[-1].unit = unit
        if kind == "magnitude" and "db" in f"{unit} {name}".lower():
            found[-1].keys["decibel"] = "true"
        if kind == "phase" and "rad" in f"{unit} {name}".lower():
            found[-1].keys["phase_unit"] = "radians"
    pairs = ({"re", "im"}, {"magnitude", "phase"}, {"value"})
    return [one for one in found if any(pair <= set(one.keys) for pair in pairs)]


def _frf(one: _Frf, number: int) -> list[str]:
    form, scale, sure = form_of(one.unit)
    lines = ["", "[[frf]]", "posture = 1        # guessed", "trial = 1          # guessed"]
    lines += [f"response = [{number}, 3]  # guessed: point, ±1 ±2 ±3 for ±x ±y ±z"]
    lines += ["reference = [1, 3] # guessed"]
    lines.append(f'form = "{form}"' + ("" if sure else "   # guessed: the table does not say"))
    if scale != 1.0:
        lines.append(f"scale = {scale:g}   # from {one.unit}")
    for key in ("value", "re", "im", "magnitude", "phase", "coherence"):
        if key in one.keys:
            lines.append(f"{key} = {_text(one.keys[key])}")
    if "decibel" in one.keys:
        lines.append("decibel = true     # 0 dB is 1 in SI units, or in those that scale turns into them")
    if "phase_unit" in one.keys:
        lines.append('phase_unit = "radians"')
    return lines


def _blow(seen: Sniffed, kinds: Sequence[str], file: Path) -> list[str]:
    force = [k for k, kind in enumerate(kinds) if kind == "force"]
    others = [k for k, kind in enumerate(kinds) if kind in ("response", "unknown", "magnitude")]
    if others and not force:
        found = f"{OUTPUT_ONLY} (columns {', '.join(map(repr, seen.headers[:12]))})"
        raise InvalidCampaign(Fault(str(file), "", found, FORCE_TOO))
    if not force or not others:
        found = f"columns {', '.join(map(repr, seen.headers[:12]))}"
        raise InvalidCampaign(Fault(str(file), "", found, "a force and a response over time"))
    lines = ["", "[[blow]]", "posture = 1        # guessed", "trial = 1          # guessed"]
    lines += ["reference = [1, 3] # guessed: point, ±1 ±2 ±3 for ±x ±y ±z"]
    unit = seen.units[others[0]].lower()
    quantity = "displacement" if unit in ("m", "mm", "µm") else "velocity" if unit in ("m/s", "mm/s") else ""
    lines.append(f'quantity = "{quantity or "acceleration"}"' + ("" if quantity or unit else "   # guessed"))
    lines.append(f"force = {_text(seen.headers[force[0]])}")
    lines.append("# length = 2.0     # [s] of each blow, where this record holds several")
    for number, place in enumerate(others, start=1):
        lines += ["[[blow.channel]]", f"response = [{number}, 3]  # guessed"]
        lines.append(f"column = {_text(seen.headers[place])}")
        scale = _SCALES.get(seen.units[place].lower())
        if scale is not None:
            lines.append(f"scale = {scale:g}   # from {seen.units[place]}")
    return lines


def form_of(unit: str) -> tuple[str, float, bool]:
    """Form, factor to SI units, and whether the unit says so.

    Args:
        unit: such as "(m/s²)/N", "g/N", "mm/N"; empty for none.
    """
    text = unit.lower().replace(" ", "").replace("^2", "²").replace("s2", "s²").strip("()")
    text = text.replace("db", "").replace("re", "").replace("(", "").replace(")", "").lstrip(",:")
    forms = {
        "m/s²/n": ("inertance", 1.0), "m/s²n": ("inertance", 1.0), "m/ns²": ("inertance", 1.0),
        "g/n": ("inertance", GRAVITY), "mm/s²/n": ("inertance", 1e-3), "1/kg": ("inertance", 1.0),
        "m/s/n": ("mobility", 1.0), "mm/s/n": ("mobility", 1e-3), "m/ns": ("mobility", 1.0),
        "m/n": ("receptance", 1.0), "mm/n": ("receptance", 1e-3), "µm/n": ("receptance", 1e-6),
        "um/n": ("receptance", 1e-6),
    }  # fmt: skip
    form, scale = forms.get(text, ("inertance", 1.0))
    return form, scale, text in forms


def _text(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)
