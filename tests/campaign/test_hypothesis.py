"""Mutated campaigns, found by hypothesis: read, or refused with evidence, and nothing else."""

import sys
import tempfile
from pathlib import Path
from random import Random

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from flexmodal.campaign import read_campaign
from flexmodal.errors import InvalidCampaign

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
FILES = ("frf.uff", "time.uff", "modes.csv", "campaign.toml")


@pytest.fixture(scope="module")
def mutated():  # type: ignore[no-untyped-def]
    sys.path.insert(0, str(BENCHMARKS))
    try:
        from mutations import mutated
    finally:
        sys.path.remove(str(BENCHMARKS))
    return mutated


@settings(
    max_examples=100,
    deadline=None,
    derandomize=True,
    database=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(name=st.sampled_from(FILES), binary=st.booleans(), seed=st.integers(0, 2**32))
def test_nothing_but_sentences(name, binary, seed, written, mutated) -> None:  # type: ignore[no-untyped-def]
    sound = (written[binary] / name).read_bytes()
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        (folder / "campaign.toml").write_bytes((written[binary] / "campaign.toml").read_bytes())
        if name == "campaign.toml":
            (folder / "modes.csv").write_bytes((written[binary] / "modes.csv").read_bytes())
        (folder / name).write_bytes(mutated(sound[:20_000], Random(seed)))
        campaign, faults = None, None
        try:
            campaign = read_campaign(folder)
        except InvalidCampaign as error:
            faults = error.faults
    if campaign is None:
        assert faults
        assert all(fault.found and fault.allowed for fault in faults)
    else:
        assert campaign.frfs is None or np.all(np.isfinite(campaign.frfs.value))
