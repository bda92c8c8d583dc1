"""The Python in docs/campaign.md runs as it stands, from the top of the checkout."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "docs" / "campaign.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```python\n(.*?)```", TEXT, flags=re.DOTALL)


@pytest.mark.parametrize("number", range(len(BLOCKS)))
def test_block(number: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(ROOT)
    exec(compile(BLOCKS[number], f"docs/campaign.md, block {number}", "exec"), {})
    out = capsys.readouterr().out
    assert out.strip() == ("inertance 0.997" if number == 1 else out.strip())
    assert out
