"""The examples that `help()` shows run and give what they say."""

import doctest
import importlib

import pytest

MODULES = (
    "flexmodal.frf.direction",
    "flexmodal.model.load",
    "flexmodal.model.posed",
    "flexmodal.model.robot",
    "flexmodal.optimisation.frequency.tune",
    "flexmodal.optimisation.problem",
)


@pytest.mark.parametrize("name", MODULES)
def test_examples(name):
    found = doctest.testmod(importlib.import_module(name))
    assert found.attempted > 0
    assert found.failed == 0
