"""`flexmodal check`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from flexmodal.cli.measured import findings_on
from flexmodal.cli.options import json_option
from flexmodal.cli.printing import print_json, say

if TYPE_CHECKING:
    from flexmodal.errors import Report
    from flexmodal.soundness import Finding


@click.command()
@click.argument("paths", nargs=-1, required=True, metavar="PATH…")
@json_option
def check(paths: tuple[str, ...], as_json: bool) -> None:
    """Say of each URDF, card or campaign whether it is sound; exit 1 if not, 2 if it cannot be found.

    Of a campaign that can be read: whether the test is. Blows and FRFs by themselves, and beside the card of
    the robot that it names.
    """
    from flexmodal.campaign import check_campaign, is_campaign
    from flexmodal.errors import RobotNotFound
    from flexmodal.model.check import check as examine

    reports: list[Report] = []
    findings: list[tuple[Finding, ...]] = []
    missing = False
    for path in paths:
        try:
            is_measured = is_campaign(path)
            report = check_campaign(path) if is_measured else examine(Path(path))
            reports.append(report)
            findings.append(findings_on(path) if is_measured and report.is_sound else ())
        except RobotNotFound as error:
            missing = True
            for fault in error.faults:
                say(f"flexmodal: {fault}", err=True)
    if as_json:
        listed = [
            {
                "path": report.path,
                "sound": report.is_sound and not _harm(found),
                "faults": [vars(fault) for fault in report.faults],
                "warnings": list(report.warnings),
                "findings": [vars(finding) for finding in found],
            }
            for report, found in zip(reports, findings, strict=True)
        ]
        print_json({"checked": listed})
    else:
        for report, found in zip(reports, findings, strict=True):
            for fault in report.faults:
                say(str(fault))
            for warning in report.warnings:
                say(f"warning: {warning}")
            for finding in found:
                say(f"{'harmless' if finding.harmless else 'finding'}: {finding}")
            count, harm = len(report.faults), _harm(found)
            verdict = "sound" if report.is_sound else f"{count} fault{'s' * (count > 1)}"
            say(f"{report.path}: " + (f"{harm} finding{'s' * (harm > 1)}" if harm else verdict))
    every = all(report.is_sound for report in reports) and not any(map(_harm, findings))
    sys.exit(2 if missing else int(not every))


def _harm(found: tuple[Finding, ...]) -> int:
    """Findings that should not stay as they are."""
    return sum(not one.harmless for one in found)
