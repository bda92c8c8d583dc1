"""A small rig campaign of each kind, made once."""

from dataclasses import replace

import pytest

import flexmodal
from flexmodal.rig import simulate

POSTURES = ["configuration_1", "configuration_3", "configuration_7"]


@pytest.fixture(scope="session")
def fanuc():
    return flexmodal.load("fanuc_s360")


@pytest.fixture(scope="session")
def rig(fanuc):
    """Three postures, three points, two hammer positions, two repeats: 36 FRFs."""
    return simulate(fanuc, postures=POSTURES, points=3, references=2, trials=2, peaks=(100.0,), seed=2)


@pytest.fixture(scope="session")
def campaign(rig):
    """The same without its blows: FRFs alone."""
    return replace(rig.campaign, blows=())
