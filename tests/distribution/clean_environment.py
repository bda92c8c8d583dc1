"""The wheel and the sdist, each in an environment of its own, for every Python there is; the tests with it.

    python tests/distribution/clean_environment.py [--lowest] [--python NAME …] [--sdist] [TEST …]

`--lowest` installs the oldest versions that pyproject.toml allows instead of those of constraints.txt. The
tests named are run against what is installed, a choice that touches every room if none is named: those of the
checkout for the wheel, those that the sdist brings for the sdist. Pythons are looked for on the path and
among the versions of pyenv; one that is not on the machine is named and left out. Run by `make distribution`;
takes minutes and a build environment, so it is no pytest.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PYTHONS = ("python3.11", "python3.12", "python3.13")
TESTS = (
    "cards",
    "catalogue",
    "model",
    "modal",
    "files",
    "viewer",
    "cli/test_demo.py",
    "ema/test_selection.py",
)
"""Of tests/, where none are named."""


def lowest() -> list[str]:
    """The oldest version of each dependency that pyproject.toml allows, as constraints."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = [line for lines in project["optional-dependencies"].values() for line in lines]
    named = (re.fullmatch(r"([\w.-]+)>=([\w.]+)", line) for line in (*project["dependencies"], *extras))
    return [
        f"{found[1]}=={found[2]}.*" if found[2].count(".") < 2 else f"{found[1]}=={found[2]}"
        for found in named
        if found
    ]


def build(folder: Path) -> list[Path]:
    """The wheel and the sdist."""
    subprocess.run([sys.executable, "-m", "build", "--outdir", folder, ROOT], check=True, capture_output=True)
    return sorted(folder.glob("flexmodal-*"))


def interpreter(name: str) -> str | None:
    """The Python of a name such as python3.12, if one runs: on the path, or one of pyenv's."""
    kept = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions"
    version = name.removeprefix("python")
    others = sorted(kept.glob(f"{version}.*/bin/{name}")) if version[:1].isdigit() else []
    for found in (shutil.which(name), *map(str, others)):
        if found and not subprocess.run([found, "-c", ""], capture_output=True, check=False).returncode:
            return found
    return None


def tested_from(package: Path, scratch: Path) -> Path:
    """The folder whose tests are run: the checkout, or the sdist itself, unpacked."""
    if package.suffix == ".whl":
        return ROOT
    with tarfile.open(package) as packed:
        packed.extractall(scratch, filter="data")
    return scratch / package.name.removesuffix(".tar.gz")


def examine(python: str, package: Path, constraints: Path, tests: list[str]) -> bool:
    """Install a package and what the tests need in a new environment, outside the checkout; run the tests."""
    with tempfile.TemporaryDirectory() as scratch:
        place = Path(scratch) / "environment"
        source = tested_from(package, Path(scratch))
        subprocess.run([python, "-m", "venv", place], check=True)
        run = [place / "bin" / "python", "-m", "pip", "install", "--quiet"]
        subprocess.run([*run, "--upgrade", "pip>=25.1"], check=True)
        wanted = [f"{package}[arms,excel,fast]", "--group", f"{source / 'pyproject.toml'}:dev"]
        if subprocess.run([*run, "--constraint", constraints, *wanted], check=False).returncode:
            return False
        command = [place / "bin" / "pytest", "-q", "-p", "no:cacheprovider", "--rootdir", source]
        command += ["-c", source / "pyproject.toml", *(source / "tests" / test for test in tests)]
        ran = subprocess.run(
            command, cwd=scratch, env={**os.environ, "OPENBLAS_NUM_THREADS": "1"}, check=False
        )
        return ran.returncode == 0


def main() -> int:
    """Build, install, test; one line for each Python and package."""
    asked = argparse.ArgumentParser()
    asked.add_argument("--lowest", action="store_true")
    asked.add_argument("--sdist", action="store_true", help="the sdist too, not the wheel alone")
    asked.add_argument("--python", action="append", help="may be repeated; all there are if none")
    asked.add_argument("tests", nargs="*", default=list(TESTS))
    given = asked.parse_args()
    failed = False
    with tempfile.TemporaryDirectory() as folder:
        constraints = ROOT / "constraints.txt"
        if given.lowest:
            constraints = Path(folder) / "lowest.txt"
            constraints.write_text("\n".join(lowest()))
        for package in build(Path(folder)):
            if package.suffix != ".whl" and not given.sdist:
                continue
            for name in given.python or PYTHONS:
                python = interpreter(name)
                if python is None:
                    print(f"{name}: not on this machine", flush=True)
                    continue
                sound = examine(python, package, constraints, given.tests)
                failed |= not sound
                print(f"{name}, {package.name}: {'sound' if sound else 'FAILED'}", flush=True)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
