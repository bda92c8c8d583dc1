"""How long does a full campaign take to read? 7 postures × 6 points × 2 references × 4 trials × 800 lines.

Beside it, pyuff alone on the same file: what the checks cost.
"""

from __future__ import annotations

import tempfile
import time
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
from tables import write

from flexmodal.campaign import (
    Campaign,
    CampaignPoint,
    CampaignPosture,
    FrfRecords,
    Trial,
    read_campaign,
    write_campaign,
)

POSTURES, POINTS, REFERENCES, TRIALS, LINES = 7, 6, 2, 4, 800


def campaign() -> Campaign:
    rng = np.random.default_rng(0)
    labels = [
        (posture, trial, response, reference)
        for posture in range(1, POSTURES + 1)
        for trial in range(1, TRIALS + 1)
        for reference in range(1, REFERENCES + 1)
        for response in range(1, POINTS + 1)
    ]
    shape = (len(labels), LINES)
    trials = tuple(Trial(n, 100.0 * n, 3, "hard") for n in range(1, TRIALS + 1))
    return Campaign(
        title="as large as a full campaign",
        robot="fanuc_s360",
        band=(2.0, 200.0),
        postures=tuple(CampaignPosture(n, f"posture {n}", {"q1": 0.1 * n}) for n in range(1, POSTURES + 1)),
        points=tuple(CampaignPoint(n, f"point {n}", "link", (0.0, 0, 0)) for n in range(1, POINTS + 1)),
        trials=trials,
        frfs=FrfRecords(
            frequency=0.25 * np.arange(LINES),
            value=rng.normal(size=shape) + 1j * rng.normal(size=shape),
            coherence=rng.uniform(0.8, 1, size=shape),
            posture=np.array([label[0] for label in labels]),
            trial=np.array([label[1] for label in labels]),
            response=np.array([(label[2], 3) for label in labels]),
            reference=np.array([(label[3], 3) for label in labels]),
            form="inertance",
            trials=trials,
        ),
    )


def seconds(action: Callable[[], object]) -> float:
    """Processor time, which other work on the machine lengthens less."""
    started = time.process_time()
    action()
    return time.process_time() - started


def main() -> None:
    import pyuff

    made, rows = campaign(), []
    with tempfile.TemporaryDirectory() as scratch, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for binary in (True, False):
            folder = Path(scratch) / str(binary)
            writing = seconds(
                lambda folder=folder, binary=binary: write_campaign(made, folder, binary=binary)
            )
            size = (folder / "frf.uff").stat().st_size / 1e6
            file = str(folder / "frf.uff")
            times = [
                (
                    seconds(lambda folder=folder: read_campaign(folder)),
                    seconds(lambda file=file: pyuff.UFF(file).read_sets()),
                )
                for _ in range(5)
            ]
            reading, alone = (min(column) for column in zip(*times, strict=True))
            name = "58b, binary" if binary else "58, ASCII"
            row = [f"{size:.1f}", f"{writing:.1f}", f"{reading:.2f}", f"{alone:.2f}"]
            rows.append([name, *row, f"{reading / alone:.1f}"])
    records = POSTURES * POINTS * REFERENCES * TRIALS
    write(
        "campaign_loading",
        "Reading a full campaign",
        f"Made by `python benchmarks/campaign_loading.py`: {records} FRFs of {LINES} lines, each with its "
        "coherence. Processor time, best of five readings, in turn with those of pyuff, which checks "
        "nothing. How long the fit then takes is in [ema_speed](ema_speed.md).",
        ["file", "size [MB]", "write [s]", "read and check [s]", "pyuff alone [s]", "ratio"],
        rows,
    )


if __name__ == "__main__":
    main()
