"""`flexmodal modes`."""

from __future__ import annotations

import click

from flexmodal.cli.options import RobotOptions, json_option, posture_of, posture_option, robot_options
from flexmodal.cli.printing import print_json, print_table, say


@click.command()
@robot_options
@posture_option
@json_option
@click.option("--show", is_flag=True, help="Animate the mode shapes in the browser.")
def modes(
    robot: RobotOptions,
    posture: str,
    as_json: bool,
    show: bool,
) -> None:
    """Natural frequencies, damping ratios, poles and shapes at a posture."""
    arm = robot.load()
    where = posture_of(arm, posture)
    found = arm.modes(where)
    if found.is_defective:
        say("note: critically damped poles; their shapes are not modes of a full set", err=True)
    if as_json:
        listed = [
            {
                "frequency": float(found.frequency[mode]),
                "damping_ratio": float(found.damping_ratio[mode]),
                "pole": [float(found.pole[mode].real), float(found.pole[mode].imag)],
                "overdamped": bool(found.overdamped[mode]),
                "shape": {
                    joint: [float(value.real), float(value.imag)]
                    for joint, value in zip(found.coordinates, found.shape[:, mode], strict=True)
                },
            }
            for mode in range(len(found.pole))
        ]
        print_json({"modes": listed})
    else:
        rows = []
        for mode, pole in enumerate(found.pole):
            shape = found.shape[:, mode]
            shape = shape / shape[abs(shape).argmax()]
            rows.append(
                [
                    str(mode + 1),
                    f"{found.frequency[mode]:.4g}",
                    "overdamped" if found.overdamped[mode] else f"{found.damping_ratio[mode]:.4f}",
                    f"{pole.real:.4g}" + ("" if found.overdamped[mode] else f" ± {pole.imag:.4g}i"),
                    *(f"{value.real:+.2f}" for value in shape),
                ]
            )
        columns = ["mode", "frequency [Hz]", "damping ratio", "pole [rad/s]", *found.coordinates]
        print_table(f"{arm.name} at {where}", columns, rows)
    if show:
        from flexmodal.cli.viewing import announce, viewer

        viewer("show_robot")(arm, where, modes=True, announce=announce)
