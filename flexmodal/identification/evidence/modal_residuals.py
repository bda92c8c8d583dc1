"""Parameters from modes: natural frequencies, damping ratios, shapes, residues and antiresonances.

For a measured mode with the partner p in the model (λ_p, u_p), every part of the error is relative:

    frequency      ln |λ_p| − ln ω                            1 part counts as 1
    damping        (ζ_p − ζ)/ζ                                a tenth
    shape          a − P a, a the measured residues, P onto the model's shape: |·|² = 1 − MAC, a tenth
    residue        ln (φ_u φ_v / A), phase wrapped             a tenth
    antiresonance  ln ω_d − ln ω, ω_d the model's nearest dip   1

Frequency and damping together are the eigenvalue error [Hearne 2.54]; shapes beside them [2.53]. Each is
weighed by 1/(σ² + ε²) with its own standard error σ and a floor ε that is lowered in steps, as in the fit of
FRFs; postures enter all at once. Derivatives are exact (`poles`, `dips`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float, Int

from flexmodal.errors import InvalidSystem
from flexmodal.identification.descent import Normal, prior_cost, robust, robust_weight
from flexmodal.identification.evidence.antiresonance import nearest_dip
from flexmodal.identification.evidence.measured_modes import Antiresonance, MeasuredMode, ModeObservations
from flexmodal.identification.evidence.pairing import pair
from flexmodal.identification.spot import Spot, places_of
from flexmodal.modal.mac import mac_with, shape_residual
from flexmodal.model import Robot
from flexmodal.structure.parameter import ParameterSpace
from flexmodal.structure.poles import Poles, poles
from flexmodal.structure.structure import Axis, Structure

USES = ("frequency", "damping", "shape", "residue", "antiresonance")
TENTH = 10.0
"""How many times the floor of a frequency those of damping, shapes and residues are."""


@runtime_checkable
class PosedModel(Protocol):
    """Anything that gives a structure in a posture from the coordinates of a parameter space."""

    @property
    def space(self) -> ParameterSpace:
        """What it depends on."""
        ...

    @property
    def robot(self) -> Robot:
        """Whose chain it has."""
        ...

    def structure_at(
        self,
        x: Float[np.ndarray, " parameter"],
        q: Mapping[str, float],
        responses: Sequence[Spot],
        references: Sequence[Spot],
    ) -> Structure:
        """In one posture, seen at these places."""
        ...


@dataclass(frozen=True, eq=False)
class Seen:
    """One posture at one point of the parameter space."""

    structure: Structure
    found: Poles


@dataclass(frozen=True, eq=False)
class Entries:
    """Residuals of one mode or antiresonance: what, how much, how it changes, how sure."""

    residual: Float[np.ndarray, " entry"]
    slopes: Float[np.ndarray, "name entry"]
    variance: Float[np.ndarray, " entry"]
    coarse: Float[np.ndarray, " entry"]
    """Multiple of the floor that each gets."""


@dataclass(frozen=True, eq=False)
class ModeProblem:
    """A model and the modes it is to have."""

    model: PosedModel
    observations: ModeObservations
    use: tuple[str, ...] = ("frequency", "damping", "shape")

    @cached_property
    def places(self) -> tuple[tuple[tuple[tuple[int, int], ...], tuple[tuple[int, int], ...]], ...]:
        """Points and directions of the responses and references of each posture."""
        found = []
        for number in range(len(self.observations.postures)):
            responses: dict[tuple[int, int], None] = {}
            references: dict[tuple[int, int], None] = {}
            for mode in (self.observations.modes[k] for k in self.observations.here[number]):
                for shape in mode.shapes:
                    responses |= dict.fromkeys((int(p), int(d)) for p, d in shape.places)
                    references[shape.reference] = None
            for zero in self.observations.antiresonances:
                if zero.posture == number:
                    responses[zero.response] = references[zero.reference] = None
            found.append((tuple(responses), tuple(references)))
        return tuple(found)

    def see(self, x: Float[np.ndarray, " parameter"], number: int, *, slopes: bool) -> Seen:
        """The model in a posture.

        Raises:
            InvalidSystem: its mass matrix is not positive definite.
        """
        campaign = self.observations.campaign
        responses, references = self.places[number]
        structure = self.model.structure_at(
            x,
            self.observations.postures[number].q,
            places_of(campaign, responses),
            places_of(campaign, references),
        )
        return Seen(structure, poles(structure, self.model.space.names if slopes else ()))

    def rows(self, number: int, places: Int[np.ndarray, "place 2"]) -> Int[np.ndarray, " place"]:
        """Where places stand among the responses of a posture."""
        responses = self.places[number][0]
        return np.array([responses.index((int(p), int(d))) for p, d in places], dtype=int)

    def alike(self, number: int, seen: Seen) -> Float[np.ndarray, "measured mode"]:
        """MAC of the measured modes of a posture with the model's, of several hammer positions the mean.

        NaN where a mode has no shape.
        """
        shape, here = seen.found.shape[:, : seen.found.count], self.observations.here[number]
        table = np.full((len(here), seen.found.count), np.nan)
        for row, k in enumerate(here):
            some = [one for one in self.observations.modes[k].shapes if len(one.places) > 1]
            if some:
                models = [seen.structure.response[self.rows(number, one.places)] @ shape for one in some]
                pairs = zip(some, models, strict=True)
                table[row] = np.mean([mac_with(one.residue, model) for one, model in pairs], axis=0)
        return table

    def partners(self, x: Float[np.ndarray, " parameter"], *, scale: float = 0.1) -> tuple[int, ...]:
        """The mode of the model that each measured mode is; −1 where there is none."""
        partner = [-1] * len(self.observations.modes)
        for number in range(len(self.observations.postures)):
            here = self.observations.here[number]
            if not here:
                continue
            seen = self.see(x, number, slopes=False)
            frequency = np.array([self.observations.modes[k].frequency for k in here])
            alike = self.alike(number, seen) if {"shape", "residue"} & set(self.use) else None
            for k, found in zip(here, pair(frequency, alike, seen.found, scale=scale), strict=True):
                partner[k] = found
        return tuple(partner)

    def entries(
        self, x: Float[np.ndarray, " parameter"], partners: Sequence[int], *, slopes: bool
    ) -> list[Entries | None]:
        """Residuals of every mode and antiresonance; None where the model has no partner."""
        found: list[Entries | None] = [None] * len(self.observations)
        count = len(self.model.space) if slopes else 0
        struck = {zero.posture for zero in self.observations.antiresonances}
        for number in range(len(self.observations.postures)):
            if not self.observations.here[number] and number not in struck:
                continue
            seen = self.see(x, number, slopes=slopes)
            for k in self.observations.here[number]:
                if partners[k] >= 0:
                    found[k] = self._of_mode(self.observations.modes[k], seen, partners[k], count)
            if "antiresonance" in self.use:
                for k, zero in enumerate(self.observations.antiresonances):
                    if zero.posture == number:
                        found[len(self.observations.modes) + k] = self._of_zero(zero, seen, slopes)
        return found

    def cost(self, x: np.ndarray, partners: Sequence[int], floor: float) -> float:
        """Robust sum of squares plus the prior's; infinite where there is no model."""
        try:
            entries = self.entries(x, partners, slopes=False)
        except (InvalidSystem, np.linalg.LinAlgError):
            return float("inf")
        total = sum(
            float(np.sum(robust(e.residual**2 / (e.variance + (floor * e.coarse) ** 2))))
            for e in entries
            if e is not None
        )
        return total + prior_cost(self.model.space, x)

    def equations(self, x: np.ndarray, partners: Sequence[int], floor: float) -> Normal:
        """Cost, gradient and curvature."""
        space = self.model.space
        size, count = len(space), len(self.observations)
        scores, squared, blocks = np.zeros((count, size)), np.zeros(count), np.zeros((count, size, size))
        data = 0.0
        for k, one in enumerate(self.entries(x, partners, slopes=True)):
            if one is None:
                continue
            weight = 1 / (one.variance + (floor * one.coarse) ** 2)
            scaled = weight * one.residual**2
            data += float(np.sum(robust(scaled)))
            squared[k] = scaled.sum()
            used = weight * robust_weight(scaled)
            scores[k] = one.slopes @ (used * one.residual)
            blocks[k] = (one.slopes * used) @ one.slopes.T
        gradient = scores.sum(axis=0) + space.precision * x
        return Normal(
            data + prior_cost(space, x), data, gradient, blocks.sum(axis=0), scores, squared, blocks
        )

    # one mode

    def _of_mode(self, mode: MeasuredMode, seen: Seen, partner: int, count: int) -> Entries:
        found, parts = seen.found, []
        if "frequency" in self.use:
            away = np.log(found.frequency[partner] / mode.frequency)
            slope = found.log_frequency_slope[:, partner]
            parts.append(_single(away, slope, mode.frequency_error, 1.0))
        if "damping" in self.use and np.isfinite(mode.damping_ratio):
            away = found.damping_ratio[partner] / mode.damping_ratio - 1
            slope = found.damping_slope[:, partner] / mode.damping_ratio
            parts.append(_single(away, slope, mode.damping_error, TENTH))
        for shape in mode.shapes:
            rows = self.rows(mode.posture, shape.places)
            struck = self.places[mode.posture][1].index(shape.reference)
            model = _model_residue(seen, rows, struck, partner)
            if "shape" in self.use and len(rows) > 1:
                parts.append(_shape_entries(shape.residue, shape.error, *model))
            if "residue" in self.use:
                parts.append(_residue_entries(shape.residue, shape.error, *model))
        return _joined(parts, count)

    def _of_zero(self, zero: Antiresonance, seen: Seen, slopes: bool) -> Entries | None:
        u = self.places[zero.posture][0].index(zero.response)
        v = self.places[zero.posture][1].index(zero.reference)
        names = self.model.space.names if slopes else ()
        found = nearest_dip(seen.structure, Axis(np.zeros(1), zero.frequency), (u, v), zero.frequency, names)
        if found is None:
            return None
        place, slope = found
        return _single(float(np.log(place / zero.frequency)), slope / place, zero.error, 1.0)


def _single(away: float, slope: np.ndarray, error: float, coarse: float) -> Entries:
    return Entries(np.array([away]), slope[:, None], np.array([error**2]), np.array([coarse]))


def _model_residue(seen: Seen, rows: np.ndarray, struck: int, partner: int) -> tuple[np.ndarray, np.ndarray]:
    """φ_u φ_v of one mode at some places, and its derivatives."""
    found, structure = seen.found, seen.structure
    u, v = (
        structure.response[rows] @ found.shape[:, partner],
        structure.reference[struck] @ found.shape[:, partner],
    )
    turned = found.shape_slope[:, :, partner]
    slopes = (turned @ structure.response[rows].T) * v + np.outer(turned @ structure.reference[struck], u)
    return u * v, slopes


def _shape_entries(residue: np.ndarray, error: np.ndarray, model: np.ndarray, slopes: np.ndarray) -> Entries:
    """A − P a with a of unit length."""
    a = residue / np.linalg.norm(residue)
    variance = (np.abs(a) * error) ** 2
    # Each part has half the variance.
    return Entries(
        *shape_residual(a, model, slopes),
        np.concatenate([variance, variance]) / 2,
        np.full(2 * len(a), TENTH / np.sqrt(2 * len(a))),
    )


def _residue_entries(
    residue: np.ndarray, error: np.ndarray, model: np.ndarray, slopes: np.ndarray
) -> Entries:
    """ln(φ_u φ_v / A): size and phase."""
    kept = np.where(model == 0, 1e-300, model)
    away, turned = np.log(kept / residue), slopes / kept
    return Entries(
        np.concatenate([away.real, away.imag]),
        np.concatenate([turned.real, turned.imag], axis=1),
        np.concatenate([error, error]) ** 2 / 2,
        np.full(2 * len(residue), TENTH),
    )


def _joined(parts: list[Entries], count: int) -> Entries:
    if not parts:
        empty = np.zeros(0)
        return Entries(empty, np.zeros((count, 0)), empty, empty)
    return Entries(
        np.concatenate([p.residual for p in parts]),
        np.concatenate([p.slopes for p in parts], axis=1),
        np.concatenate([p.variance for p in parts]),
        np.concatenate([p.coarse for p in parts]),
    )
