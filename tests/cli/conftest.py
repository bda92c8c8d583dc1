"""The command line run inside the tests, and as a process of its own; an arm to spoil."""

import json
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import jsonschema
import pytest

from flexmodal.cli.main import SCHEMAS, main

PROGRAM = str(Path(sys.executable).with_name("flexmodal"))


@dataclass(frozen=True)
class Ran:
    status: int
    out: str
    err: str

    def json(self):
        """The one object on standard output; NaN and Infinity are no JSON."""
        assert self.status in (0, 1), self.err
        found = json.loads(self.out, parse_constant=lambda name: pytest.fail(f"{name} in JSON"))
        assert isinstance(found, dict)
        assert self.out.count("\n") == 1
        assert self.out.endswith("\n")
        return found

    def refused(self, *words, status=2):
        """One clear complaint: the status, no traceback, nothing on standard output, and these words."""
        assert (self.status, self.out) == (status, ""), self.err
        assert "Traceback" not in self.err
        assert "Warning" not in self.err
        assert self.err.strip()
        for word in words:
            assert str(word) in self.err
        return self.err.strip().splitlines()


def valid(command, found):
    """What a command printed, after it was held against the schema of its `--json`."""
    schema = json.loads((SCHEMAS / f"{command}.json").read_text(encoding="utf-8"))
    jsonschema.validate(found, schema)
    return found


@pytest.fixture(name="valid")
def valid_fixture():
    """See `valid`."""
    return valid


@pytest.fixture
def cli(capsys):
    """Run a command in this process."""

    def run(*arguments):
        capsys.readouterr()
        with pytest.raises(SystemExit) as left:
            main([str(argument) for argument in arguments])
        out, err = capsys.readouterr()
        assert isinstance(left.value.code, int)
        return Ran(left.value.code, out, err)

    return run


@pytest.fixture
def shell(tmp_path):
    """Run a command as a process of its own, which may not take longer than a minute."""

    def run(*arguments, **options):
        words = [PROGRAM, *map(str, arguments)]
        options = {"cwd": tmp_path, "capture_output": True, "encoding": "utf-8", "timeout": 60} | options
        done = subprocess.run(words, check=False, **options)
        return Ran(done.returncode, done.stdout or "", done.stderr or "")

    return run


@pytest.fixture
def program():
    """Path of the installed program."""
    return PROGRAM


INERTIAL = (
    '<inertial><origin xyz="0.5 0 0"/><mass value="2"/>'
    '<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial>'
)
LIMIT = '<limit lower="-2" upper="2" effort="1" velocity="1"/>'


def _joint(name, parent, child, kind="revolute"):
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="1 0 0"/><axis xyz="0 -1 0"/>{LIMIT if kind == "revolute" else ""}</joint>\n'
    )


URDF = (
    '<?xml version="1.0"?>\n<robot name="arm">\n<link name="base"/>\n'
    + "".join(f'<link name="{name}">{INERTIAL}</link>\n' for name in ("upper", "fore", "hand"))
    + '<link name="tool"/>\n'
    + _joint("q1", "base", "upper")
    + _joint("bend", "upper", "fore")
    + _joint("q2", "fore", "hand")
    + _joint("mount", "hand", "tool", "fixed")
    + "</robot>\n"
)

CARD = """format = 1
name = "arm"
title = "An arm"
urdf = "arm.urdf"
tool = "tool"
source = "made up"
[joint.q1]
stiffness = 1000.0
damping = 1.0
[joint.bend]
pseudo = true
stiffness = 5000.0
damping = 2.0
[joint.q2]
stiffness = 500.0
damping = 0.5
[point.end]
link = "hand"
xyz = [0.5, 0.0, 0.0]
[posture.bent]
q1 = 0.5
q2 = -0.8
[family.sweep]
parameter = "q1"
from = -1.0
to = 1.0
follow = { q2 = -1.0 }
"""


@pytest.fixture
def urdf(tmp_path):
    """Write the arm's URDF with parts replaced, and give its path."""

    def write(*replacements, text=URDF):
        for old, new in replacements:
            assert old in text
            text = text.replace(old, new, 1)
        path = tmp_path / "arm.urdf"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path

    return write


@pytest.fixture
def card(tmp_path, urdf):
    """Write the arm's card with parts replaced, its sound URDF beside it, and give its path."""

    def write(*replacements):
        urdf()
        text = CARD
        for old, new in replacements:
            assert old in text
            text = text.replace(old, new, 1)
        path = tmp_path / "robot.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return write
