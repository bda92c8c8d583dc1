"""A sound campaign of a planar arm and one of a spatial arm, made once."""

import pytest

import flexmodal
from flexmodal.rig import simulate


@pytest.fixture(scope="session")
def fanuc():
    return flexmodal.load("fanuc_s360")


@pytest.fixture(scope="session")
def planar(fanuc):
    made = simulate(
        fanuc, postures=["configuration_1", "configuration_3", "configuration_7"],
        points=2, references=2, trials=2, averages=2, peaks=(100.0,),
        band=(2.0, 120.0), record_length=1.5, seed=6,
    )  # fmt: skip
    return made.campaign


@pytest.fixture(scope="session")
def arm():
    return flexmodal.load("six_axis")


@pytest.fixture(scope="session")
def spatial(arm):
    made = simulate(
        arm, postures=2, points=2, references=1, trials=2, averages=2, peaks=(100.0,),
        band=(4.0, 100.0), record_length=1.0, seed=7,
    )  # fmt: skip
    return made.campaign
