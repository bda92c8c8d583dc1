"""Receptances of the diagnosis' models beside those of the plant that the rig strikes."""

import numpy as np
import pytest

import flexmodal
from flexmodal.diagnosis.effects import Context
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.placed import Placed
from flexmodal.identification import observe, predict, unlimited
from flexmodal.rig import FORMS, simulate
from flexmodal.rig.believed import known_robot
from flexmodal.rig.effects.effect import Site
from flexmodal.rig.plant.build import build
from flexmodal.rig.sensing import Sensor
from flexmodal.rig.simulate import make_stand
from flexmodal.structure import robot_space

from .conftest import effect_of

STAYS = {"relaxing": 1e-8}
"""Nothing of a spring relaxes."""


def seen_and_simulated(name, postures, points=3, top=120.0):
    """Context and observations of a short campaign with the card's own parameters, and the rig's stand."""
    robot = flexmodal.load(name)
    result = simulate(
        robot, postures=postures, points=points, trials=2, averages=2, seed=3, record_length=1.0,
        band=(2.0, top), parameter_error=0.0,
    )  # fmt: skip
    stand = make_stand(result.robot, result.plan, known_robot(result.robot, {}))
    observed = unlimited(observe(result.campaign))
    return Context.of(robot, observed), observed, stand


def ours(context, observed, effect, where, values):
    """Receptances of the robot with one effect, for every observation."""
    placed = Placed(effect_of(effect) if isinstance(effect, str) else effect, where)
    hypothesis = Hypothesis(context, robot_space(context.robot)).and_also(placed)
    x = hypothesis.start(placed, values, np.zeros(len(hypothesis.base)))
    own = {p.name.rpartition(".")[2]: p.value(v) for p, v in zip(hypothesis.space, x, strict=True)}
    assert all(own[name] == pytest.approx(value, rel=1e-12) for name, value in values.items())
    return predict(hypothesis, x, observed)


def theirs(observations, stand, effect, where, values, form="own", more=(), beside=()):
    """The same from the plant that the rig strikes, with more of the same kind in its place, or of others."""
    value = np.zeros(observations.value.shape, dtype=complex)
    frequency = observations.axis.frequency
    for number, posture in enumerate(observations.postures):
        every = [*((effect, form, one) for one in (values, *more)), *beside]
        sites = [(FORMS[name][kind], Site(stand, where, one)) for name, kind, one in every]
        plant = build(stand, posture, sites)
        for row in np.flatnonzero(observations.posture == number):
            places = []
            for point, axis in (observations.response[row], observations.reference[row]):
                found = observations.campaign.point(int(point))
                places.append(plant.row(found.link, np.array(found.xyz), np.eye(3)[axis - 1])[None])
            inertance = plant.inertance(*places, frequency)[:, 0, 0]
            value[row] = -inertance / (2 * np.pi * frequency) ** 2
    return value


def carried_by_the_rig(observations, stand, form, values):
    """Receptances with a sensor of the rig at each response."""
    effect, value = FORMS["sensor_mass"][form], np.zeros(observations.value.shape, dtype=complex)
    tables = observations.response, observations.reference
    for row in range(len(observations)):
        seen, struck = (observations.campaign.point(int(table[row, 0])) for table in tables)
        ways = [np.eye(3)[int(table[row, 1]) - 1] for table in tables]
        sensor = Sensor()
        effect.sense({seen.name: sensor}, Site(stand, "sensor", values))
        posture = observations.postures[int(observations.posture[row])]
        plant = build(stand, posture, [], (seen.name, sensor))
        read, hit = (
            plant.row(point.link, np.array(point.xyz), way)[None]
            for point, way in zip((seen, struck), ways, strict=True)
        )
        inertance = plant.inertance(read, hit, observations.axis.frequency)[:, 0, 0]
        value[row] = -inertance / (2 * np.pi * observations.axis.frequency) ** 2
    return value
