"""Campaigns of modes alone, made from a robot that is known: the believed one, or one with a link that
bends."""

from dataclasses import replace

import numpy as np
import pytest

import flexmodal
from flexmodal.campaign import Campaign, CampaignPoint, CampaignPosture, ModeTable, Trial
from flexmodal.diagnosis.effects import Context, catalogue
from flexmodal.diagnosis.hypothesis import Hypothesis
from flexmodal.diagnosis.modal_model import ModalModel
from flexmodal.diagnosis.placed import Placed
from flexmodal.structure import robot_space

PLACES = [(number, 3) for number in range(1, 7)]
STRUCK = (2, 3)
BAND = (2.0, 200.0)


@pytest.fixture(scope="session")
def rigid():
    return flexmodal.load("fanuc_s360_rigid_link")


@pytest.fixture(scope="session")
def tested(rigid):
    """Postures and points of the hammer test, and nothing measured."""
    names = [f"configuration_{k}" for k in (1, 2, 6, 7)]
    return Campaign(
        title="made up", robot="fanuc_s360_rigid_link", band=BAND,
        postures=tuple(
            CampaignPosture(k, name, dict(rigid.postures[name])) for k, name in enumerate(names, start=1)
        ),
        points=tuple(
            CampaignPoint(k, f"location_{k}", rigid.points[f"location_{k}"].link,
                          tuple(float(v) for v in rigid.points[f"location_{k}"].xyz))
            for k in range(1, 7)
        ),
        trials=(Trial(1, 100.0, 3, "soft"),),
    )  # fmt: skip


@pytest.fixture(scope="session")
def places():
    return PLACES


@pytest.fixture(scope="session")
def explained_by(rigid, tested):
    """A function: the robot, or the robot with one effect, as a model of that campaign's modes."""
    return lambda key=None: explanation_of(rigid, tested, key)


def explanation_of(rigid, tested, key=None):
    context = Context(rigid, tested.postures, tested.points, tuple(PLACES), (STRUCK,), BAND, every_line=False)
    hypothesis = Hypothesis(context, robot_space(rigid))
    if key is not None:
        hypothesis = hypothesis.and_also(Placed(catalogue([key[0]])[key[0]], key[1]))
    return ModalModel(hypothesis)


def measured(explanation, campaign, x, *, frequency, damping, shape, seed, highest=200.0):
    """The campaign with the modes of a model at x: relative scatter of frequencies and damping, and of
    shapes."""
    random = np.random.default_rng(seed)
    rows = []
    for posture, seen in zip(campaign.postures, explanation.forecasts(x, PLACES, slopes=False), strict=True):
        for m in np.argsort(seen.log_frequency):
            f, ratio = np.exp(seen.log_frequency[m]), np.exp(seen.log_damping[m])
            if f > highest or ratio > 0.3:
                continue
            middle_f, middle_z = (
                f * np.exp(frequency * random.normal()),
                ratio * np.exp(damping * random.normal()),
            )
            u = seen.shape[:, m]
            largest = u[np.argmax(np.abs(u))]
            u = u * (np.abs(largest) / largest)  # an eigenvector's sign is LAPACK's choice, the noise is not
            noise = (
                shape
                * np.linalg.norm(u)
                / np.sqrt(len(u))
                * (random.normal(size=len(u)) + 1j * random.normal(size=len(u)))
                / np.sqrt(2)
            )
            residue = (u + noise) * u[PLACES.index(STRUCK)]
            for place, value in zip(PLACES, residue, strict=True):
                here_f, here_z = (
                    middle_f * np.exp(0.002 * random.normal()),
                    middle_z * np.exp(0.03 * random.normal()),
                )
                amplitude = value * 2j * 2 * np.pi * middle_f
                rows.append((posture.id, place[0], STRUCK[0], int(m) + 1, here_f, here_z, amplitude))
    columns = list(zip(*rows, strict=True))
    table = ModeTable(
        *(np.array(column, dtype=int) for column in columns[:4]), np.array(columns[4]), np.array(columns[5]),
        np.array(columns[6], dtype=complex), ("",) * len(rows),
    )  # fmt: skip
    return replace(campaign, modes=table)


@pytest.fixture(scope="session")
def as_believed(rigid, tested):
    """The robot as its card says but a few per cent, with the scatter of a fair test."""
    explanation = explanation_of(rigid, tested)
    x = np.random.default_rng(3).normal(0, 0.05, len(explanation.space))
    return measured(explanation, tested, x, frequency=0.004, damping=0.05, shape=0.1, seed=4)


@pytest.fixture(scope="session")
def bending(rigid, tested):
    """A function: the robot with a second link that bends, its shapes scattering as asked."""
    explanation = explanation_of(rigid, tested, ("link_flexibility", "link_2"))
    space = explanation.space
    x = np.zeros(len(space))
    x[: len(space) - 3] = np.random.default_rng(5).normal(0, 0.04, len(space) - 3)
    for name, value in {"stiffness": 3e5, "damping": 60.0, "position": 0.5}.items():
        k = space.index[f"link_flexibility@link_2.{name}"]
        x[k] = space.parameters[k].coordinate(value)

    def made(shape, frequency=0.01, damping=0.25, seed=6):
        return measured(
            explanation,
            tested,
            x,
            frequency=frequency,
            damping=damping,
            shape=shape,
            seed=seed,
            highest=160.0,
        )

    return made
