"""What is hidden in a campaign: kept beside it, never in it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from flexmodal.files import whole_file
from flexmodal.text.write_toml import toml_text


@dataclass(frozen=True)
class HiddenEffect:
    """One effect as it was put in."""

    effect: str
    form: str
    """Which physical form of it; see `flexmodal.rig.FORMS`."""
    where: str
    parameters: Mapping[str, float]
    units: Mapping[str, str]
    severity: float
    """Multiple of the parameters first drawn or given."""
    height: float | None
    """Over the noise floor; None where it was not asked for."""
    catalogued: bool
    retuned: float | None = None
    """Height that is left when all else is re-tuned; None where that was not asked for."""


@dataclass(frozen=True)
class Truth:
    """Everything the tester does not know."""

    robot: str
    seed: int
    noise: float
    scatter: float
    noise_floor: float | None
    """Root mean square of |ln| of the noise of one record; None where it was not needed."""
    effects: tuple[HiddenEffect, ...]
    factors: Mapping[str, float] = field(default_factory=dict)
    """True over believed, by parameter."""

    def table(self) -> dict[str, Any]:
        """As a table for TOML or JSON; what is None is left out."""
        effects = []
        for effect in self.effects:
            entry: dict[str, Any] = {
                "effect": effect.effect,
                "form": effect.form,
                "where": effect.where,
                "catalogued": effect.catalogued,
                "severity": effect.severity,
            }
            if effect.height is not None:
                entry["times_noise_floor"] = effect.height
            if effect.retuned is not None:
                entry["times_noise_floor_retuned"] = effect.retuned
            entry["parameters"] = dict(effect.parameters)
            entry["units"] = dict(effect.units)
            effects.append(entry)
        table: dict[str, Any] = {
            "format": 1, "robot": self.robot, "seed": self.seed, "noise": self.noise, "scatter": self.scatter,
        }  # fmt: skip
        if self.noise_floor is not None:
            table["noise_floor"] = self.noise_floor
        return {**table, "true_over_believed": dict(self.factors), "effect": effects}

    @classmethod
    def of_table(cls, table: Mapping[str, Any]) -> Truth:
        """From such a table.

        Raises:
            KeyError, TypeError, ValueError: it is none.
        """
        effects = tuple(
            HiddenEffect(
                str(one["effect"]), str(one["form"]), str(one["where"]),
                {str(name): float(value) for name, value in one["parameters"].items()},
                {str(name): str(unit) for name, unit in one["units"].items()},
                float(one["severity"]), one.get("times_noise_floor"), bool(one["catalogued"]),
                one.get("times_noise_floor_retuned"),
            )
            for one in table["effect"]
        )  # fmt: skip
        factors = {str(name): float(value) for name, value in table["true_over_believed"].items()}
        return cls(
            str(table["robot"]), int(table["seed"]), float(table["noise"]), float(table["scatter"]),
            table.get("noise_floor"), effects, factors,
        )  # fmt: skip

    def write(self, path: Path) -> None:
        """Write as TOML.

        Raises:
            OutputExists: there is a file already.
        """
        with whole_file(path) as scratch:
            scratch.write_text(toml_text(self.table()), encoding="utf-8")


def truth_path(folder: Path) -> Path:
    """`DIR.truth.toml` beside `DIR`."""
    return folder.parent / f"{folder.name}.truth.toml"
