"""Modes estimated from measured FRFs, each number with its uncertainty.

The residue A is that of the receptance α(ω) = Σ [A/(iω − λ) + Ā/(iω − λ̄)], whatever form was measured,
as `flexmodal.modal.Modes` and `flexmodal.frf.modal_sum` have it. The amplitude multiplier of the thesis,
a mobility iω A′/(ω_n² − ω² + 2iζω_nω), has the same residue at the pole when A′ = 2iω_d A, with
ω_d = ω_n√(1 − ζ²). For a real mode A′ is real and the two forms are the same function; for a complex
one they differ away from the resonance, where A′ breaks conjugate symmetry and A does not.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.ema.measured import Measured
from flexmodal.ema.methods.basis import Residuals, mode_columns, pole_of, residual_columns
from flexmodal.frf import POWER
from flexmodal.frf.form import Form, check_form

Method = Literal["peaks", "circle", "least-squares", "lscf"]


@dataclass(frozen=True, eq=False)
class ModeEstimate:
    """One mode as one or several FRFs show it."""

    frequency: float
    """Natural frequency ω_n/2π [Hz]."""
    damping_ratio: float
    residue: Complex[np.ndarray, " frf"]
    """A of the receptance's modal sum [m/(s·N)], one for each FRF."""
    covariance: Float[np.ndarray, "2 2"]
    """What noise and misfit make of natural frequency [Hz] and damping ratio; zero where one was forced."""
    residue_covariance: Float[np.ndarray, "frf 2 2"]
    """The same of the real and imaginary part of each residue."""
    freedom: float
    """Degrees of freedom behind the covariance; few make the intervals wider (Student's t)."""
    quality: float
    """Share of the measured signal around the resonance that the mode explains, 0 to 1."""
    method: Method
    remarks: tuple[str, ...] = ()
    """What a reader should know before trusting the numbers."""
    choices: Float[np.ndarray, "2 2"] = field(default_factory=lambda: np.zeros((2, 2)))
    """What choices of the analyst make of natural frequency [Hz] and damping ratio, as a covariance: how far
    other choices, which another would have made as well, move them beyond what noise does."""
    residue_choices: Float[np.ndarray, " frf"] | None = None
    """The same of each residue's magnitude, as variances; None for zero."""

    @property
    def pole(self) -> complex:
        """λ = −ζω_n + iω_d [rad/s]."""
        omega = np.array([2 * np.pi * self.frequency])
        return complex(pole_of(omega, np.array([self.damping_ratio]))[0])

    @property
    def amplitude_multiplier(self) -> Complex[np.ndarray, " frf"]:
        """A′ = 2iω_d A of the thesis's mobility iω A′/(ω_n² − ω² + 2iζω_nω) [1/kg]."""
        return 2j * self.pole.imag * self.residue

    @property
    def frequency_error(self) -> float:
        """Standard error of the natural frequency, noise and choices together [Hz]."""
        return float(np.hypot(self.by_noise[0], self.by_choices[0]))

    @property
    def damping_error(self) -> float:
        """Standard error of the damping ratio, noise and choices together."""
        return float(np.hypot(self.by_noise[1], self.by_choices[1]))

    @property
    def residue_error(self) -> Float[np.ndarray, " frf"]:
        """Standard error of each residue's magnitude, noise and choices together [m/(s·N)]."""
        return np.hypot(self.by_noise[2:], self.by_choices[2:])

    @property
    def by_noise(self) -> Float[np.ndarray, " number"]:
        """Standard errors by noise and misfit: of frequency [Hz], damping ratio and each |A| [m/(s·N)]."""
        size = np.abs(self.residue)
        towards = (
            np.stack([self.residue.real, self.residue.imag], axis=1) / np.where(size > 0, size, 1)[:, None]
        )
        along = np.einsum("fi,fij,fj->f", towards, self.residue_covariance, towards)
        return np.sqrt(np.maximum(np.concatenate([np.diag(self.covariance), along]), 0.0))

    @property
    def by_choices(self) -> Float[np.ndarray, " number"]:
        """Standard errors that stand for the choices, in the order of `by_noise`."""
        residues = np.zeros(len(self.residue)) if self.residue_choices is None else self.residue_choices
        return np.sqrt(np.maximum(np.concatenate([np.diag(self.choices), residues]), 0.0))

    def reach(self, level: float = 0.95) -> Float[np.ndarray, " number"]:
        """Half the interval of that level, in the order of `by_noise`.

        Noise by Student's t for the degrees of freedom behind it, choices as a normal variable, the two
        added in quadrature.
        """
        from scipy.special import stdtrit

        noise, choice = (
            float(stdtrit(freedom, (1 + level) / 2)) for freedom in (min(self.freedom, 1e9), 1e9)
        )
        return np.hypot(noise * self.by_noise, choice * self.by_choices)

    def frequency_interval(self, level: float = 0.95) -> tuple[float, float]:
        """Where the natural frequency lies with that probability [Hz]."""
        reach = float(self.reach(level)[0])
        return self.frequency - reach, self.frequency + reach

    def damping_interval(self, level: float = 0.95) -> tuple[float, float]:
        """Where the damping ratio lies with that probability."""
        reach = float(self.reach(level)[1])
        return self.damping_ratio - reach, self.damping_ratio + reach

    def residue_interval(self, level: float = 0.95) -> tuple[np.ndarray, np.ndarray]:
        """Where each residue's magnitude lies with that probability [m/(s·N)]."""
        reach = self.reach(level)[2:]
        return np.abs(self.residue) - reach, np.abs(self.residue) + reach


@dataclass(frozen=True, eq=False)
class EstimatedModes:
    """What a fit found, with the measurement it was found in."""

    modes: tuple[ModeEstimate, ...]
    """In the order of frequency."""
    measured: Measured
    method: Method
    upper: Complex[np.ndarray, " frf"]
    """U: receptance of the modes above the band [m/N]."""
    lower: Complex[np.ndarray, " frf"]
    """L of −L/ω²: inertance of the modes below the band [1/kg]."""
    refused: tuple[tuple[float, str], ...] = ()
    """Peaks that gave no mode: frequency [Hz] and why."""
    converged: bool = True
    decay: float = 0.0
    """Of an exponential window whose damping was taken out of the modes; the FRFs still have it [1/s]."""

    def __iter__(self) -> Iterator[ModeEstimate]:
        """The modes in the order of frequency."""
        return iter(self.modes)

    def __len__(self) -> int:
        """How many modes."""
        return len(self.modes)

    @property
    def frequency(self) -> Float[np.ndarray, " mode"]:
        """Natural frequencies [Hz]."""
        return np.array([mode.frequency for mode in self.modes], dtype=float)

    @property
    def damping_ratio(self) -> Float[np.ndarray, " mode"]:
        """Damping ratios."""
        return np.array([mode.damping_ratio for mode in self.modes], dtype=float)

    @property
    def residue(self) -> Complex[np.ndarray, "frf mode"]:
        """Residues of the receptance; columns are mode shapes up to scale if the FRFs share a reference."""
        if not self.modes:
            return np.empty((self.measured.value.shape[1], 0), dtype=complex)
        return np.stack([mode.residue for mode in self.modes], axis=1)

    def synthesise(
        self, frequency: Float[np.ndarray, " line"] | None = None, form: str | None = None
    ) -> Complex[np.ndarray, "line frf"]:
        """The FRFs that these modes and the residual terms amount to, as measured: through a window, if any.

        Args:
            frequency: above 0 [Hz]; the measured lines if None.
            form: receptance, mobility or inertance; the measured form if None.
        """
        target: Form = check_form(form or self.measured.form)
        omega = self.measured.omega if frequency is None else 2 * np.pi * frequency
        total = residual_columns(omega, POWER[target], "real") @ np.stack([self.upper, self.lower])
        for mode in self.modes:
            columns = mode_columns(omega, np.array([mode.pole - self.decay]), POWER[target])
            total = total + columns @ np.stack([mode.residue.real, mode.residue.imag])
        return total

    @property
    def misfit(self) -> float:
        """Root mean square of measured less synthesised, relative to the root mean square measured."""
        away = self.measured.value - self.synthesise()
        return float(np.linalg.norm(away) / np.linalg.norm(self.measured.value))

    @property
    def is_sound(self) -> bool:
        """Whether the fit converged, refused no peak and left no remark."""
        return self.converged and not self.refused and not any(mode.remarks for mode in self.modes)

    @property
    def verdict(self) -> str:
        """One sentence on what was found and what to do about what was not."""
        count = f"{len(self)} mode{'' if len(self) == 1 else 's'} by {self.method}"
        if not self.converged:
            return f"{count}, but the fit did not converge: choose the peaks by hand or narrow the band"
        if self.refused:
            told = "; ".join(f"{frequency:.4g} Hz: {why}" for frequency, why in self.refused)
            return f"{count}; no mode at {told}"
        doubtful = [f"{mode.frequency:.4g} Hz" for mode in self.modes if mode.remarks]
        return f"{count}; read the remarks at {', '.join(doubtful)}" if doubtful else count


def with_residual_terms(found: EstimatedModes, residuals: Residuals) -> EstimatedModes:
    """Add the residual terms that serve best when the modes stay as they are.

    Args:
        found: modes whose residues are kept.
        residuals: none, real or complex.
    """
    if residuals == "none":
        return found
    measured = found.measured
    columns = residual_columns(measured.omega, POWER[measured.form], residuals)
    left = measured.value - replace(found, upper=0 * found.upper, lower=0 * found.lower).synthesise()
    terms = solve_terms(columns, left)
    return replace(found, upper=terms[0], lower=terms[1])


def solve_terms(columns: np.ndarray, value: np.ndarray) -> np.ndarray:
    """Real factors of complex columns by least squares, folded into complex U and L [2, frf].

    Args:
        columns: what the fit is linear in, by line.
        value: by line and FRF.
    """
    return fold_terms(solve_columns(columns, value))


def solve_columns(columns: np.ndarray, value: np.ndarray) -> np.ndarray:
    """Real factors of complex columns by least squares, every line alike [term, frf].

    Args:
        columns: what the fit is linear in, by line.
        value: by line and FRF.
    """
    scale = np.linalg.norm(columns, axis=0)
    stacked = np.concatenate([columns.real, columns.imag]) / scale
    right = np.concatenate([value.real, value.imag])
    terms: np.ndarray = np.linalg.lstsq(stacked, right, rcond=None)[0] / scale[:, None]
    return terms


def fold_terms(terms: np.ndarray) -> np.ndarray:
    """Columns [term, frf] of `residual_columns` as complex U and L [2, frf]."""
    if len(terms) == 0:
        return np.zeros((2, terms.shape[1]), dtype=complex)
    return terms[:2] + 1j * (terms[2:] if len(terms) == 4 else np.zeros_like(terms[:2]))
