"""Python started in the folder above a clone gets the package, or is told what is missing."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def above(tmp_path):
    (tmp_path / "flexmodal").symlink_to(ROOT, target_is_directory=True)
    return tmp_path


def python(folder, *arguments):
    return subprocess.run(
        [sys.executable, *arguments], cwd=folder, capture_output=True, text=True, timeout=60, check=False
    )


def test_the_package_is_found(above):
    ran = python(above, "-c", "import flexmodal; print(flexmodal.load('six_link').name)")
    assert (ran.returncode, ran.stdout) == (0, "six_link\n"), ran.stderr


def test_where_nothing_is_installed_it_says_so(above):
    ran = python(above, "-S", "-c", "import flexmodal")
    assert ran.returncode == 1
    last = ran.stderr.strip().splitlines()[-1]
    assert last.startswith("ImportError: flexmodal lies in ")
    assert "-m pip install --editable" in last
