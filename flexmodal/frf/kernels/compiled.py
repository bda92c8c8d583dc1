"""Kernels made, compiled and kept on disk.

numba keeps a compiled function beside the file it comes from and looks only at that file to tell whether it
is still good. But a function has those it calls inside it, and a generated one comes from no file. So each
gets a name with a digest of its own code and of the names of all that is compiled into it: whatever changes
anywhere makes another entry. Only what is called from Python is kept; what it calls is inside it.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache, cached_property
from inspect import unwrap
from pathlib import Path
from types import FunctionType
from typing import Any

from flexmodal.frf.kernels import any_size, pivoted, recursion, sweep
from flexmodal.frf.kernels.announced import announce
from flexmodal.frf.kernels.factor import Pairs, Shape, write_kernel
from flexmodal.frf.kernels.recursion import KINDS, Algebra, write_step

OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy", "fastmath": {"contract"}}
"""Multiply-adds may fuse; nothing may be reordered. The interpreter's lock is released."""

COMPILATION = 4.0
"""Seconds to compile the loops over points [s]; 2.5 to 5 measured."""

UNCOUNTED, MERGED, INSIDE = "_nrt", "forceinline", "no_cpython_wrapper"
"""Flags of numba, where it has them: no reference counting, which takes most of the time of a call with many
arrays; the code put in the place of each call, of use where many small functions pass many arrays on, at the
price of a longer compilation; no door to Python, which takes time to compile."""

_INNER = (INSIDE, UNCOUNTED)


@dataclass(frozen=True, eq=False)
class Kernel:
    """A function to be compiled, with those that are compiled into it."""

    function: Callable[..., Any]
    calls: Mapping[str, Kernel] = field(default_factory=dict)
    """By the names under which it calls them."""
    flags: tuple[str, ...] = ()
    purpose: str = ""
    """What it works out, in words, for those who wait while it is compiled."""
    seconds: float = 0.0
    """That its compilation takes, where that was measured [s]."""

    @cached_property
    def plain(self) -> Any:
        """The function itself, without the type checks of the tests."""
        return unwrap(self.function)

    @cached_property
    def name(self) -> str:
        """Its name, with a digest of its code and file, of the constants it reads, and of what it calls."""
        code, scope = self.plain.__code__, self.plain.__globals__
        parts = [
            _text(code.co_filename),
            code.co_code.hex(),
            repr(code.co_consts),
            repr(code.co_varnames),
            repr(self.flags),
        ]
        for name in code.co_names:
            value = scope.get(name)
            if name in self.calls:
                parts.append(f"{name}={self.calls[name].name}")
            elif isinstance(value, bool | int | float | str | tuple):
                parts.append(f"{name}={value!r}")
        digest = hashlib.sha256("\n".join(parts).encode()).hexdigest()[:16]
        return f"{self.plain.__name__}_{digest}"

    def is_stored(self) -> bool:
        """Whether numba has it on disk, for the source as it is; looked up without loading numba.

        The name says what the source is; when its file was written says nothing, nor does numba go by that.
        """
        source = Path(self.plain.__code__.co_filename)
        pattern, chosen = f"*.{self.name}-*.nbi", os.environ.get("NUMBA_CACHE_DIR")
        user = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "numba"
        try:
            inside = user.glob("*/") if not chosen else Path(chosen).glob("*/")
            folders = inside if chosen else [source.parent / "__pycache__", *inside]
            return any(True for folder in folders for _ in folder.glob(pattern))
        except OSError:  # a folder that may not be read, or a file that another process has just replaced
            return False

    @cached_property
    def compiled(self) -> Any:
        """The compiled function; numba compiles it, or takes it from disk, when it is called first."""
        import numba
        from numba.core.options import DefaultOptions

        own = {**self.plain.__globals__, **{name: inner.compiled for name, inner in self.calls.items()}}
        code = self.plain.__code__.replace(co_name=self.name, co_qualname=self.name)
        copy = FunctionType(code, own, self.name)
        copy.__module__ = self.plain.__module__
        known = {flag: flag != UNCOUNTED for flag in self.flags if hasattr(DefaultOptions, flag)}
        options = OPTIONS | known | ({"no_cfunc_wrapper": True} if INSIDE in known else {})
        if INSIDE in self.flags:
            return numba.njit(**options)(copy)
        try:
            made, kept = numba.njit(cache=True, **options)(copy), True
        except RuntimeError:  # no writable place on disk
            made, kept = numba.njit(**options)(copy), False
        announce(self.name, self.purpose, self.seconds, kept=kept)
        return made


@cache
def _text(file: str) -> str:
    """What a file of code says; nothing where the code is of no file."""
    try:
        return Path(file).read_text(encoding="utf-8")
    except OSError:
        return ""


def together(
    *functions: Callable[..., Any],
    last: Callable[..., Any],
    purpose: str,
    seconds: float = 0.0,
    allocates: bool = True,
    merged: bool = False,
) -> Kernel:
    """A function with those that it calls, lowest first.

    Args:
        functions: those that it calls, or that they call; they allocate nothing.
        last: the one to be called.
        purpose: what it works out, in words.
        seconds: that its compilation takes, where that was measured [s].
        allocates: whether it allocates anything; its references are counted then.
        merged: put the code of the others in the place of each call.
    """
    calls: dict[str, Kernel] = {}
    flags = (*_INNER, MERGED) if merged else _INNER
    for function in functions:
        calls[function.__name__] = Kernel(function, _called(function, calls), flags)
    return Kernel(last, _called(last, calls), () if allocates else (UNCOUNTED,), purpose, seconds)


def _called(function: Callable[..., Any], known: Mapping[str, Kernel]) -> dict[str, Kernel]:
    """Those of the kernels known so far that a function calls."""
    names = unwrap(function).__code__.co_names
    return {name: known[name] for name in names if name in known}


def from_source(source: str, name: str) -> Kernel:
    """A generated function, for others to call.

    Args:
        source: its code.
        name: of the function in it.
    """
    scope: dict[str, Any] = {}
    exec(compile(source, __file__, "exec"), scope)
    function = scope[name]
    function.__module__ = __name__
    return Kernel(function, flags=(INSIDE,))


@cache
def sweep_of(shape: Shape) -> Kernel:
    """The loops over points, with the kernel of this shape inside."""
    kernel = from_source(write_kernel(shape)[0], "kernel")
    return _sweep(sweep.sweep, {**_around_tiles(), "kernel": kernel})


@cache
def sweep_of_any_size() -> Kernel:
    """The loops over points with the kernel for any number of coordinates."""
    inner = {part.__name__: Kernel(part, flags=_INNER) for part in (any_size.fill, any_size.add_products)}
    kernel = Kernel(any_size.kernel, inner, _INNER)
    return _sweep(sweep.sweep, {**_around_tiles(), "kernel": kernel})


@cache
def sweep_along(algebra: Algebra, pairs: Pairs, kinds: frozenset[str]) -> Kernel:
    """The loops over postures of a chain, with the elimination of its kinds of joints inside.

    Args:
        algebra: of the plane or of space.
        pairs: of rows that make a receptance.
        kinds: of joints that occur.
    """
    steps = {kind: from_source(write_step(algebra, pairs, kind), "step") for kind in KINDS if kind in kinds}
    never = next(iter(steps.values()))
    scope = {f"step_{kind}": steps.get(kind, never) for kind in KINDS}
    return _sweep(recursion.sweep_along, {**scope, "spread": _around_tiles()["spread"]})


@cache
def repair() -> Kernel:
    """`flexmodal.frf.kernels.pivoted.repair`."""
    return together(pivoted.eliminate, last=pivoted.repair, purpose="receptances with pivoting")


def _sweep(function: Callable[..., Any], calls: Mapping[str, Kernel]) -> Kernel:
    return Kernel(function, calls, purpose="receptances", seconds=COMPILATION)


@cache
def _around_tiles() -> dict[str, Kernel]:
    return {
        function.__name__: Kernel(function, flags=(INSIDE,)) for function in (sweep.spread, any_size.room)
    }
