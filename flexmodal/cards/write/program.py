"""A posture as other programs write it: a ROS joint state, a KUKA and an ABB program.

The angles are those of the URDF. Where a controller counts from another zero, or the other way round, its own
zeros and senses have to be put in; the texts say so.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from flexmodal.cards.urdf.urdf import UrdfJoint
from flexmodal.errors import Fault, InvalidRequest
from flexmodal.text.words import safe_name

_AXES, _EXTERNAL = 6, 6
_UNUSED = "9E+09"
"""What RAPID takes for an external axis that is not there."""


def joint_state(values: Mapping[str, float]) -> str:
    """A sensor_msgs/msg/JointState as YAML, for `ros2 topic pub`.

    Args:
        values: by joint [rad, m].
    """
    names = "".join(f"- {_quoted(name)}\n" for name in values)
    positions = "".join(f"- {float(value)!r}\n" for value in values.values())
    header = "header:\n  stamp:\n    sec: 0\n    nanosec: 0\n  frame_id: ''\n"
    return f"{header}name:\n{names}position:\n{positions}velocity: []\neffort: []\n"


def krl(values: Mapping[str, float], joints: Mapping[str, UrdfJoint], *, name: str) -> str:
    """A KUKA program that goes to the posture point to point.

    Args:
        values: by joint [rad, m], in the order of the axes: A1 to A6, then E1 to E6.
        joints: those joints.
        name: of the program.

    Raises:
        InvalidRequest: more axes than KRL has.
    """
    numbers = _degrees(values, joints)
    axes = [f"A{k}" for k in range(1, _AXES + 1)] + [f"E{k}" for k in range(1, _EXTERNAL + 1)]
    target = ", ".join(f"{axis} {value:.6f}" for axis, value in zip(axes, numbers, strict=False))
    program = _identifier(name, 24)
    return (
        f"&ACCESS RVP\nDEF {program}( )\n"
        "; URDF angles: check zero and sense of each axis of your controller first\n"
        f"{_comments(values, ';')}"
        "BAS(#INITMOV, 0)\n"
        f"PTP {{{target}}}\nEND\n"
    )


def rapid(values: Mapping[str, float], joints: Mapping[str, UrdfJoint], *, name: str) -> str:
    """An ABB module that goes to the posture at low speed.

    Args:
        values: by joint [rad, m], in the order of the axes; those after the sixth are external.
        joints: those joints.
        name: of the module.

    Raises:
        InvalidRequest: more axes than RAPID has.
    """
    numbers = [f"{value:.6f}" for value in _degrees(values, joints)]
    robot = (numbers + ["0"] * _AXES)[:_AXES]
    outside = (numbers[_AXES:] + [_UNUSED] * _EXTERNAL)[:_EXTERNAL]
    module = _identifier(name, 28)
    target = f"[[{', '.join(robot)}], [{', '.join(outside)}]]"
    return (
        f"MODULE {module}\n"
        "    ! URDF angles: check zero and sense of each axis of your controller first\n"
        f"{_comments(values, '    !')}"
        f"    CONST jointtarget posture := {target};\n"
        "    PROC main()\n        MoveAbsJ posture, v100, fine, tool0;\n    ENDPROC\nENDMODULE\n"
    )


def _degrees(values: Mapping[str, float], joints: Mapping[str, UrdfJoint]) -> list[float]:
    """In degrees, or millimetres of a joint that slides: the units of both languages."""
    if len(values) > _AXES + _EXTERNAL:
        allowed = f"at most {_AXES + _EXTERNAL}"
        raise InvalidRequest(Fault("call", "posture", f"{len(values)} axes", allowed))
    return [
        1e3 * value if joints[name].is_prismatic else math.degrees(value) for name, value in values.items()
    ]


def _comments(values: Mapping[str, float], sign: str) -> str:
    listed = ", ".join(safe_name(name) for name in values)
    return f"{sign} joints in this order: {listed}\n"


def _identifier(name: str, most: int) -> str:
    """A name that both languages take: letters, digits and _, a letter first."""
    text = safe_name(name).replace("-", "_")
    text = text if text[:1].isalpha() else f"p_{text}"
    return text[:most]


def _quoted(text: str) -> str:
    return "'" + text.replace("'", "''") + "'"
