"""Arms that nobody built: planar or spatial, of three to seven joints, some of them sliding."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from jaxtyping import Float

from flexmodal.errors import Fault, InvalidRequest
from flexmodal.files import whole_set
from flexmodal.text.write_toml import toml_text

JOINTS = (3, 7)
"""Fewest and most."""
SLIDING = 0.4
"""Part of the arms that have a sliding joint."""
FREQUENCIES = (9.0, 60.0)
"""Where the first and the last joint would swing, all others locked, but for some scatter [Hz]."""


@dataclass(frozen=True, eq=False)
class _Part:
    """One joint with the link that it moves."""

    slides: bool
    axis: Float[np.ndarray, "3"]
    span: Float[np.ndarray, "3"]
    """From this joint to the next, in the frame of the link [m]."""
    mass: float
    centre: Float[np.ndarray, "3"]
    inertia: Float[np.ndarray, "3 3"]
    stiffness: float = 0.0
    damping: float = 0.0


def draw_arm(folder: str | Path, seed: int, *, spatial: bool | None = None) -> Path:
    """Draw an arm and write its card and URDF.

    Args:
        folder: where `robot.toml` and `arm.urdf` go; made if it is not there.
        seed: of everything drawn.
        spatial: whether its axes point all ways instead of one; drawn if None.

    Returns:
        Path of the card.

    Raises:
        InvalidRequest: a seed below 0.
        OutputExists: one of the files exists.
    """
    if seed < 0:
        raise InvalidRequest(Fault("call", "seed", str(seed), "0 or more"))
    random = np.random.default_rng([seed, 7])
    turned = bool(random.uniform() < 0.5)
    spatial = turned if spatial is None else spatial
    parts = _sprung(_parts(random, spatial), random)
    card = Path(folder) / "robot.toml"
    card.parent.mkdir(parents=True, exist_ok=True)
    with whole_set([card, card.parent / "arm.urdf"]) as scratch:
        (scratch / "robot.toml").write_text(toml_text(_card(parts, seed, random)), encoding="utf-8")
        (scratch / "arm.urdf").write_text(_urdf(parts), encoding="utf-8")
    return card


def _parts(random: np.random.Generator, spatial: bool) -> list[_Part]:
    """Links that grow lighter and shorter outwards, tubes of a tenth to a fourth of their length across."""
    count = int(random.integers(JOINTS[0], JOINTS[1] + 1))
    sliding = int(random.integers(0, count - 1)) if random.uniform() < SLIDING else -1
    mass, length = random.uniform(25, 90), random.uniform(0.35, 0.9)
    found: list[_Part] = []
    for number in range(count):
        span = length * _way(random, spatial)
        axis = _axis(random, spatial, found, slides=number == sliding, span=span)
        across = random.uniform(0.1, 0.25) * length
        along = np.outer(span, span) / length**2
        inertia = mass * (length**2 / 12 * (np.eye(3) - along) + across**2 / 4 * (np.eye(3) + along))
        off = 0.1 * across * random.standard_normal(3) * (1.0 if spatial else np.array([1.0, 0.0, 1.0]))
        found.append(
            _Part(number == sliding, axis, span, mass, random.uniform(0.3, 0.6) * span + off, inertia)
        )
        mass, length = mass * random.uniform(0.5, 0.85), length * random.uniform(0.7, 1.1)
    return found


def _way(random: np.random.Generator, spatial: bool) -> np.ndarray:
    """Direction of a link: along x, bent a little; of a spatial arm upwards or along."""
    bend = random.uniform(-0.5, 0.5)
    if not spatial:
        return np.array([np.cos(bend), 0.0, np.sin(bend)])
    way = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])[int(random.integers(0, 2))]
    way = way + 0.2 * random.standard_normal(3)
    return np.asarray(way / np.linalg.norm(way))


def _axis(
    random: np.random.Generator, spatial: bool, before: list[_Part], *, slides: bool, span: np.ndarray
) -> np.ndarray:
    """Of a planar arm across its plane, or in it for one that slides; else not the last two again."""
    if not spatial:
        flat = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])[int(random.integers(0, 2))]
        return flat if slides else np.array([0.0, -1.0, 0.0])
    if slides:
        return span / np.linalg.norm(span)
    ways = np.eye(3)
    if not before:
        return ways[2]
    last = [part.axis for part in before[-2:]]
    free = [way for way in ways if len(last) < 2 or not all(abs(way @ axis) > 0.9 for axis in last)]
    return free[int(random.integers(0, len(free)))]


def _sprung(parts: list[_Part], random: np.random.Generator) -> list[_Part]:
    """Stiffness from where each joint would swing alone, the arm beyond it as drawn; damping of 1 to 4 %."""
    low, high = np.log(FREQUENCIES)
    found = []
    for number, part in enumerate(parts):
        size = _beyond(parts[number:])
        place = number / (len(parts) - 1)
        omega = 2 * np.pi * np.exp(low + place * (high - low) + random.uniform(-0.3, 0.3))
        ratio = random.uniform(0.01, 0.04)
        found.append(replace(part, stiffness=float(size * omega**2), damping=float(2 * ratio * size * omega)))
    return found


def _beyond(parts: list[_Part]) -> float:
    """Mass or moment of inertia about the first joint's axis of it and all beyond [kg, kg·m²]."""
    if parts[0].slides:
        return sum(part.mass for part in parts)
    axis, place, total = parts[0].axis, np.zeros(3), 0.0
    for part in parts:
        arm = np.cross(axis, place + part.centre)
        total += part.mass * float(arm @ arm) + float(axis @ part.inertia @ axis)
        place = place + part.span
    return total


def _card(parts: list[_Part], seed: int, random: np.random.Generator) -> dict[str, object]:
    joints = {
        f"q{number}": {"stiffness": part.stiffness, "damping": part.damping}
        for number, part in enumerate(parts, start=1)
    }
    points = {}
    for number, part in enumerate(parts, start=1):
        side = np.cross(part.span, [0.0, 1.0, 0.0])
        beside = 0.08 * side / max(float(np.linalg.norm(side)), 1e-9)
        place = random.uniform(0.6, 1.0) * part.span + random.uniform(0.5, 1.0) * beside
        points[f"point_{number}"] = {"link": f"link_{number}", "xyz": [float(one) for one in place]}
    postures = {
        f"posture_{number}": {
            name: float(random.uniform(-0.2, 0.2) if part.slides else random.uniform(-1.2, 1.2))
            for name, part in zip(joints, parts, strict=True)
        }
        for number in (1, 2, 3)
    }
    return {
        "format": 1, "name": f"arm_{seed}", "title": f"An arm drawn from seed {seed}", "urdf": "arm.urdf",
        "tool": f"link_{len(parts)}", "source": "Drawn at random; nobody built or measured it.",
        "joint": joints, "point": points, "posture": postures,
    }  # fmt: skip


def _urdf(parts: list[_Part]) -> str:
    lines = ['<robot name="arm">', '  <link name="base"/>']
    place = np.zeros(3)
    for number, part in enumerate(parts, start=1):
        parent = "base" if number == 1 else f"link_{number - 1}"
        kind, most = ("prismatic", 0.3) if part.slides else ("revolute", 1.6)
        moments = zip(
            ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), part.inertia[np.triu_indices(3)], strict=True
        )
        lines += [
            f'  <link name="link_{number}"><inertial><origin xyz="{_three(part.centre)}"/>',
            f'    <mass value="{part.mass!r}"/>',
            "    <inertia " + " ".join(f'{name}="{float(value)!r}"' for name, value in moments) + "/>",
            "  </inertial></link>",
            f'  <joint name="q{number}" type="{kind}"><parent link="{parent}"/><child link="link_{number}"/>',
            f'    <origin xyz="{_three(place)}"/><axis xyz="{_three(part.axis)}"/>',
            f'    <limit lower="{-most}" upper="{most}" effort="1000" velocity="3"/></joint>',
        ]
        place = part.span
    return "\n".join([*lines, "</robot>", ""])


def _three(vector: np.ndarray) -> str:
    return " ".join(repr(float(one)) for one in vector)
