"""What is asked of the postures of an atlas: one number of each."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flexmodal.errors import Fault, InvalidRequest

if TYPE_CHECKING:
    import xarray

_LARGER = {"receptance": False, "modes": True, "stiffness": True, "depth": True}
_UNITS = {"receptance": "m/N", "modes": "Hz", "stiffness": "N/m", "depth": "m"}
_SLACK = 1e-6
"""How far a frequency may be off a line, in parts of it, and still be meant."""


@dataclass(frozen=True)
class Task:
    """What makes a posture good.

    Of receptances the largest amplitude in a band, small; of modes a natural frequency, large; of stiffness
    the stiffness along a direction, large; of depths of cut the depth at a speed or at all speeds, large.
    """

    band: tuple[float, float] | None = None
    """Of the frequency [Hz] or the spindle speed [rev/min]; one value twice means the nearest, none all."""
    label: str = ""
    """A pair of directions or a direction; the only or first one if none."""
    mode: int = 1
    """Number of the mode."""

    def larger(self, quantity: str) -> bool:
        """Whether more is better."""
        return _LARGER[quantity]

    def unit(self, quantity: str) -> str:
        """Of the number."""
        return _UNITS[quantity]

    def judge(self, dataset: xarray.Dataset, quantity: str) -> Judge:
        """How a part of an atlas is judged.

        Args:
            dataset: the atlas.
            quantity: which it is of.

        Raises:
            InvalidRequest: it has no such label, mode, or nothing in the band.
        """
        if quantity == "modes":
            most = dataset.sizes["mode"]
            if not 1 <= self.mode <= most:
                raise InvalidRequest(Fault("call", "mode", str(self.mode), f"1 to {most}"))
            return Judge("natural_frequency", "", slice(0, 0), {"mode": self.mode - 1})
        if quantity == "depth":
            if self.band is None:
                return Judge("critical_depth", "", slice(0, 0), {})
            return Judge("limiting_depth", "spindle_speed", self._lines(dataset, "spindle_speed"), {})
        if quantity == "stiffness":
            return Judge("stiffness", "", slice(0, 0), {"direction": self._place(dataset, "direction")})
        lines = self._lines(dataset, "frequency")
        return Judge("receptance", "frequency", lines, {"pair": self._place(dataset, "pair")})

    def label_in(self, dataset: xarray.Dataset, quantity: str) -> str:
        """The label that counts, as the atlas has it; empty where it has none.

        Args:
            dataset: the atlas.
            quantity: which it is of.

        Raises:
            InvalidRequest: none of the atlas's labels.
        """
        name = {"receptance": "pair", "stiffness": "direction"}.get(quantity)
        return "" if name is None else str(dataset[name].values[self._place(dataset, name)])

    def _place(self, dataset: xarray.Dataset, name: str) -> int:
        labels = [str(one) for one in dataset[name].values]
        if not self.label:
            return 0
        wanted = {self.label, f"{self.label}/{self.label}"}
        found = [place for place, one in enumerate(labels) if one in wanted]
        if not found:
            raise InvalidRequest(Fault("call", name, repr(self.label[:60]), ", ".join(labels[:20])))
        return found[0]

    def _lines(self, dataset: xarray.Dataset, name: str) -> slice:
        axis = dataset[name].values
        low, high = self.band or (float(axis[0]), float(axis[-1]))
        if low == high and axis[0] <= low <= axis[-1]:  # one value means the nearest there is
            nearest = int(np.argmin(np.abs(axis - low)))
            return slice(nearest, nearest + 1)
        inside = np.flatnonzero((axis >= low * (1 - _SLACK)) & (axis <= high * (1 + _SLACK)))
        if len(inside) == 0 or not low <= high:
            allowed = f"a band with one of the {len(axis)} values from {axis[0]:g} to {axis[-1]:g}"
            raise InvalidRequest(Fault("call", "band", f"{low:g} to {high:g}", allowed))
        return slice(int(inside[0]), int(inside[-1]) + 1)


@dataclass(frozen=True)
class Judge:
    """A task made concrete for one atlas."""

    variable: str
    along: str
    """Dimension over which the worst counts; none if empty."""
    part: slice
    fixed: dict[str, int]

    def value(self, some: xarray.Dataset) -> Any:
        """One number for each posture of a part of the atlas."""
        found = some[self.variable].isel(self.fixed)
        if not self.along:
            return found.values
        within = found.isel({self.along: self.part}).transpose(..., self.along).values
        return np.abs(within).max(axis=-1) if np.iscomplexobj(within) else within.min(axis=-1)
