import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

CARD = """
format = 1
name = "two_link"
title = "Two links"
urdf = "two_link.urdf"
tool = "tool"
source = "made up"
[joint.q1]
stiffness = 1000.0
damping = 1.0
[joint.bend]
pseudo = true
stiffness = 5000
damping = 0
[point.end]
link = "hand"
xyz = [0.5, 0, 0]
[posture.bent]
q1 = 0.5
[family.sweep]
parameter = "q1"
from = -1.0
to = 1.0
follow = { q2 = -1.0 }
"""

INERTIAL = (
    '<inertial><origin xyz="0.5 0 0"/><mass value="2"/>'
    '<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial>'
)


def joint(name: str, parent: str, child: str, kind: str = "revolute", inside: str = "") -> str:
    limit = '<limit lower="-2" upper="2" effort="1" velocity="1"/>' if kind == "revolute" else ""
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="1 0 0"/><axis xyz="0 -1 0"/>{limit}{inside}</joint>\n'
    )


URDF = (
    '<?xml version="1.0"?>\n<robot name="two_link">\n<link name="base"/>\n'
    + "".join(f'<link name="{name}">{INERTIAL}</link>\n' for name in ("arm", "forearm", "hand"))
    + '<link name="tool"/>\n'
    + joint("q1", "base", "arm")
    + joint("bend", "arm", "forearm")
    + joint("q2", "forearm", "hand")
    + joint("mount", "hand", "tool", "fixed")
    + "</robot>\n"
)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A sound card beside its URDF."""
    (tmp_path / "robot.toml").write_text(CARD, encoding="utf-8")
    (tmp_path / "two_link.urdf").write_text(URDF, encoding="utf-8")
    return tmp_path


@pytest.fixture(autouse=True)
def patience() -> Iterator[None]:
    """No reading of a small file takes ten seconds; one that hangs is stopped."""

    def stop(*_: object) -> None:
        raise TimeoutError("still reading after ten seconds")

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(10)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


@pytest.fixture
def pipe(tmp_path: Path) -> Path:
    path = tmp_path / "pipe"
    os.mkfifo(path)
    return path


@pytest.fixture
def card_text() -> str:
    return CARD


@pytest.fixture
def urdf_text() -> str:
    return URDF
