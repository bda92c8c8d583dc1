"""Things tried side by side, by copies of this process."""

import multiprocessing
import os
import signal
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial

import pytest

from flexmodal.cli.diagnose import diagnose
from flexmodal.diagnosis.parallel import parallel_map as module
from flexmodal.diagnosis.parallel import workers
from flexmodal.diagnosis.parallel.parallel_map import parallel_map
from flexmodal.diagnosis.parallel.workers import ENOUGH, MOST, VARIABLE, free_cores, is_helper, working_on
from flexmodal.diagnosis.time_limit import OutOfTime, TimeLimit
from flexmodal.errors import FlexmodalError, InvalidRequest
from flexmodal.frf.kernels import worth

copies = pytest.mark.skipif(sys.platform != "linux", reason="processes are copied on Linux only")


KINDS = ("on disk", "not on disk")


@dataclass(frozen=True, eq=False)
class Arm:
    """Of the package as far as that is asked; compared by identity."""

    name: str

    __module__ = "flexmodal.here"


@dataclass(frozen=True, eq=False)
class Look:
    """At an arm."""

    arm: Arm
    tried: Callable[[int], object] | None = None

    __module__ = "flexmodal.here"

    def at(self, number: int) -> tuple[Arm, int]:
        return self.arm, number


def slowly(number: int) -> tuple[int, int]:
    time.sleep(0.05 if number % 3 else 0.15)
    return number, os.getpid()


@copies
def test_results_come_in_order_from_several_processes():
    with working_on(3):
        found = list(parallel_map(slowly, range(12)))
    assert [number for number, _ in found] == list(range(12))
    processes = {process for _, process in found}
    assert os.getpid() in processes
    assert len(processes) == 3


def test_one_worker_is_a_map():
    with working_on(1):
        found = list(parallel_map(slowly, range(2)))
    assert [process for _, process in found] == [os.getpid()] * 2
    assert [process for _, process in parallel_map(slowly, range(2))] == [os.getpid()] * 2


def test_other_systems_do_everything_here(monkeypatch):
    monkeypatch.setattr(module.sys, "platform", "win32")
    with working_on(4):
        assert [process for _, process in parallel_map(slowly, range(3))] == [os.getpid()] * 3


def closed_over(look: Look) -> Callable[[int], object]:
    def at(number):
        return look.at(number)

    return at


@copies
@pytest.mark.parametrize("of", [lambda look: look.at, lambda look: partial(Look.at, look), closed_over])
def test_what_was_there_before_is_the_same_object_afterwards(of):
    look = Look(Arm("here"))
    others = [Arm("given"), Arm("given"), Arm("given")]
    with working_on(2):
        found = list(parallel_map(of(look), range(4)))
        back = list(parallel_map(lambda one: (slowly(1), one), others))
        made = list(parallel_map(lambda number: (slowly(1), [str(number)] * 2), range(4)))
    assert all(arm is look.arm for arm, _ in found)
    assert [one for _, one in back] == others
    assert made[3][1] == ["3", "3"]


@dataclass(frozen=True, eq=False)
class Solved:
    """With something that follows from its fields."""

    number: int

    @cached_property
    def twice(self) -> Callable[[], int]:
        return lambda: 2 * self.number


@copies
def test_what_follows_from_fields_is_not_sent():
    """Here it could not be."""

    def made(number):
        one = Solved(number)
        time.sleep(0.05)
        return one, one.twice() == 2 * number, os.getpid()

    with working_on(2):
        found = list(parallel_map(made, range(4)))
    assert [one.number for one, right, _ in found if right] == [0, 1, 2, 3]
    assert {"twice" in vars(one) for one, *_ in found} == {False, True}
    assert [one.twice() for one, *_ in found] == [0, 2, 4, 6]
    assert len({process for *_, process in found}) == 2


@copies
def test_what_fails_is_raised_when_its_turn_comes():
    def fails(number):
        time.sleep(0.02)
        if number == 2:
            raise ValueError("number 2")
        return number

    with working_on(2):
        going, found = parallel_map(fails, range(6)), []
        with pytest.raises(ValueError, match="number 2"):
            found.extend(one for one in going)
        assert [next(parallel_map(fails, range(3)))] == [0]
        going, found = parallel_map(fails, range(6)), []
        found += [next(going), next(going)]
    assert found == [0, 1]


@copies
def test_who_asks_for_no_more_leaves_no_helper():
    with working_on(4):
        for _ in parallel_map(lambda number: time.sleep(0.0 if number < 4 else 1.0), range(1000)):
            break
    assert multiprocessing.active_children() == []


@copies
def test_a_helper_that_was_killed_is_told():
    here = os.getpid()

    def ends(number):
        if os.getpid() != here:
            os.kill(os.getpid(), signal.SIGKILL)
        time.sleep(0.2)

    with working_on(2), pytest.raises(FlexmodalError, match="helping process was killed"):
        list(parallel_map(ends, range(4)))


@copies
def test_what_cannot_be_sent_is_told():
    here = os.getpid()

    def made(number):
        time.sleep(0.1)
        return number if os.getpid() == here else (lambda: number)

    with working_on(2), pytest.raises(FlexmodalError, match="cannot be sent"):
        list(parallel_map(made, range(4)))


@copies
def test_helpers_have_no_helpers():
    def inside(number):
        time.sleep(0.1)
        return os.getpid(), is_helper(), free_cores(), list(parallel_map(slowly, [1, 2]))

    with working_on(2):
        assert free_cores() == 2
        found = list(parallel_map(inside, range(4)))
    assert {helps for _, helps, *_ in found} == {False, True}
    for process, _, cores, nested in found:
        assert cores == 1
        assert [one for _, one in nested] == [process] * 2
    assert not is_helper()


@copies
def test_compiled_code_is_worth_its_start_in_helpers_too_and_their_work_counts_here(monkeypatch):
    """A helper that went on without it had taken 54 s for what takes 7 with it."""
    monkeypatch.setattr(worth, "_spent", type(worth._spent)(float))
    monkeypatch.setattr(worth, "_stored", {})

    def inside(number):
        time.sleep(0.1)
        helps = is_helper()
        return helps, helps and [
            worth.is_worth_it(kind, 1.0, 1e9, lambda kind=kind: kind == "on disk") for kind in KINDS
        ]

    with working_on(2):
        found = list(parallel_map(inside, range(6)))
    bought = [some for helps, some in found if helps]
    assert bought
    assert [on_disk for on_disk, _ in bought] == [True] * len(bought)
    assert not any(other for _, other in bought)
    assert worth.spent() == dict.fromkeys(KINDS, 1.0 * len(bought))


@copies
def test_a_large_result_does_not_stop_a_helper():
    """Ten times what a pipe holds."""

    def made(number):
        return bytes(1 << 20), os.getpid(), time.sleep(0.05)

    with working_on(2):
        found = list(parallel_map(made, range(6)))
    assert all(len(some) == 1 << 20 for some, *_ in found)
    assert len({process for _, process, _ in found}) == 2


@copies
@pytest.mark.parametrize("asks_in_helper", [False, True])
def test_time_that_is_up_ends_what_helpers_do_and_progress_is_told_here_alone(asks_in_helper):
    here, told, limit, helps = os.getpid(), [], TimeLimit(0.5), multiprocessing.Event()
    advance = limit.watching(lambda doing, part: told.append(os.getpid()))

    def asks(number):
        if os.getpid() == here:
            helps.wait(30)  # however busy the machine is, or nothing would be left to help with
        helps.set()
        for _ in range(600 if os.getpid() != here else 4):
            time.sleep(0.05)
            if asks_in_helper:
                advance("here", 0.0)

    with working_on(2, limit.check), pytest.raises(OutOfTime), limit.counting():
        list(parallel_map(asks, range(2)))
    assert limit.was_hit
    assert set(told) <= {here}
    assert multiprocessing.active_children() == []


def test_how_many_there_are_where_nobody_says(monkeypatch):
    monkeypatch.delenv(VARIABLE, raising=False)
    monkeypatch.setattr(workers, "available_cores", lambda: 64)
    with working_on(None):
        assert free_cores() == ENOUGH
    monkeypatch.setenv(VARIABLE, " 3 ")
    with working_on(None):
        assert free_cores() == 3
        with working_on(2):
            assert free_cores() == 2
    for text in ("0", "many", "-1", "1.5", str(MOST + 1)):
        monkeypatch.setenv(VARIABLE, text)
        with pytest.raises(InvalidRequest, match=rf"{VARIABLE}.*{text}.*1 to {MOST}"), working_on(None):
            pass
    for number in (0, -3, MOST + 1):
        with pytest.raises(InvalidRequest, match=f"workers.*{number}.*1 to {MOST}"), working_on(number):
            pass


def test_the_command_allows_as_many():
    (option,) = (one for one in diagnose.params if one.name == "workers")
    assert (option.type.min, option.type.max) == (1, MOST)
