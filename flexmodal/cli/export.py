"""`flexmodal export`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from flexmodal.cli.options import (
    SOURCE,
    RobotOptions,
    force_option,
    posture_of,
    posture_option,
    refuse_existing,
    robot_options,
)
from flexmodal.cli.pairs import pair_options
from flexmodal.cli.printing import say
from flexmodal.errors import Fault, InvalidRequest

if TYPE_CHECKING:
    from flexmodal.model import Posture, Robot

_ENDINGS = {
    "mujoco": (".xml",),
    "state-space": (".npz", ".mat"),
    "joint-state": (".yaml", ".yml"),
    "krl": (".src",),
    "rapid": (".mod",),
}


@click.command()
@robot_options
@posture_option
@click.option("--as", "kind", type=click.Choice(list(_ENDINGS)), required=True, help="What to write.")
@pair_options
@click.option("--out", required=True, type=click.Path(path_type=Path), help="The file to write.")
@force_option
def export(
    robot: RobotOptions,
    posture: str,
    kind: str,
    response: tuple[str, ...],
    reference: tuple[str, ...],
    form: str,
    out: Path,
    force: bool,
) -> None:
    """Write a posture for other programs: MuJoCo, state space, ROS, KUKA, ABB.

    \b
    mujoco       an .xml model, springs at rest in the posture
    state-space  A, B, C, D and names in an .npz or .mat file, for scipy,
                 python-control, Matlab; --response, --reference and --form
                 are of this kind alone
    joint-state  a ROS sensor_msgs/JointState as .yaml
    krl, rapid   a .src or .mod program that goes there; angles are the URDF's
    """  # noqa: D301 - click keeps the lines after its mark
    refuse_existing(out, force, _ENDINGS[kind])
    if kind != "state-space":
        _refuse_pairs(kind, response=response, reference=reference)
    arm = robot.load()
    where = posture_of(arm, posture)
    if kind == "mujoco":
        from flexmodal.model.mujoco_model import write_mujoco

        write_mujoco(arm, where, out, overwrite=force)
    elif kind == "state-space":
        _write_state_space(arm, where, out, force, response=response, reference=reference, form=form)
    else:
        _write_text(arm, where, kind, out, force)
    say(f"wrote {out}", err=True)


def _refuse_pairs(kind: str, **given: tuple[str, ...]) -> None:
    """Only a state space is between points and directions."""
    faults = [
        Fault(SOURCE, f"--{name}", f"given with --as {kind}", "it with --as state-space alone")
        for name, values in given.items()
        if values
    ]
    if faults:
        raise InvalidRequest(faults)


def _write_text(arm: Robot, where: Posture, kind: str, out: Path, force: bool) -> None:
    from flexmodal.cards.write.program import joint_state, krl, rapid
    from flexmodal.files import whole_file

    name = f"{arm.name}_{where.name}" if where.name else arm.name
    if kind == "joint-state":
        text = joint_state(where.values)
    else:
        text = (krl if kind == "krl" else rapid)(where.values, arm.commanded, name=name)
    with whole_file(out, overwrite=force) as scratch:
        scratch.write_text(text, encoding="utf-8")


def _write_state_space(
    arm: Robot,
    where: Posture,
    out: Path,
    force: bool,
    *,
    response: tuple[str, ...],
    reference: tuple[str, ...],
    form: str,
) -> None:
    import numpy as np

    from flexmodal.files import whole_file

    model = arm.at(where).to_ss(response=response or None, reference=reference or None, form=form)
    content = {name: getattr(model, name) for name in "ABCD"}
    content |= {"inputs": np.array(model.inputs), "outputs": np.array(model.outputs)}
    with whole_file(out, overwrite=force) as scratch, scratch.open("wb") as file:
        if out.suffix.lower() == ".npz":
            np.savez(file, **content)
        else:
            from scipy.io import savemat

            savemat(file, content)
