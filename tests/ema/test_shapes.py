"""Shapes from residues that share a reference, against the shapes the FRFs were made of."""

import numpy as np

from flexmodal.campaign import FrfRecords
from flexmodal.ema import fit
from flexmodal.ema.plot import draw_shapes
from flexmodal.ema.shapes import fitted_shapes

SHAPE = np.array([[1.0, 0.4], [0.6, -1.0], [0.2, -0.5]])  # response by mode, largest 1 in size
AXIS = np.linspace(2.0, 80.0, 400)


def records():
    omega, damping = 2 * np.pi * np.array([12.0, 45.0]), np.array([0.03, 0.02])
    s = 2j * np.pi * AXIS[:, None]
    modes = 1 / (omega**2 + s**2 + 2 * damping * omega * s)  # line by mode
    value = np.einsum("rm,m,lm->rl", SHAPE, SHAPE[0], modes)  # struck at the first point
    places = np.array([[point, 3] for point in (1, 2, 3)])
    struck = np.tile([1, 3], (3, 1))
    ones = np.ones(3, dtype=int)
    return FrfRecords(AXIS, value, None, ones, ones, places, struck, "receptance")


def test_shapes_are_those_the_frfs_were_made_of():
    (found,) = fitted_shapes(fit(records(), per="posture"))
    assert found.responses == ((1, 3), (2, 3), (3, 3))
    np.testing.assert_allclose(found.frequency, [12.0, 45.0], rtol=1e-6)  # noise-free data, exact model
    expected = SHAPE / SHAPE[np.argmax(np.abs(SHAPE), axis=0), [0, 1]]
    np.testing.assert_allclose(found.shape, expected, atol=1e-5)
    figure = draw_shapes(found, {1: "tip", 2: "$wrist$", 3: "_elbow"})
    assert len(figure.axes) == 1


def test_one_point_has_no_shape():
    assert fitted_shapes(fit(records().take(np.array([0])), per="posture")) == ()
