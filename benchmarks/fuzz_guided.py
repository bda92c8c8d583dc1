"""Inputs that atheris looks for by the code they reach, judged as those of `fuzz_targets`.

`python benchmarks/fuzz_guided.py TARGET SECONDS`, a process of its own: it has to import what it watches.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import atheris

with atheris.instrument_imports(include=["flexmodal"], enable_loader_override=False):
    import fuzz_campaign
    from fuzz_judges import SOUND
    from fuzz_targets import read_arguments, read_file, read_posture, refusal, warm

    from flexmodal.errors import FlexmodalError


def guided(target: str, seconds: int) -> None:
    """Let atheris look for inputs; ends the process, with 77 or more where one fails.

    Args:
        target: one of `fuzz_targets.TARGETS`; of campaigns, frf.uff in ASCII.
        seconds: how long.
    """
    warm()
    folder = Path(tempfile.mkdtemp(prefix="fuzz-"))
    corpus = folder / "corpus"
    corpus.mkdir()
    for text, file, _ in SOUND.values():
        (folder / file).write_bytes(text)

    def test(content: bytes) -> None:
        if target in SOUND:
            (folder / SOUND[target][1]).write_bytes(content)
            read_file(target, folder)
        elif target == "campaign":
            try:
                fuzz_campaign.read_one("frf.uff ASCII", content, folder)
            except FlexmodalError as error:
                refusal(error, ("campaign.toml", str(folder)))
        else:
            text = content.decode("utf-8", "replace").replace("\0", "")
            read_posture(text) if target == "posture" else read_arguments(
                ["measures", "six_link", *text.split()]
            )

    sound = {"posture": b"q1=1,q2=50deg", "arguments": b"--posture q1=1 --direction tool:+x --json"}
    first = (
        SOUND[target][0] if target in SOUND else sound.get(target, fuzz_campaign.sound()["frf.uff ASCII"][0])
    )
    (corpus / "sound").write_bytes(first)
    atheris.Setup(
        [
            sys.argv[0],
            "-len_control=0",
            f"-max_total_time={seconds}",
            "-timeout=20",
            "-max_len=20000",
            str(corpus),
        ],
        test,
    )
    atheris.Fuzz()


if __name__ == "__main__":
    guided(sys.argv[1], int(sys.argv[2]))
