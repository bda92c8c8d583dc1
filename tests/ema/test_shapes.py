"""Shapes from residues that share a hammer position or a sensor, against those the FRFs were made of."""

import numpy as np
import pytest

from flexmodal.campaign import FrfRecords
from flexmodal.ema import Choices, fit
from flexmodal.ema.plot_shapes import draw_mac, draw_shapes
from flexmodal.ema.shapes import fitted_shapes

SHAPE = np.array([[1.0, 0.4], [0.6, -1.0], [0.2, -0.5]])  # point by mode, largest 1 in size
AXIS = np.linspace(2.0, 80.0, 400)


def records(pairs, shape=SHAPE, posture=None):
    """FRFs of pairs (response, reference) of point numbers."""
    omega, damping = 2 * np.pi * np.array([12.0, 45.0]), np.array([0.03, 0.02])
    s = 2j * np.pi * AXIS[:, None]
    modes = 1 / (omega**2 + s**2 + 2 * damping * omega * s)  # line by mode
    response, reference = np.array(pairs).T
    value = np.einsum("rm,rm,lm->rl", shape[response - 1], shape[reference - 1], modes)
    three = np.full(len(pairs), 3)
    ones = np.ones(len(pairs), dtype=int)
    return FrfRecords(
        AXIS, value, None, ones if posture is None else np.array(posture), ones,
        np.stack([response, three], axis=1), np.stack([reference, three], axis=1), "receptance",
    )  # fmt: skip


ROVING_SENSOR, ROVING_HAMMER = [(1, 1), (2, 1), (3, 1)], [(1, 1), (1, 2), (1, 3)]
EXPECTED = SHAPE / SHAPE[np.argmax(np.abs(SHAPE), axis=0), [0, 1]]


@pytest.mark.parametrize(("pairs", "side"), [(ROVING_SENSOR, "reference"), (ROVING_HAMMER, "response")])
@pytest.mark.parametrize("per", ["posture", "frf"])
def test_shapes_are_those_the_frfs_were_made_of(pairs, side, per):
    (found,) = fitted_shapes(fit(records(pairs), per=per, choices=Choices(vary=False)))
    assert (found.side, found.fixed) == (side, (1, 3))
    assert found.places == ((1, 3), (2, 3), (3, 3))
    np.testing.assert_allclose(found.frequency, [12.0, 45.0], rtol=1e-6)  # noise-free data, exact model
    np.testing.assert_allclose(found.shape, EXPECTED, atol=1e-5)
    figure = draw_shapes(found, {1: "tip", 2: "$wrist$", 3: "_elbow"})
    assert len(figure.axes) == 1


def test_each_posture_is_grouped_by_the_side_that_stayed_in_it():
    pairs = ROVING_SENSOR + ROVING_HAMMER
    both = records(pairs, posture=[1, 1, 1, 2, 2, 2])
    found = fitted_shapes(fit(both, per="posture", choices=Choices(vary=False)))
    assert [(one.posture, one.side) for one in found] == [(1, "reference"), (2, "response")]
    for one in found:
        np.testing.assert_allclose(one.shape, EXPECTED, atol=1e-5)


def test_a_whole_matrix_gives_a_shape_for_each_hammer_position():
    pairs = [(response, reference) for reference in (1, 2) for response in (1, 2)]
    found = fitted_shapes(fit(records(pairs), per="posture", choices=Choices(vary=False)))
    assert [(one.side, one.fixed) for one in found] == [("reference", (1, 3)), ("reference", (2, 3))]


def test_a_mode_keeps_its_number_where_an_frf_does_not_show_the_one_before_it():
    """Point 2 is a node of the first mode: its only mode is still the second of the others."""
    shape = np.array([[1.0, 0.4], [0.0, -1.0], [0.2, -0.5]])
    fits = fit(records(ROVING_SENSOR, shape), choices=Choices(at=[12.0, 45.0], vary=False))
    for one in fits:
        for row in one.rows():
            assert row["frequency"] == pytest.approx([12.0, 45.0][row["mode"] - 1], rel=1e-3)
    (found,) = fitted_shapes(fits)
    assert found.frequency == pytest.approx((45.0,), rel=1e-6)
    np.testing.assert_allclose(found.shape[:, 0], [-0.4, 1.0, 0.5], atol=1e-4)


def test_one_point_has_no_shape():
    assert fitted_shapes(fit(records(ROVING_SENSOR).take(np.array([0])), per="posture")) == ()


@pytest.mark.parametrize("count", [1, 2, 4, 12])
def test_the_heading_of_a_mac_matrix_stays_on_the_picture(count):
    title = "MAC: Posture 1, shoulder raised against Posture 2, elbow bent, hammer at location_1 +z"
    figure = draw_mac(np.eye(count), title=title)
    figure.canvas.draw()
    (heading,) = figure.texts
    extent = heading.get_window_extent()
    assert extent.x0 >= 0
    assert extent.x1 <= figure.bbox.width
    assert heading.get_text().replace("\n", " ") == title
