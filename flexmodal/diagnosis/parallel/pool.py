"""This process and copies of it at work on some things."""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import threading
import warnings
from collections.abc import Callable, Hashable, Mapping, Sequence
from multiprocessing.connection import Connection, wait
from typing import Any, Generic, TypeVar

from flexmodal.diagnosis.parallel.by_reference import held_by, received, sent
from flexmodal.diagnosis.parallel.workers import become_helper, check, one_of_several
from flexmodal.errors import FlexmodalError
from flexmodal.frf.kernels import worth

Item = TypeVar("Item")
Result = TypeVar("Result")

TOKENS = 8192
"""Things at most: so many of their numbers fit into a pipe."""
_TOKEN = 4
"""Bytes of a number."""
_ASK = 0.2
"""How often it is asked whether to wait for helpers any longer [s]."""


class _Raised:
    """What was raised instead of a result."""

    def __init__(self, error: BaseException) -> None:
        self.error = error


def _since(begun: Mapping[Hashable, float]) -> dict[Hashable, float]:
    """Seconds worked without compiled code, by kind of work, since they were so many."""
    now = worth.spent()
    return {kind: now[kind] - begun.get(kind, 0.0) for kind in now if now[kind] != begun.get(kind)}


class Pool(Generic[Item, Result]):
    """This process and its helpers at work on some things; whoever is free takes the next one."""

    def __init__(self, call: Callable[[Item], Result], items: Sequence[Item]) -> None:
        """Nobody works yet.

        Args:
            call: see `parallel_map`.
            items: the things, `TOKENS` at most.
        """
        self._call, self._items = call, items
        self._known = held_by(call, items)
        self._done: dict[int, Any] = {}
        self._helpers: dict[Connection, Any] = {}
        self._tokens, given = os.pipe()
        with os.fdopen(given, "wb") as pipe:  # closed: who reads it empty is told so
            pipe.write(b"".join(k.to_bytes(_TOKEN, "little") for k in range(len(items))))

    def start(self, number: int) -> None:
        """Copy this process.

        Args:
            number: how many times.
        """
        context = multiprocessing.get_context("fork")
        for _ in range(number):
            here, there = context.Pipe(duplex=False)
            readers = [*self._helpers, here]
            process = context.Process(target=self._help, args=(there, readers), daemon=True)
            with warnings.catch_warnings():  # of threads, which the copy does without
                warnings.simplefilter("ignore", DeprecationWarning)
                process.start()
            there.close()
            self._helpers[here] = process

    def result(self, turn: int) -> Result:
        """What was made of a thing; others are worked on here until it is there.

        Args:
            turn: its number.

        Raises:
            FlexmodalError: a helper was killed; and whatever was raised instead of a result.
        """
        while turn not in self._done:
            number = self._next()
            if number is not None:
                self._done[number] = self._made(number)
            self._receive(wait_for_some=number is None)
        found = self._done.pop(turn)
        if isinstance(found, _Raised):
            check()  # of time that was up in a helper this process is to know itself
            raise found.error
        return found

    def end(self) -> None:
        """No helper is left."""
        for process in self._helpers.values():
            process.kill()
        for pipe, process in self._helpers.items():
            process.join()
            process.close()
            pipe.close()
        os.close(self._tokens)

    def _next(self) -> int | None:
        """The number of a thing that nobody works on yet."""
        token = os.read(self._tokens, _TOKEN)
        return int.from_bytes(token, "little") if token else None

    def _made(self, number: int) -> Any:
        with one_of_several():
            try:
                return self._call(self._items[number])
            except Exception as error:
                return _Raised(error)

    def _receive(self, *, wait_for_some: bool) -> None:
        """What helpers have sent by now."""
        if wait_for_some:
            while not wait(list(self._helpers), _ASK):
                check()
        for pipe in wait(list(self._helpers), 0):
            assert isinstance(pipe, Connection)
            try:
                told = pipe.recv_bytes()
            except EOFError:
                raise FlexmodalError("a helping process was killed, perhaps for want of memory") from None
            number, made, spent = received(told, self._known)
            worth.count(spent)
            if number is None:
                self._helpers.pop(pipe).join()
                pipe.close()
            else:
                self._done[number] = made

    def _help(self, pipe: Connection, readers: Sequence[Connection]) -> None:
        """Work on things until none is left, and send what comes of each while the next is worked on.

        How long that took without compiled code is sent along, so that this is worth its start some time in
        the process that was copied, and so in copies to come.
        """
        # An interruption ends the process that was copied, and that ends this one.
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        for reader in readers:  # so that nothing is sent to nobody
            reader.close()
        become_helper()
        begun = worth.spent()
        sending: threading.Thread | None = None
        number: int | None = -1
        while number is not None:
            number = self._next()
            made = None if number is None else self._made(number)
            told, begun = self._told(number, made, _since(begun)), worth.spent()
            if sending is not None:
                sending.join()
            sending = threading.Thread(target=pipe.send_bytes, args=(told,))
            sending.start()
        if sending is not None:
            sending.join()

    def _told(self, number: int | None, made: Any, spent: Mapping[Hashable, float]) -> bytes:
        """A result as bytes; in its stead why it cannot be told."""
        try:
            return sent((number, made, spent), self._known)
        except (pickle.PicklingError, TypeError, AttributeError) as error:
            return sent((number, _Raised(FlexmodalError(f"cannot be sent: {error}")), {}), self._known)
