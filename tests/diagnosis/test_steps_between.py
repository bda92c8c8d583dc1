"""The models between the re-tuned robot and the last one, of those that were compared."""

from dataclasses import replace

import numpy as np
import pytest

from flexmodal.diagnosis.names import NONE, UNSTRUCTURED
from flexmodal.diagnosis.result import steps_between
from flexmodal.diagnosis.selection.frf_comparison import fitted_model

KEY, OTHER = ("link_flexibility", "link_2"), ("added_mass", "link_3")


@pytest.fixture(scope="module")
def fitted(hinged, observed):
    """The robot re-tuned, with the hinge, and that with a mode of no structure besides."""
    root, before, hypothesis, after = hinged
    models = [fitted_model(root, before, observed), fitted_model(hypothesis, after, observed)]
    vague = replace(models[1], key=(UNSTRUCTURED, ""), predicted=2 * models[1].predicted)
    return [*models, vague]


def test_the_first_effect_alone_is_the_first_step(fitted):
    assert [one.key[0] for one in fitted] == [NONE, KEY[0], UNSTRUCTURED]
    found = steps_between(fitted, [KEY, OTHER])
    assert list(found) == ["step 1"]
    assert np.array_equal(found["step 1"], fitted[1].predicted)


def test_what_was_never_fitted_alone_is_left_out(fitted):
    assert steps_between(fitted, [OTHER, KEY]) == {}
    assert steps_between(fitted, [KEY]) == {}  # the last is none between
    assert steps_between([object()], [KEY, OTHER]) == {}
