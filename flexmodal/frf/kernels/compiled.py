"""Kernels made, compiled and kept on disk.

numba keeps a compiled function beside the file it comes from. A generated kernel comes from none, so it is
given this file's name, and its own name carries a digest of its source: another source is another entry.
The loops around it are an ordinary function of `flexmodal.frf.kernels.sweep`; a copy of it, under a name
of its own and with the kernel among its globals, is compiled for each kernel.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import cache
from inspect import unwrap
from types import FunctionType
from typing import Any

from flexmodal.frf.kernels import any_size, pivoted, planar, sweep
from flexmodal.frf.kernels.factor import Pairs, Shape, write_kernel

OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy", "fastmath": {"contract"}}
"""Multiply-adds may fuse; nothing may be reordered. The interpreter's lock is released."""


def compile_function(function: Callable[..., Any], **options: Any) -> Any:
    """Compile with the disk cache, or without where nothing can be written."""
    import numba

    function = unwrap(function)  # from the type checks of the tests
    try:
        return numba.njit(cache=True, **OPTIONS, **options)(function)
    except RuntimeError:  # no writable place for the cache
        return numba.njit(**OPTIONS, **options)(function)


@cache
def compiled_sweep(shape: Shape) -> Any:
    """The compiled loops over points, with the kernel of this shape inside."""
    source, _ = write_kernel(shape)
    kernel, digest = compile_source(source, "kernel")
    own = {
        **vars(sweep),
        "kernel": kernel,
        "spread": compiled_spread(),
        "room": compile_function(any_size.room),
    }
    return compile_function(renamed(sweep.sweep, f"sweep_{shape.n}_{digest}", own))


@cache
def compiled_sweep_planar(pairs: Pairs) -> Any:
    """The compiled loops over postures of a planar chain, with the elimination of its joints inside."""
    turning, digest = compile_source(planar.write_step(pairs, turning=True), "step")
    sliding, _ = compile_source(planar.write_step(pairs, turning=False), "step")
    own = {
        **vars(planar),
        "step_turning": turning,
        "step_sliding": sliding,
        "step_rigid": compile_function(planar.step_rigid),
        "spread": compiled_spread(),
    }
    return compile_function(renamed(planar.sweep_planar, f"sweep_planar_{digest}", own))


def compile_source(source: str, name: str) -> tuple[Any, str]:
    """Compile a generated function; returns it and the digest that is part of its own name."""
    digest = hashlib.sha256(source.encode()).hexdigest()[:16]
    scope: dict[str, Any] = {}
    exec(compile(source.replace(f"def {name}", f"def {name}_{digest}"), __file__, "exec"), scope)
    function = scope[f"{name}_{digest}"]
    function.__module__ = __name__
    return compile_function(function), digest


@cache
def compiled_sweep_any() -> Any:
    """The compiled loops over points with the kernel for any number of coordinates."""
    kernel = compile_together(any_size.fill, last=any_size.kernel, allocates=False)
    own = {
        **vars(sweep),
        "kernel": kernel,
        "spread": compiled_spread(),
        "room": compile_function(any_size.room),
    }
    return compile_function(renamed(sweep.sweep, "sweep_any", own))


@cache
def compiled_repair() -> Any:
    """`flexmodal.frf.kernels.pivoted.repair`, compiled."""
    return compile_together(pivoted.eliminate, last=pivoted.repair)


@cache
def compiled_spread() -> Any:
    """The compiled `spread`."""
    return compile_function(sweep.spread)


def renamed(function: Any, name: str, scope: dict[str, Any]) -> FunctionType:
    """A copy of a function under another name and with other globals."""
    function = unwrap(function)
    code = function.__code__.replace(co_name=name, co_qualname=name)
    copy = FunctionType(code, scope, name)
    copy.__module__ = function.__module__
    return copy


def compile_together(*functions: Callable[..., Any], last: Callable[..., Any], allocates: bool = True) -> Any:
    """Compile a function with those that it calls, lowest first; plain functions stay plain.

    Functions that allocate nothing do without counting references, which takes most of the time of a call
    with many arrays. Those before the last have to be of that kind.
    """
    scope: dict[str, Any] = {}
    for function in functions:
        own = {**unwrap(function).__globals__, **scope}
        inner = compile_function(renamed(function, function.__name__, own), **_uncounted(), **_inside())
        scope[function.__name__] = inner
    own = {**unwrap(last).__globals__, **scope}
    return compile_function(renamed(last, last.__name__, own), **({} if allocates else _uncounted()))


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
