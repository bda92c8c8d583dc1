"""Templates of physics for the free functions: what a spring, a mass, a loss, a resonance look like."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.diagnosis.lawfree.port import Port
from flexmodal.report.words import minus

Grid = Callable[[Float[np.ndarray, " line"]], Float[np.ndarray, " value"]]


@dataclass(frozen=True)
class Template:
    """A class: real multiples of some terms, which may depend on a few parameters above 0."""

    name: str
    basis: Callable[[Float[np.ndarray, " line"], tuple[float, ...]], Sequence[Complex[np.ndarray, " line"]]]
    terms: int
    symbols: tuple[str, ...]
    """What the coefficients are called, with {} for the value."""
    grids: tuple[Grid, ...] = ()
    """Values of the parameters from which a search begins, by angular frequencies [rad/s]."""
    at: str = ""
    """What the parameters are called."""

    def words(
        self,
        at: tuple[float, ...],
        linear: Float[np.ndarray, "function term"],
        names: Sequence[str],
        unit: str,
    ) -> str:
        """With its numbers.

        Args:
            at: parameters.
            linear: coefficients of each function.
            names: of the functions.
            unit: of the functions.
        """
        parts = []
        for name, row in zip(names, linear.tolist(), strict=True):
            values = (symbol.format(value) for symbol, value in zip(self.symbols, row, strict=True))
            told = minus(", ".join(values))
            parts.append(f"{name} {told}" if len(names) > 1 else told)
        tail = f"; {minus(self.at.format(*at))}" if at else ""
        return f"{self.name}: {'; '.join(parts)}{tail}" + (f" [{unit}]" if unit else "")


def _inside(omega: np.ndarray) -> np.ndarray:
    return np.geomspace(omega[0] * 2, omega[-1] * 0.9, 24)


def _mounts(omega: np.ndarray) -> np.ndarray:
    return np.geomspace(omega[0] * 2, omega[-1] * 2, 24)


def _ratios(omega: np.ndarray) -> np.ndarray:
    return np.array([0.003, 0.02, 0.1, 0.5, 2.0])


def _times(omega: np.ndarray) -> np.ndarray:
    return np.geomspace(0.1 / omega[-1], 1 / omega[0], 10)


def _steps(omega: np.ndarray) -> np.ndarray:
    return np.geomspace(0.05, 20.0, 8)


def _one(omega: np.ndarray) -> np.ndarray:
    return np.ones(len(omega), dtype=complex)


def _resonance(omega: np.ndarray, at: tuple[float, ...]) -> np.ndarray:
    own, ratio = at
    spring = own**2 + 2j * ratio * own * omega
    return np.asarray(-(omega**2) * spring / (spring - omega**2))


def _rotor(omega: np.ndarray, at: tuple[float, ...]) -> np.ndarray:
    own, ratio = at
    return np.asarray(1 / (1 + 2j * ratio * omega / own - (omega / own) ** 2))


_SPRING = Template("spring", lambda w, at: [_one(w)], 1, ("k = {:.4g}",))
_DAMPER = Template("damper", lambda w, at: [1j * w], 1, ("c = {:.4g}",))
_BOTH = Template("spring and damper", lambda w, at: [_one(w), 1j * w], 2, ("k = {:.4g}", "c = {:.4g}"))
_MASS = Template("mass", lambda w, at: [-(w**2) + 0j], 1, ("m = {:.4g}",))
_HELD = Template(
    "spring, damper and mass", lambda w, at: [_one(w), 1j * w, -(w**2) + 0j], 3,
    ("k = {:.4g}", "c = {:.4g}", "m = {:.4g}"),
)  # fmt: skip
_LOSS = Template(
    "constant loss",
    lambda w, at: [1j * _one(w), np.log(w / np.sqrt(w[0] * w[-1])) * 2 / np.pi + 1j],
    2,
    ("η·k = {:.4g}", "growing with frequency {:.4g}"),
)
_LOSS_SHARE = Template(
    "constant loss",
    lambda w, at: [np.log(w / np.sqrt(w[0] * w[-1])) * 2 / np.pi + 1j],
    1,
    ("η = {:.4g}",),
)
_RELAXATION = Template(
    "relaxation", lambda w, at: [1j * w * at[0] / (1 + 1j * w * at[0])], 1, ("k = {:.4g}",), (_times,),
    "time constant {:.3g} s",
)  # fmt: skip
_POWER = Template(
    "fractional loss",
    lambda w, at: [_one(w), (1j * w / np.sqrt(w[0] * w[-1])) ** at[0]],
    2,
    ("k = {:.4g}", "c = {:.4g}"),
    (lambda w: np.linspace(0.1, 0.9, 9),),
    "order {:.3g}",
)
_RELAXATIONS = Template(
    "row of relaxations",
    lambda w, at: [_one(w), *(1j * w / (1j * w + own) for own in np.geomspace(w[0] / 2, 2 * w[-1], 5))],
    6,
    ("k = {:.4g}", *("{:.3g}",) * 5),
)
_ABSORBER = Template(
    "resonance", lambda w, at: [_resonance(w, at)], 1, ("m = {:.4g}",), (_inside, _ratios),
    "ω = {:.4g} rad/s, ζ = {:.3g}",
)  # fmt: skip
_SERIES = Template(
    "something in series, with a resonance of its own",
    lambda w, at: [_one(w), 1j * w, _rotor(w, at)],
    3,
    ("k = {:.4g}", "c = {:.4g}", "in series {:.4g}"),
    (_inside, _ratios),
    "ω = {:.4g} rad/s, ζ = {:.3g}",
)

_SOFT = Template("spring", lambda w, at: [_one(w)], 1, ("1/k = {:.4g}",))
_SOFT_DAMPED = Template(
    "spring and damper", lambda w, at: [1 / (1 + 1j * w * at[0])], 1, ("1/k = {:.4g}",),
    (lambda w: np.geomspace(1e-3 / w[-1], 1 / w[0], 12),), "c/k = {:.3g} s",
)  # fmt: skip
_SOFT_LOSS = Template("spring with constant loss", lambda w, at: [(1 - 1j * at[0]) * _one(w)], 1,
                      ("1/k = {:.4g}",), (lambda w: np.geomspace(1e-3, 1.0, 10),), "η = {:.3g}")  # fmt: skip
_SOFT_HEAVY = Template(
    "spring, damper and mass", lambda w, at: [_rotor(w, at)], 1, ("1/k = {:.4g}",), (_inside, _ratios),
    "ω = {:.4g} rad/s, ζ = {:.3g}",
)  # fmt: skip

_GAIN = Template("gain", lambda w, at: [_one(w)], 1, ("ln gain = {:.4g}",))
_SLOPE = Template(
    "gain with a power of frequency",
    lambda w, at: [_one(w), np.log(w / np.sqrt(w[0] * w[-1])) + 0j],
    2,
    ("ln gain = {:.4g}", "exponent {:.3g}"),
)
_PHASE = Template(
    "gain and phase", lambda w, at: [_one(w), 1j * _one(w)], 2, ("ln gain = {:.4g}", "{:.4g} rad")
)
_DELAY = Template("delay", lambda w, at: [-1j * w], 1, ("{:.4g} s",))
_GAIN_DELAY = Template(
    "gain and delay", lambda w, at: [_one(w), -1j * w], 2, ("ln gain = {:.4g}", "{:.4g} s")
)
_LOW = Template("low pass and gain", lambda w, at: [_one(w), -np.log(1 + 1j * w * at[0])], 2,
                ("ln gain = {:.4g}", "order {:.3g}"), (_times,), "time constant {:.3g} s")  # fmt: skip
_TURN = Template(
    "all-pass and gain",
    lambda w, at: [_one(w), np.log(1 - 0.5j * w * at[0]) - np.log(1 + 0.5j * w * at[0])],
    2,
    ("ln gain = {:.4g}", "order {:.3g}"),
    (_times,),
    "time {:.3g} s",
)
_HIGH = Template("high pass and gain", lambda w, at: [_one(w), -np.log(1 + 1 / (1j * w * at[0]))], 2,
                 ("ln gain = {:.4g}", "order {:.3g}"), (_times,), "time constant {:.3g} s")  # fmt: skip
_MOUNT = Template(
    "resonance of its mount and gain", lambda w, at: [_one(w), np.log(_rotor(w, at))], 2,
    ("ln gain = {:.4g}", "order {:.3g}"), (_mounts, _ratios), "ω = {:.4g} rad/s, ζ = {:.3g}",
)  # fmt: skip

_STEP = Template(
    "step and gain",
    lambda w, at: [_one(w), np.log(1 + 1j * w * at[0] * at[1]) - np.log(1 + 1j * w * at[0])], 2,
    ("ln gain = {:.4g}", "order {:.3g}"), (_times, _steps), "time constant {:.3g} s, above it × {:.3g}",
)  # fmt: skip

_OF = {
    "joint": (_SPRING, _DAMPER, _LOSS, _MASS, _RELAXATION, _ABSORBER, _SERIES),
    "coupling": (_SPRING, _DAMPER, _BOTH, _MASS, _RELAXATION, _SERIES),
    "rod": (_SPRING, _DAMPER, _BOTH, _RELAXATION, _ABSORBER, _SERIES),
    "held": (_SPRING, _DAMPER, _BOTH, _RELAXATION, _ABSORBER, _SERIES),
    "balancer": (_SPRING, _DAMPER, _BOTH, _RELAXATION, _ABSORBER, _SERIES),
    "damping": (_LOSS_SHARE, _DAMPER, _RELAXATION, _BOTH, _POWER, _RELAXATIONS),
    "base": (_SOFT, _SOFT_DAMPED, _SOFT_LOSS, _SOFT_HEAVY),
    "bearing": (_SOFT, _SOFT_DAMPED, _SOFT_LOSS, _SOFT_HEAVY),
    "link": (_SOFT, _SOFT_DAMPED, _SOFT_LOSS, _SOFT_HEAVY),
    "carried": (_MASS, _SPRING, _BOTH, _HELD, _ABSORBER),
    "ground": (_SPRING, _DAMPER, _BOTH, _MASS, _RELAXATION),
    "body": (_MASS, _SPRING, _BOTH, _ABSORBER),
    "across": (_MASS, _SPRING, _BOTH, _ABSORBER),
    "attached": (_MASS, _SPRING, _BOTH, _ABSORBER),
    "sensor": (_GAIN, _SLOPE, _PHASE, _DELAY, _GAIN_DELAY, _LOW, _TURN, _HIGH, _MOUNT, _STEP),
    "hammer": (_GAIN, _SLOPE, _PHASE, _DELAY, _GAIN_DELAY, _LOW, _TURN, _HIGH, _MOUNT),
}


def templates_for(port: Port) -> tuple[Template, ...]:
    """The classes that a port's functions are compared with."""
    return _OF.get(port.kind.name, (_SPRING, _DAMPER, _BOTH, _MASS, _LOSS))
