"""What was not set up as the campaign says: a section of the report."""

from __future__ import annotations

from flexmodal.diagnosis.outcome import Diagnosis
from flexmodal.identification.setting_up import Found
from flexmodal.report import Cell, Column, Parts, Section, Table, Text
from flexmodal.report.words import minus

COLUMNS = (
    Column("what", words=True), Column("moved by"), Column("standard error"), Column("tolerance"),
    Column("outside", words=True),
)  # fmt: skip
_SAYS = (
    "Within the tolerances of the campaign these were moved, since the measurements ask for it; what they do "
    "not ask for stayed as it was recorded. They are no effects, and count in every model alike."
)
_FAR = "Far outside means more than three standard deviations: look at the set-up or at its record."


def set_up_sections(diagnosis: Diagnosis) -> list[Section]:
    """A section with a table, or none where everything stayed as recorded.

    Args:
        diagnosis: what was found.
    """
    if not diagnosis.moved:
        return []
    sure = [one for one in diagnosis.moved if abs(one.value) > one.deviation]
    rest = len(diagnosis.moved) - len(sure)
    table: Parts = [Table(COLUMNS, [_row(one) for one in sure]), Text(_FAR, note=True)] if sure else []
    more = f"{rest} more were" if sure else "One was" if rest == 1 else f"All {rest} were"
    note = Text(f"{more} moved by less than their standard error; they are in diagnosis.json.", note=True)
    return [Section("How it was set up", [_SAYS, *table, *([note] if rest else [])])]


def _row(one: Found) -> list[str | Cell]:
    unit = f" {one.nuisance.unit}" if one.nuisance.unit else ""
    return [
        one.nuisance.says,
        minus(f"{one.value:+.2g}{unit}"),
        f"{one.deviation:.1g}{unit}",
        f"{one.nuisance.deviation:.2g}{unit}",
        "far outside" if one.is_far else "",
    ]
