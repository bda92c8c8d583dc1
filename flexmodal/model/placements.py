"""Where every link is, with the joints anywhere: a posture, plus what the flexible joints give way."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
from jaxtyping import Float

from flexmodal.errors import Fault, InvalidPosture
from flexmodal.model.build import pinocchio
from flexmodal.model.chain import FlexibleChain
from flexmodal.text.words import strange


def link_placements(
    robot: FlexibleChain, values: Mapping[str, float]
) -> Mapping[str, Float[np.ndarray, "4 4"]]:
    """Place every link in the world, the frame of the root link.

    Args:
        robot: whose links.
        values: joint values [rad, m] of any moving joints, pseudo-joints included; a joint left out is 0.
            Limits are not looked at: a deflection may be drawn much larger than it is.

    Returns:
        Homogeneous matrix by link name.

    Raises:
        InvalidPosture: a joint that does not exist or does not move, or a value that is no finite number.
    """
    faults = []
    for joint, value in values.items():
        if joint not in robot.moving:
            found = f"unknown joint {strange(joint, robot.moving)}"
            faults.append(Fault("call", "values", found, ", ".join(robot.moving)))
        elif not math.isfinite(value):
            faults.append(Fault("call", f"values: {joint}", f"{value!r}", "a finite number [rad, m]"))
    if faults:
        raise InvalidPosture(faults)
    pin = pinocchio()
    model = robot.pinocchio
    data = model.createData()
    turned = np.array([float(values.get(name, 0.0)) for name in robot.moving])
    pin.framesForwardKinematics(model, data, pin.integrate(model, pin.neutral(model), turned))
    return MappingProxyType(
        {
            frame.name: data.oMf[index].homogeneous.copy()
            for index, frame in enumerate(model.frames)
            if frame.type == pin.FrameType.BODY
        }
    )
