"""The systems that most tests measure."""

from __future__ import annotations

import numpy as np
import pytest

from .truth import Truth, real_modes


@pytest.fixture
def four_modes() -> Truth:
    """Those of an arm: 8, 51, 58 and 94 Hz, 3 to 6 % damped, complex residues, five FRFs."""
    rng = np.random.default_rng(11)
    amplitude = rng.uniform(0.5, 1.5, size=(5, 4)) * np.exp(1j * rng.uniform(-0.6, 0.6, size=(5, 4)))
    truth = real_modes([8.0, 51.0, 58.0, 94.0], [0.06, 0.03, 0.04, 0.05], amplitude)
    return Truth(truth.frequency, truth.damping, truth.residue, upper=2e-6)


@pytest.fixture
def one_mode() -> Truth:
    """A single real mode at 51 Hz, 4 % damped."""
    return real_modes([51.0], [0.04], np.array([[1.3]]))
