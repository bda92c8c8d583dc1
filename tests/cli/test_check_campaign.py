"""`flexmodal check` on campaigns."""

import json
from pathlib import Path

import pytest

from flexmodal.cli.main import main

THESIS = Path(__file__).parents[2] / "robots" / "fanuc_s360" / "campaigns" / "thesis"


def run(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str]:
    with pytest.raises(SystemExit) as caught:
        main(["check", *arguments])
    return int(caught.value.code or 0), capsys.readouterr().out


def test_a_sound_campaign(capsys: pytest.CaptureFixture[str]) -> None:
    for path in (THESIS, THESIS / "campaign.toml"):
        assert run(capsys, str(path)) == (0, f"{path}: sound\n")


def test_a_campaign_with_faults(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    (tmp_path / "campaign.toml").write_text("format = 1\ntitle = 3\n")
    status, out = run(capsys, "--json", str(tmp_path))
    (report,) = json.loads(out)["checked"]
    assert status == 1
    assert not report["sound"]
    assert {fault["key"] for fault in report["faults"]} == {"title", "robot", "posture", "point", "trial"}
