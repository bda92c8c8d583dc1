"""`flexmodal check`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from flexmodal.cli.options import json_option
from flexmodal.cli.printing import print_json, say

if TYPE_CHECKING:
    from flexmodal.errors import Report


@click.command()
@click.argument("paths", nargs=-1, required=True, metavar="PATH…")
@json_option
def check(paths: tuple[str, ...], as_json: bool) -> None:
    """Say of each URDF, card or campaign whether it is sound; exit 1 if not, 2 if it cannot be found."""
    from flexmodal.campaign import check_campaign, is_campaign
    from flexmodal.errors import RobotNotFound
    from flexmodal.model.check import check as examine

    reports: list[Report] = []
    missing = False
    for path in paths:
        try:
            is_measured = is_campaign(path)
            reports.append(check_campaign(path) if is_measured else examine(Path(path)))
        except RobotNotFound as error:
            missing = True
            for fault in error.faults:
                say(f"flexmodal: {fault}", err=True)
    if as_json:
        listed = [
            {
                "path": report.path,
                "sound": report.is_sound,
                "faults": [vars(fault) for fault in report.faults],
                "warnings": list(report.warnings),
            }
            for report in reports
        ]
        print_json({"checked": listed})
    else:
        for report in reports:
            for fault in report.faults:
                say(str(fault))
            for warning in report.warnings:
                say(f"warning: {warning}")
            count = len(report.faults)
            say(f"{report.path}: " + ("sound" if report.is_sound else f"{count} fault{'s' * (count > 1)}"))
    sys.exit(2 if missing else int(not all(report.is_sound for report in reports)))
