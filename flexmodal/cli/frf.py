"""`flexmodal frf`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from flexmodal.cli.options import (
    RobotOptions,
    force_option,
    frequencies_of,
    json_option,
    posture_of,
    posture_option,
    refuse_existing,
    robot_options,
    say_motionless,
)
from flexmodal.cli.pairs import pair_options
from flexmodal.cli.printing import print_json, print_table, say

if TYPE_CHECKING:
    from flexmodal.frf import Frf
    from flexmodal.model import Posture, Robot

_ENDINGS = (".csv", ".uff", ".npz", ".png", ".svg", ".html")
_MOST_ROWS = 40


@click.command()
@robot_options
@posture_option
@click.option("--frequencies", required=True, metavar="START:STOP:STEP", help="In Hz; or values with commas.")
@pair_options
@click.option("--out", type=click.Path(path_type=Path), help="A .csv, .uff, .npz, .png, .svg or .html file.")
@force_option
@json_option
def frf(
    robot: RobotOptions,
    posture: str,
    frequencies: str,
    response: tuple[str, ...],
    reference: tuple[str, ...],
    form: str,
    out: Path | None,
    force: bool,
    as_json: bool,
) -> None:
    """Frequency response functions at a posture, between any points and directions."""
    refuse_existing(out, force, _ENDINGS)
    axis = frequencies_of(frequencies)
    arm = robot.load()
    where = posture_of(arm, posture)
    posed = arm.at(where)
    found = posed.frf(axis, response=response or None, reference=reference or None, form=form)
    say_motionless(posed, [*found.response, *found.reference])
    if out is not None:
        _write(found, arm, where, out, force)
        say(f"wrote {out}", err=True)
    if as_json:
        print_json(_json(found, arm, where))
    elif out is None:
        _print(found, arm, where)


def _json(found: Frf, arm: Robot, where: Posture) -> dict[str, Any]:
    """Flat lists for one pair, as cli.md has it; nested by response and reference for several."""
    single = len(found.response) == len(found.reference) == 1
    values = found.value[:, 0, 0] if single else found.value.transpose(1, 2, 0)
    units = [
        [found.unit(row, column) for column in range(len(found.reference))]
        for row in range(len(found.response))
    ]
    return {
        "robot": arm.name,
        "posture": dict(where.values),
        "form": found.form,
        "unit": units[0][0] if single else units,
        "response": str(found.response[0]) if single else [str(d) for d in found.response],
        "reference": str(found.reference[0]) if single else [str(d) for d in found.reference],
        "frequency": found.frequency.tolist(),
        "re": values.real.tolist(),
        "im": values.imag.tolist(),
    }


def _write(found: Frf, arm: Robot, where: Posture, out: Path, force: bool) -> None:
    from flexmodal.campaign import write_frf
    from flexmodal.frf import export, page, plot
    from flexmodal.model.chain import TOOL
    from flexmodal.report import write_figure

    title = f"{arm.name} at {where}"
    ending = out.suffix.lower()
    if ending == ".csv":
        export.write_csv(found, out, overwrite=force)
    elif ending == ".npz":
        export.write_npz(found, out, overwrite=force)
    elif ending == ".uff":
        names = [*arm.points, *(link.name for link in arm.urdf.links)]
        nodes = {name: number for number, name in enumerate(dict.fromkeys(names), start=1)}
        nodes.setdefault(TOOL, nodes[arm.tool])
        posture = list(arm.postures).index(where.name) + 1 if where.name else 1
        write_frf(found, out, nodes, posture=posture, title=title, overwrite=force)
    elif ending == ".html":
        page.write_page({"": found}, out, title=title, overwrite=force)
    else:
        write_figure(plot.draw_frf({"": found}, title=title), out, overwrite=force)


def _print(found: Frf, arm: Robot, where: Posture) -> None:
    import numpy as np

    step = -(-len(found.frequency) // _MOST_ROWS)
    for row, response in enumerate(found.response):
        for column, reference in enumerate(found.reference):
            values = found.value[::step, row, column]
            cells = [
                [f"{f:g}", f"{abs(v):.5g}", f"{np.degrees(np.angle(v)):.1f}"]
                for f, v in zip(found.frequency[::step], values, strict=True)
            ]
            thinned = (
                f" (one line in {step} of {len(found.frequency)}; --out or --json gives all)"
                if step > 1
                else ""
            )
            title = f"{arm.name} at {where}: {found.form} of {response} per {reference}{thinned}"
            columns = ["frequency [Hz]", f"amplitude [{found.unit(row, column)}]", "phase [°]"]
            print_table(title, columns, cells)
