"""The checks of types and shapes that conftest.py puts on the package: there, and by sample."""

from collections.abc import Sequence
from types import SimpleNamespace

import numpy as np
import pytest
from jaxtyping import Float, TypeCheckError

from flexmodal.cards.card import JointCard
from flexmodal.modal.mac import auto_mac


def first(x: Float[np.ndarray, " n"], y: Float[np.ndarray, " n"]) -> float:
    return x[0]


def total(x: Sequence[float]) -> float:
    return sum(x)


@pytest.fixture
def sampling(pytestconfig):
    return next(
        module
        for module in pytestconfig.pluginmanager.get_plugins()
        if getattr(module, "__file__", None) and hasattr(module, "sampled")
    )


@pytest.mark.usefixtures("checked")
def test_a_wrong_shape_is_refused():
    with pytest.raises(TypeCheckError, match="auto_mac"):
        auto_mac(np.ones(3))


@pytest.mark.usefixtures("checked")
def test_a_dataclass_is_checked():
    with pytest.raises(TypeCheckError, match="JointCard"):
        JointCard(stiffness="soft", damping=1.0)


def test_first_calls_and_one_of_many_are_checked(sampling, checked):
    function = sampling.sampled(first)
    refused = []
    for call in range(1, 2 * sampling.THEN + 1):
        try:
            function(np.ones(2), np.ones(3))
        except TypeCheckError:
            refused.append(call)
    assert refused == [*range(1, sampling.FIRST + 1), sampling.THEN, 2 * sampling.THEN]


def test_an_int_is_a_float_too(sampling):
    assert sampling.sampled(total)([0, 1]) == 1
    with pytest.raises(TypeCheckError):
        sampling.sampled(total)(["0", "1"])


def refuses(function):
    try:
        function(np.ones(2), np.ones(3))
    except TypeCheckError:
        return True
    return False


def called_often(sampling):
    function = sampling.sampled(first)
    for _ in range(sampling.FIRST + 1):
        refuses(function)
    assert not refuses(function)
    return function


def test_each_module_begins_anew(sampling, request):
    function = called_often(sampling)
    sampling.pytest_runtest_setup(request.node)
    assert not refuses(function)
    sampling.pytest_runtest_setup(SimpleNamespace(path=request.node.path.with_name("test_another.py")))
    assert refuses(function)


@pytest.mark.parametrize("time", [1, 2])
def test_a_test_that_asks_for_it_begins_anew(time, sampling, checked):
    assert refuses(sampling.sampled(first))
    called_often(sampling)
