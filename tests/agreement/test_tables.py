"""The quick tables of the docs are what their scripts make today."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_fanuc_frequencies_table_is_current():
    command = [sys.executable, str(ROOT / "benchmarks" / "fanuc_frequencies.py"), "--check"]
    result = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
    assert result.returncode == 0, result.stdout + result.stderr
