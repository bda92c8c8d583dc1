"""A law-free look as the object `law_free` of `diagnosis.json`."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from flexmodal.diagnosis.lawfree.result import Class, Curve, Findings, Found, PlaceTried


def look_json(look: Findings) -> dict[str, Any]:
    """Plain numbers; what is not finite is None."""
    return {
        "says": look.says,
        "misfit_alone": _finite(look.alone),
        "needed": look.needed,
        "explains": look.explains,
        "places": [_place(one) for one in look.places],
        "misfit_left": _finite(look.left),
        "found": [_found(one, look) for one in look.found],
    }


def _found(one: Found, look: Findings) -> dict[str, Any]:
    return {
        "port": one.port,
        "where": one.where,
        "misfit_without": _finite(one.without),
        "alike": [list(key) for key in one.alike],
        "curve": None if one.curve is None else _curve(one.curve),
        "classes": [_class(each) for each in one.classes],
        "loss": None
        if one.loss is None
        else {"share": _finite(one.loss.share), "weaker": _finite(one.loss.weaker)},
        "tells": one.tells if look.explains else None,
    }


def _place(one: PlaceTried) -> dict[str, Any]:
    return {
        "port": one.port,
        "where": one.where,
        "misfit": _finite(one.misfit),
        "held_out": None if one.held_out is None else _finite(one.held_out),
        "unknowns": one.unknowns,
    }


def _curve(curve: Curve) -> dict[str, Any]:
    functions = [
        {"name": name, "real": _list(value.real), "imaginary": _list(value.imag), "deviation": _list(spread)}
        for name, value, spread in zip(curve.names, curve.value, curve.deviation, strict=True)
    ]
    return {"frequency": _list(curve.frequency), "unit": curve.unit, "functions": functions}


def _class(one: Class) -> dict[str, Any]:
    return {"class": one.name, "says": one.says, "misfit": _finite(one.misfit), "share": _finite(one.share)}


def _list(values: np.ndarray) -> list[float | None]:
    return [_finite(float(value)) for value in values]


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
