import signal
from collections.abc import Iterator

import numpy as np
import pytest

from flexmodal.campaign import (
    Blow,
    Campaign,
    CampaignPoint,
    CampaignPosture,
    FrfRecords,
    ModeTable,
    Trial,
    Window,
)

TRIALS = (
    Trial(1, 180.0, 3, "soft", record_length=4.0),
    Trial(2, 180.0, 3, "soft"),
    Trial(3, 400.0, 3, "hard", window=Window("exponential", 1.5)),
    Trial(4, 390.0, 3, "hard", repeat_of=3),
)


def frfs(seed: int = 0, lines: int = 40) -> FrfRecords:
    rng = np.random.default_rng(seed)
    labels = [
        (posture, trial, response, 2)
        for posture in (1, 2)
        for trial in (1, 2, 3, 4)
        for response in ((1, 3), (2, -3), (3, 1))
    ]
    shape = (len(labels), lines)
    return FrfRecords(
        frequency=0.25 * np.arange(lines),
        value=rng.normal(size=shape) + 1j * rng.normal(size=shape),
        coherence=rng.uniform(0.5, 1.0, size=shape),
        posture=np.array([label[0] for label in labels]),
        trial=np.array([label[1] for label in labels]),
        response=np.array([label[2] for label in labels]),
        reference=np.array([(label[3], -3) for label in labels]),
        form="inertance",
        trials=TRIALS,
    )


def blows(seed: int = 0, samples: int = 64) -> tuple[Blow, ...]:
    rng = np.random.default_rng(seed)
    return tuple(
        Blow(
            posture=1,
            trial=1,
            sequence=sequence,
            reference=(2, -3),
            time=np.arange(samples) / 2048,
            force=rng.normal(size=samples) + 180.0,
            channels=((1, 3), (3, 1)),
            response=rng.normal(size=(2, samples)),
        )
        for sequence in (1, 2, 3)
    )


def modes() -> ModeTable:
    return ModeTable(
        posture=np.array([1, 2]),
        response=np.array([1, 3]),
        reference=np.array([2, 2]),
        mode=np.array([1, 1]),
        natural_frequency=np.array([7.4, np.nan]),
        damping_ratio=np.array([0.075, np.nan]),
        amplitude=np.array([4.4e-4 - 1.7e-4j, complex(np.nan, np.nan)]),
        flag=("", "amplitude:missing"),
    )


@pytest.fixture
def campaign() -> Campaign:
    """Two postures, three points, four trials; every kind of data."""
    return Campaign(
        title='A "test" in \\ two lines\nof\x7f ümlauts',
        robot="two_link",
        band=(2.0, 9.0),
        postures=(
            CampaignPosture(1, "straight", {"q1": 0.0, "q 2": 1 / 3}),
            CampaignPosture(2, "bent", {}),
        ),
        points=(
            CampaignPoint(1, "tip", "hand", (0.5, 0.0, -0.1)),
            CampaignPoint(2, "wrist, with a long näme", "arm", (0.0, 0.0, 0.0)),
            CampaignPoint(3, "elbow", "arm", (0.1, 0.2, 0.3)),
        ),
        trials=TRIALS,
        frfs=frfs(),
        blows=blows(),
        modes=modes(),
    )


@pytest.fixture(autouse=True)
def patience() -> Iterator[None]:
    """No reading of a small file takes twenty seconds; one that hangs is stopped."""

    def stop(*_: object) -> None:
        raise TimeoutError("still at it after twenty seconds")

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(20)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)
