"""What an atlas has near a posture, or between the postures about it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmodal.atlas.atlas import Atlas
from flexmodal.errors import Fault, FlexmodalError, InvalidRequest
from flexmodal.text.words import strange

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True, eq=False)
class Spot:
    """One posture of an atlas."""

    posture: dict[str, float]
    """Of every commanded joint [rad, m]."""
    tool: tuple[float, float, float]
    """Position of the end-effector [m]."""
    value: float
    """By the task that it was looked for; not a number where there was none."""
    distance: float = 0.0
    """From the posture that was asked for, in parts of the joints' ranges."""


def nearest(atlas: Atlas, posture: Mapping[str, float]) -> tuple[Spot, xarray.Dataset]:
    """The posture of the atlas that is nearest, in parts of the joints' ranges, and all it holds there.

    Args:
        atlas: to look in.
        posture: of every joint that the atlas varies [rad, m].

    Raises:
        InvalidRequest: joints that the atlas does not have, or that are left out; a value far outside.
        FlexmodalError: its chunk is not there yet, or spoilt.
    """
    wanted = _wanted(atlas, posture)
    if atlas.is_grid:
        place = {
            name: int(np.argmin(np.abs(atlas.dataset[name].values - wanted[name]))) for name in atlas.dims
        }
    else:
        place = {"posture": _nearest_of_sample(atlas, wanted)}
    found = _read(atlas, place)
    values = {name: float(found[name]) for name in atlas.joints}
    gap = np.array([(values[name] - wanted[name]) / atlas.span[name] for name in wanted])
    tool = tuple(float(one) for one in found["tool"].values)
    return Spot(values, (tool[0], tool[1], tool[2]), math.nan, float(np.linalg.norm(gap))), found


def interpolated(atlas: Atlas, posture: Mapping[str, float]) -> xarray.Dataset:
    """All that a grid holds, linearly between the postures about one.

    Args:
        atlas: to look in.
        posture: of every joint that the atlas varies [rad, m].

    Raises:
        InvalidRequest: a sample; joints unknown or left out; a value outside the grid.
        FlexmodalError: a chunk about it is not there yet, or spoilt.
    """
    if not atlas.is_grid:
        raise InvalidRequest(Fault(str(atlas.path), "", "a sample of postures", "a grid, or the nearest"))
    wanted = _wanted(atlas, posture)
    corners: dict[str, Any] = {}
    for name in atlas.dims:
        axis = atlas.dataset[name].values
        first = int(np.clip(np.searchsorted(axis, wanted[name], side="right") - 1, 0, max(len(axis) - 2, 0)))
        corners[name] = slice(first, first + 2)
    near = _read(atlas, corners)
    for name in atlas.dims:  # one after the other: linear in each, and no more than two values at a time
        near = (
            near.interp({name: wanted[name]}, method="linear")
            if near.sizes[name] > 1
            else near.isel({name: 0})
        )
    return near


def _wanted(atlas: Atlas, posture: Mapping[str, float]) -> dict[str, float]:
    """Values of the joints that vary, checked; one that stands still may be left out, or agree."""
    faults = []
    for name, value in posture.items():
        if name not in atlas.joints:
            allowed = ", ".join(atlas.joints)
            faults.append(Fault("call", "posture", f"unknown joint {strange(name, atlas.joints)}", allowed))
            continue
        low, high = atlas.ranges[name]
        slack = 1e-9 * max(1.0, abs(low), abs(high))
        if not low - slack <= value <= high + slack:
            allowed = f"{low:.6g} to {high:.6g}, which the atlas covers"
            faults.append(Fault("call", f"posture: {name}", f"{value:.6g}", allowed))
    missing = [name for name, (low, high) in atlas.ranges.items() if low < high and name not in posture]
    if missing:
        faults.append(
            Fault("call", "posture", f"nothing for {', '.join(missing)}", "every joint that varies")
        )
    if faults:
        raise InvalidRequest(faults)
    return {
        name: float(np.clip(posture.get(name, low), low, high)) for name, (low, high) in atlas.ranges.items()
    }


def _nearest_of_sample(atlas: Atlas, wanted: Mapping[str, float]) -> int:
    best, place = math.inf, 0
    names = atlas.along
    target, span = np.array([wanted[name] for name in names]), np.array([atlas.span[name] for name in names])
    for number in atlas.standing:
        _, (part,) = atlas.layout.region(number)
        with atlas.reading():
            some = np.stack([atlas.dataset[name][part].values for name in names], axis=1)
        distance = np.linalg.norm((some - target) / span, axis=1)
        here = int(np.argmin(distance))
        if distance[here] < best:
            best, place = float(distance[here]), part.start + here
    if math.isinf(best):
        raise FlexmodalError(f"{atlas.path}: no chunk is there yet; compute the atlas first")
    return place


def _read(atlas: Atlas, place: Mapping[str, Any]) -> xarray.Dataset:
    for number in _chunks_of(atlas, place):
        if not atlas.layout.stands(atlas.path, number):
            raise FlexmodalError(
                f"{atlas.path}: that part is not computed yet; the command that began it goes on"
            )
    with atlas.reading():
        return atlas.dataset.isel(dict(place)).load()


def _chunks_of(atlas: Atlas, place: Mapping[str, Any]) -> list[int]:
    ranges = []
    for name, size in zip(atlas.dims, atlas.layout.chunk, strict=True):
        one = place[name]
        first, last = (one.start, one.stop - 1) if isinstance(one, slice) else (one, one)
        last = min(last, atlas.dataset.sizes[name] - 1)
        ranges.append(range(first // size, last // size + 1))
    mesh = np.meshgrid(*ranges, indexing="ij")
    return [int(one) for one in np.ravel_multi_index([part.ravel() for part in mesh], atlas.layout.counts)]
