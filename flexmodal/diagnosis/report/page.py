"""A diagnosis as one self-contained HTML page: no script, no network, every name escaped."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from flexmodal.diagnosis.outcome import Diagnosis
from flexmodal.diagnosis.report import frf_sections, modal_sections
from flexmodal.diagnosis.report.set_up import set_up_sections
from flexmodal.diagnosis.report.tables import next_task, parameters
from flexmodal.diagnosis.report.words import not_testable, state
from flexmodal.report import Facts, Items, Parts, Section, Verdict, page_text, write_page

_CATALOGUE = (
    "A place or an effect that the catalogue lacks cannot be named; a disagreement of such a kind is called "
    "unknown."
)
_ABSENT = "What could not be tested may be there all the same."


def write_report(
    diagnosis: Diagnosis, path: Path, *, notes: Sequence[str] = (), overwrite: bool = False
) -> None:
    """Write the page.

    Args:
        diagnosis: what `diagnose` found.
        path: a new `.html` file.
        notes: sentences about what the files of the improved robot do not hold.
        overwrite: replace an existing file.

    Raises:
        OutputExists: the file exists.
    """
    write_page(path, report_text(diagnosis, notes), overwrite=overwrite)


def report_text(diagnosis: Diagnosis, notes: Sequence[str] = ()) -> str:
    """The page as text: sections of the evidence that decided, and those that every diagnosis has.

    Args:
        diagnosis: what was found.
        notes: sentences about what the files of the improved robot do not hold.
    """
    found = diagnosis.modal
    if found is None:
        own = frf_sections.frf_sections(diagnosis)
        head, says = frf_sections.frf_headline(diagnosis), frf_sections.frf_paragraphs(diagnosis)
        figures, note = frf_sections.frf_figures(diagnosis), frf_sections.frf_note(diagnosis)
    else:
        own = modal_sections.modal_sections(diagnosis, found)
        head, says = (
            modal_sections.modal_headline(diagnosis, found),
            modal_sections.modal_paragraphs(diagnosis, found),
        )
        figures, note = modal_sections.modal_figures(diagnosis), modal_sections.modal_note(diagnosis)
    sections = [
        *own,
        Section("Parameters", parameters(diagnosis)),
        *set_up_sections(diagnosis),
        Section("What to measure next", _next(diagnosis)),
        Section("What this does not say", [Items(_not_said(diagnosis, notes))]),
        Section("Where it comes from", [Facts(diagnosis.provenance)]),
    ]
    alone = "" if found is None else ", from modes alone,"
    title = f"Diagnosis{alone} of “{diagnosis.campaign}” with the robot {diagnosis.robot}"
    return page_text(title, [Verdict(state(diagnosis), head, says, figures), note], sections)


def _next(diagnosis: Diagnosis) -> Parts:
    found, measurement = diagnosis.modal, diagnosis.next_measurement
    if measurement is not None and found is None:
        return [next_task(diagnosis, measurement, frf_sections.WHY)]
    if measurement is not None:
        return [next_task(diagnosis, measurement, modal_sections.WHY), modal_sections.SHAPES_TOO]
    if found is None and state(diagnosis) == "open":
        return [frf_sections.NO_PAIR]
    if found is not None and found.tied:
        return [modal_sections.NO_PAIR]
    return ["No second explanation is left that another measurement would have to rule out."]


def _not_said(diagnosis: Diagnosis, notes: Sequence[str]) -> list[str]:
    own = "Left out: " if diagnosis.modal is None else ""
    return [
        *not_testable(diagnosis),
        *(f"{own}{one}." for one in diagnosis.left_out),
        *diagnosis.warnings,
        *(f"In the improved robot: {note}." for note in notes),
        *([_CATALOGUE] if diagnosis.modal is None else [_ABSENT, modal_sections.SIZES]),
    ]
