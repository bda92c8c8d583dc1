"""The systems and chains that the engine is timed on."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

import flexmodal
from flexmodal.frf.kernels.task import Task
from flexmodal.model.robot import Robot

LINES = 416
"""Frequencies: a multiple of the lanes, so that peers that want one get the same axis."""


def random_task(
    n: int, systems: int, *, rows: int = 1, lines: int = LINES, diagonal: bool = True, seed: int = 0
) -> Task:
    """Random systems over their resonances, a few per cent damped; all pairs of the rows."""
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(systems, n, n))
    mass = A @ np.swapaxes(A, 1, 2) + 0.1 * np.eye(n)
    stiffness = np.diag(10 ** rng.uniform(4, 6, n))
    if not diagonal:
        Q = rng.normal(size=(n, n))
        stiffness = stiffness + 1e4 * Q @ Q.T
    jacobians = rng.normal(size=(systems, rows, n))
    pairs = tuple((i, j) for i in range(rows) for j in range(i, rows))
    omega = 2 * np.pi * np.linspace(0.5, 200, lines)
    return Task(
        systems,
        lambda part: (mass[part], jacobians[part]),
        stiffness,
        1e-3 * stiffness,
        np.zeros((n, n)),
        pairs,
        omega,
    )


def long_chain(count: int, *, spatial: bool = False) -> Robot:
    """A chain of equal links, softer towards the tip: in a plane, or every other joint across it."""
    text = ['<robot name="chain"><link name="base"/>']
    for i in range(count):
        text.append(
            f'<link name="l{i}"><inertial><origin xyz="0.2 0 0"/><mass value="2"/>'
            '<inertia ixx="0.01" iyy="0.03" izz="0.03" ixy="0" ixz="0" iyz="0"/></inertial></link>'
            f'<joint name="j{i}" type="revolute"><parent link="{f"l{i - 1}" if i else "base"}"/>'
            f'<child link="l{i}"/><origin xyz="{0.4 if i else 0} 0 0"/>'
            f'<axis xyz="{"0 1 0" if spatial and i % 2 else "0 0 1"}"/>'
            '<limit lower="-3" upper="3" effort="1" velocity="1"/></joint>'
        )
    path = Path(tempfile.mkdtemp(prefix="engine_chain_")) / "chain.urdf"
    path.write_text("".join([*text, "</robot>"]), encoding="utf-8")
    stiffness = {f"j{i}": 1e6 * 0.8**i for i in range(count)}
    damping = {name: 1e-3 * value for name, value in stiffness.items()}
    return flexmodal.load(path, stiffness=stiffness, damping=damping)


def random_postures(robot: Robot, count: int, seed: int = 0) -> np.ndarray:
    """Postures inside the limits."""
    lower = np.array([max(joint.lower, -3.0) for joint in robot.commanded.values()])
    upper = np.array([min(joint.upper, 3.0) for joint in robot.commanded.values()])
    return np.random.default_rng(seed).uniform(lower, upper, (count, len(lower)))
