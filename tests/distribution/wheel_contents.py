"""Build the wheel and say what is in it that should not be, or not in it that should.

Run by `make check`; takes some seconds and a build environment, so it is no pytest.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

ROOT = Path(__file__).parents[2]


def faults_of(wheel: Path) -> list[str]:
    """Sentences about the contents of a wheel; none if they are as they should be."""
    names = set(zipfile.ZipFile(wheel).namelist())
    data = "flexmodal/_catalogue"
    code = (path for path in (ROOT / "flexmodal").rglob("*.py*") if path.suffix in {".py", ".pyi"})
    wanted = {
        *(str(path.relative_to(ROOT)) for path in code),
        *(str(path.relative_to(ROOT / "viewer")) for path in (ROOT / "viewer").rglob("*.py")),
        *(f"{data}/{path.relative_to(ROOT)}" for path in (ROOT / "urdf").glob("*.urdf")),
        *(f"{data}/{path.relative_to(ROOT)}" for path in (ROOT / "robots").glob("*/robot.toml")),
        *(f"{data}/{path.relative_to(ROOT)}" for path in (ROOT / "robots").glob("*/campaigns/*/*.*")),
        "flexmodal/py.typed",
        "flexmodal_viewer/py.typed",
    }
    tops = ("flexmodal/", "flexmodal_viewer/", "flexmodal-")
    faults = [f"missing: {name}" for name in sorted(wanted - names)]
    return faults + [f"does not belong: {name}" for name in sorted(names) if not name.startswith(tops)]


def main() -> int:
    """Build, compare, print."""
    with tempfile.TemporaryDirectory() as folder:
        build = [sys.executable, "-m", "build", "--wheel", "--outdir", folder, str(ROOT)]
        result = subprocess.run(build, capture_output=True, text=True, check=False)
        if result.returncode:
            print(result.stdout[-2000:], result.stderr[-2000:], sep="\n")
            return 1
        (wheel,) = Path(folder).glob("*.whl")
        faults = faults_of(wheel)
        print("\n".join(faults) or f"{wheel.name}: contents as they should be")
        return int(bool(faults))


if __name__ == "__main__":
    sys.exit(main())
