"""URDFs written in the tests, number by number."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path


def body(
    name: str,
    mass: float = 0.0,
    com: Sequence[float] = (0, 0, 0),
    inertia: Sequence[float] = (0, 0, 0, 0, 0, 0),
    rpy: Sequence[float] = (0, 0, 0),
) -> str:
    """A link; `inertia` is xx, yy, zz, xy, xz, yz about the mass centre. Without mass, no <inertial>."""
    if not mass:
        return f'<link name="{name}"/>'
    keys = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    moments = " ".join(f'{key}="{value!r}"' for key, value in zip(keys, inertia, strict=True))
    return (
        f'<link name="{name}"><inertial><origin xyz="{_three(com)}" rpy="{_three(rpy)}"/>'
        f'<mass value="{mass!r}"/><inertia {moments}/></inertial></link>'
    )


def joint(
    name: str,
    kind: str,
    parent: str,
    child: str,
    xyz: Sequence[float] = (0, 0, 0),
    axis: Sequence[float] = (0, -1, 0),
    rpy: Sequence[float] = (0, 0, 0),
    limits: tuple[float, float] = (-3.2, 3.2),
) -> str:
    limit = f'<limit lower="{limits[0]!r}" upper="{limits[1]!r}" effort="1" velocity="1"/>'
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{_three(xyz)}" rpy="{_three(rpy)}"/>'
        + ("" if kind == "fixed" else f'<axis xyz="{_three(axis)}"/>')
        + (limit if kind in ("revolute", "prismatic") else "")
        + "</joint>"
    )


def _three(numbers: Sequence[float]) -> str:
    return " ".join(repr(float(number)) for number in numbers)


def save(path: Path, *parts: str) -> Path:
    """Write a robot of these parts; the links base and, without mass, tool are there already."""
    text = "\n".join(['<robot name="written">', body("base"), body("tool"), *parts, "</robot>"])
    path.write_text(text, encoding="utf-8")
    return path


def planar(
    path: Path,
    lengths: Sequence[float],
    masses: Sequence[float],
    inertias: Sequence[float],
    coms: Sequence[float],
    limits: Sequence[tuple[float, float]] | None = None,
    kind: str = "revolute",
) -> Path:
    """A chain in the x-z plane that lies along +x at zero; positive angles lift it towards +z.

    Links are a1, a2, … with joints q1, q2, …; the tool is at the end of the last one.
    """
    parts, parent, reach = [], "base", 0.0
    ranges = limits or [(-6.3, 6.3)] * len(lengths)
    for number, length in enumerate(lengths):
        name, iyy = f"a{number + 1}", inertias[number]
        parts.append(body(name, masses[number], (coms[number], 0, 0), (iyy, iyy, iyy, 0, 0, 0)))
        parts.append(joint(f"q{number + 1}", kind, parent, name, (reach, 0, 0), limits=ranges[number]))
        parent, reach = name, length
    return save(path, *parts, joint("mount", "fixed", parent, "tool", (reach, 0, 0)))


def mixed(path: Path) -> Path:
    """Prismatic, continuous and revolute joints with skew axes, rotated frames, and fixed links with mass.

    base –fixed– plinth –slide (prismatic)– carriage –turn (continuous)– arm –fixed– pack (mass, off the arm)
                                                                   arm –lift (revolute)– hand –fixed– tool
                                                          carriage –wag (revolute)– tail, a second branch
    """
    return save(
        path,
        body("plinth", 3.0, (0.1, 0, 0), (0.3, 0.4, 0.35, 0, 0, 0)),
        body("carriage", 7.0, (0.05, -0.02, 0.1), (0.2, 0.25, 0.3, 0.02, -0.03, 0.01), (0.3, -0.2, 0.5)),
        body("arm", 4.0, (0.3, 0.01, -0.04), (0.05, 0.5, 0.48, 0.01, 0.02, -0.015)),
        body("pack", 1.5, (0.02, 0.03, 0.01), (0.02, 0.015, 0.012, 0.001, 0.002, 0.0005), (1.1, 0.4, -0.7)),
        body("hand", 2.0, (0.1, 0.05, 0.02), (0.01, 0.03, 0.028, 0.002, 0.001, -0.001)),
        body("tail", 1.2, (0.0, 0.0, 0.2), (0.04, 0.045, 0.01, 0.0, 0.002, 0.003)),
        joint("mount", "fixed", "base", "plinth", (0, 0, 0.5), rpy=(0.1, 0.2, 0.3)),
        joint("slide", "prismatic", "plinth", "carriage", (0.1, 0, 0.2), (1, 0.4, 0), limits=(-1, 2)),
        joint("turn", "continuous", "carriage", "arm", (0, 0.1, 0.3), (0.2, -0.3, 1), (0.4, 0, -0.6)),
        joint("strap", "fixed", "arm", "pack", (0.4, -0.1, 0.05), rpy=(0.5, 0.6, 0.7)),
        joint("lift", "revolute", "arm", "hand", (0.6, 0, 0.1), (0, 1, 0.1), (0, 0.3, 0)),
        joint("flange", "fixed", "hand", "tool", (0.25, 0.05, -0.02), rpy=(0.2, -0.4, 0.9)),
        joint("wag", "revolute", "carriage", "tail", (-0.2, 0, 0.1), (1, 1, 0)),
    )
