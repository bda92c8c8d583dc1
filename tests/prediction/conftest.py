"""One rig campaign of an arm of which the card knows little, with effects hidden in it, made once."""

from dataclasses import replace

import pytest

import flexmodal
from flexmodal.identification.poor import POOR
from flexmodal.prediction import build_prediction
from flexmodal.rig import ParameterError, simulate

SHOWN = 5


@pytest.fixture(scope="session")
def fanuc():
    return flexmodal.load("fanuc_s360")


@pytest.fixture(scope="session")
def every(fanuc):
    """Seven postures: five to learn from, two to be judged by."""
    made = simulate(
        fanuc,
        postures=7,
        points=2,
        references=1,
        trials=2,
        peaks=(100.0,),
        band=(2.0, 100.0),
        record_length=2.0,
        hide=["sensor_gain@location_1,error=0.3", "time_delay@location_6"],
        parameter_error=ParameterError(stiffness=0.5, damping=0.5, mass=0.3, inertia=0.3),
        seed=5,
        time=False,
    )
    return made.campaign


@pytest.fixture(scope="session")
def campaign(every):
    ids = [posture.id for posture in every.postures[:SHOWN]]
    return replace(every, frfs=every.frfs.select(posture=ids))


@pytest.fixture(scope="session")
def problem(campaign, fanuc):
    return build_prediction(campaign, fanuc, trust=POOR)
