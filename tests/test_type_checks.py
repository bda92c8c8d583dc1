"""The checks of types and shapes that conftest.py puts on the package: there, and by sample."""

import inspect
from collections.abc import Sequence
from types import SimpleNamespace

import numpy as np
import pytest
from jaxtyping import Float, TypeCheckError

from flexmodal.cards.card import JointCard
from flexmodal.modal.mac import auto_mac


def first(x: Float[np.ndarray, " n"], y: Float[np.ndarray, " n"]) -> float:
    return x[0]


OWN = first.__code__


def made_anew():
    def third(x: Float[np.ndarray, " n"], y: Float[np.ndarray, " n"]) -> float:
        return x[0]

    return third


class Shared:
    @staticmethod
    def second(x: Float[np.ndarray, " n"], y: Float[np.ndarray, " n"]) -> float:
        return x[0]

    def few(self, most: int):
        for number in range(most):
            yield super().__format__("") and str(number)


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


@pytest.mark.parametrize("function", [first, Shared.second, made_anew()])
def test_first_calls_are_checked(function, sampling, checked):
    function = sampling.sampled(function)
    refused = [refuses(function) for _ in range(2 * sampling.FIRST)]
    assert refused == [True] * sampling.FIRST + [False] * sampling.FIRST


def test_what_is_made_anew_is_checked_as_often_as_if_it_were_not(sampling, checked):
    refused = [refuses(sampling.sampled(made_anew())) for _ in range(2 * sampling.FIRST)]
    assert refused == [True] * sampling.FIRST + [False] * sampling.FIRST


def test_a_function_that_was_checked_is_itself_again(sampling, checked):
    assert sampling.sampled(first) is first
    for _ in range(sampling.FIRST):
        assert first.__code__ is not OWN
        assert list(inspect.signature(first).parameters) == ["x", "y"]
        refuses(first)
    assert first.__code__ is OWN
    assert first(np.ones(1), y=np.ones(1)) == 1


def test_a_generator_and_one_with_super_are_checked_too(sampling):
    few = sampling.sampled(Shared.few)
    for _ in range(2 * sampling.FIRST):
        assert list(few(Shared(), 2)) == ["0", "1"]


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
