"""Kernels made, compiled and kept on disk.

numba keeps a compiled function beside the file it comes from and looks only at that file to tell whether it
is still good. But a function has those it calls inside it, and a generated one comes from no file. So each
gets a name with a digest of its own code and of the names of all that is compiled into it: whatever changes
anywhere makes another entry.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from functools import cache
from inspect import unwrap
from types import CodeType, FunctionType
from typing import Any

from flexmodal.frf.kernels import any_size, pivoted, recursion, sweep
from flexmodal.frf.kernels.factor import Pairs, Shape, write_kernel
from flexmodal.frf.kernels.recursion import KINDS, Algebra, write_step

OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy", "fastmath": {"contract"}}
"""Multiply-adds may fuse; nothing may be reordered. The interpreter's lock is released."""


@cache
def compiled_sweep(shape: Shape) -> Any:
    """The compiled loops over points, with the kernel of this shape inside."""
    kernel = compile_source(write_kernel(shape)[0], "kernel")
    return compile_with(sweep.sweep, {**_around_tiles(), "kernel": kernel})


@cache
def compiled_sweep_any() -> Any:
    """The compiled loops over points with the kernel for any number of coordinates."""
    kernel = compile_together(any_size.fill, last=any_size.kernel, allocates=False)
    return compile_with(sweep.sweep, {**_around_tiles(), "kernel": kernel})


@cache
def compiled_sweep_along(algebra: Algebra, pairs: Pairs, kinds: frozenset[str]) -> Any:
    """The compiled loops over postures of a chain, with the elimination of its kinds of joints inside."""
    steps = {
        kind: compile_source(write_step(algebra, pairs, kind), "step") for kind in KINDS if kind in kinds
    }
    never = next(iter(steps.values()))
    scope = {f"step_{kind}": steps.get(kind, never) for kind in KINDS}
    return compile_with(recursion.sweep_along, {**scope, "spread": _around_tiles()["spread"]})


@cache
def compiled_repair() -> Any:
    """`flexmodal.frf.kernels.pivoted.repair`, compiled."""
    return compile_together(pivoted.eliminate, last=pivoted.repair)


@cache
def _around_tiles() -> dict[str, Any]:
    return {"spread": compile_with(sweep.spread), "room": compile_with(any_size.room)}


def compile_together(
    *functions: Callable[..., Any], last: Callable[..., Any], allocates: bool = True, merged: bool = False
) -> Any:
    """Compile a function with those that it calls, lowest first; plain functions stay plain.

    Functions that allocate nothing do without counting references, which takes most of the time of a call
    with many arrays. Those before the last have to be of that kind. `merged` puts their code in the place of
    each call: of use where many small ones pass many arrays on, at the price of a longer compilation.
    """
    scope: dict[str, Any] = {}
    inner = {**_uncounted(), **_inside(), **(_merged() if merged else {})}
    for function in functions:
        scope[function.__name__] = compile_with(function, scope, **inner)
    return compile_with(last, scope, **({} if allocates else _uncounted()))


def compile_source(source: str, name: str) -> Any:
    """Compile a generated function."""
    scope: dict[str, Any] = {}
    exec(compile(source, __file__, "exec"), scope)
    function = scope[name]
    function.__module__ = __name__
    return compile_with(function)


def compile_with(function: Callable[..., Any], scope: Mapping[str, Any] | None = None, **options: Any) -> Any:
    """Compile a copy of a function that finds compiled functions among its globals."""
    function = unwrap(function)  # from the type checks of the tests
    own = {**function.__globals__, **(scope or {})}
    name = f"{function.__name__}_{_digest(function.__code__, own, options)}"
    code = function.__code__.replace(co_name=name, co_qualname=name)
    copy = FunctionType(code, own, name)
    copy.__module__ = function.__module__
    return _compile(copy, options)


def _compile(function: FunctionType, options: Mapping[str, Any]) -> Any:
    """With the disk cache, or without where nothing can be written."""
    import numba

    try:
        return numba.njit(cache=True, **OPTIONS, **options)(function)
    except RuntimeError:  # no writable place for the cache
        return numba.njit(**OPTIONS, **options)(function)


def _digest(code: CodeType, scope: Mapping[str, Any], options: Mapping[str, Any]) -> str:
    """Of a function's code, of the constants it reads, and of the functions that it calls."""
    parts: list[str] = [code.co_code.hex(), repr(code.co_consts), repr(code.co_varnames)]
    parts.append(repr(sorted(options.items())))
    for name in code.co_names:
        value = scope.get(name)
        if isinstance(value, bool | int | float | str | tuple):
            parts.append(f"{name}={value!r}")
        elif value is not None and hasattr(value, "py_func"):
            parts.append(f"{name}={value.py_func.__name__}")
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()[:16]


@cache
def _inside() -> dict[str, Any]:
    """Options of functions that only compiled ones call: a door to Python takes time to compile."""
    from numba.core.options import DefaultOptions

    doors = ("no_cpython_wrapper", "no_cfunc_wrapper")
    return {door: True for door in doors if hasattr(DefaultOptions, door)}


@cache
def _uncounted() -> dict[str, Any]:
    """The option that turns reference counting off, where this numba has it."""
    from numba.core.options import DefaultOptions

    return {"_nrt": False} if hasattr(DefaultOptions, "_nrt") else {}


@cache
def _merged() -> dict[str, Any]:
    """The option that puts a function's code in the place of each call, where this numba has it."""
    from numba.core.options import DefaultOptions

    return {"forceinline": True} if hasattr(DefaultOptions, "forceinline") else {}
