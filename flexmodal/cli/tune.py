"""`flexmodal tune`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from flexmodal.cli.options import (
    RobotOptions,
    band_of,
    json_option,
    posture_of,
    posture_option,
    robot_options,
)
from flexmodal.cli.printing import print_json, print_table, say
from flexmodal.cli.sources import no_source

if TYPE_CHECKING:
    from flexmodal.optimisation import Tuning


@click.command()
@robot_options
@no_source
@posture_option
@click.option("--band", required=True, metavar="LOW:HIGH", help="Where to look [Hz].")
@click.option("--response", metavar="POINT:AXIS", help="Such as tool:+z (the default).")
@click.option("--reference", metavar="POINT:AXIS", help="Of the force; as --response if none.")
@json_option
def tune(
    robot: RobotOptions,
    posture: str,
    band: str,
    response: str | None,
    reference: str | None,
    as_json: bool,
) -> None:
    """The operating frequency of a band at which the posture vibrates least, and every minimum there is."""
    from flexmodal.optimisation import tune as search

    limits = band_of(band)
    arm = robot.load()
    where = posture_of(arm, posture)
    found = search(arm.at(where), limits, response=response, reference=reference)
    if as_json:
        print_json(_json(found))
        return
    unit = arm.frf(where, [limits[1]], response=found.response, reference=found.reference).unit()
    _print(found, f"{arm.name} at {where}: |receptance| of {found.response} per {found.reference}", unit)


def _json(found: Tuning) -> dict[str, Any]:
    return {
        "frequency": found.best.frequency,
        "receptance": found.best.receptance,
        "minima": [{"frequency": one.frequency, "receptance": one.receptance} for one in found.minima],
    }


def _print(found: Tuning, title: str, unit: str) -> None:
    listed = [("lower end of the band", found.ends[0])]
    inside = [("minimum", one) for one in found.minima] + [("maximum", one) for one in found.maxima]
    listed += sorted(inside, key=lambda item: item[1].frequency)
    listed.append(("upper end of the band", found.ends[1]))
    rows = [
        [name, f"{one.frequency:.6g}", f"{one.receptance:.5g}", "best" if one is found.best else ""]
        for name, one in listed
    ]
    print_table(title, ["", "frequency [Hz]", f"[{unit}]", ""], rows)
    say(f"best at {found.best.frequency:.6g} Hz: {found.verdict}")
