"""Modes of real measurements beside those that other programs found in them."""

from __future__ import annotations

import csv
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from flexmodal.campaign import estimate_frfs, read_campaign
from flexmodal.ema import Choices, EstimatedModes, Measured, estimate

REAL = Path(__file__).parents[1] / "tests" / "data" / "real"

PLATE_BANDS = ((62.0, 95.0), (110.0, 145.0), (190.0, 240.0), (245.0, 285.0), (325.0, 370.0), (400.0, 490.0))


@dataclass(frozen=True)
class Comparison:
    """One mode, ours and theirs."""

    dataset: str
    number: int
    method: str
    frequency: float
    frequency_reach: float
    damping: float
    damping_reach: float
    peer_frequency: tuple[float, float]
    peer_damping: tuple[float, float]

    @property
    def frequency_gap(self) -> float:
        """Relative distance from the middle of what the peers found."""
        return self.frequency / np.mean(self.peer_frequency) - 1

    @property
    def damping_agrees(self) -> bool:
        """Whether the 95 % interval meets the range of the peers."""
        low, high = self.damping - self.damping_reach, self.damping + self.damping_reach
        return low <= self.peer_damping[1] and high >= self.peer_damping[0]


def peers() -> dict[tuple[str, int], list[tuple[float, float]]]:
    """Frequencies and damping ratios by dataset and mode."""
    found: dict[tuple[str, int], list[tuple[float, float]]] = {}
    with (REAL / "reference_results.csv").open(newline="") as file:
        for row in csv.DictReader(file):
            damping = float(row["damping_ratio"]) if row["damping_ratio"] else np.nan
            key = (row["dataset"], int(row["mode"]))
            found.setdefault(key, []).append((float(row["natural_frequency_hz"]), damping))
    return found


def beam() -> Measured:
    """Three accelerances of a free beam, as the analyser's UFF file has them."""
    import pyuff

    records = pyuff.UFF(str(REAL / "pyuff_accelerance_points" / "measurement.uff")).read_sets()
    return Measured(records[0]["x"], np.stack([r["data"] for r in records], axis=1), "inertance").within(
        10.0, 990.0
    )


def laboratory(name: str) -> Measured:
    """An analyser's averaged FRF of a hammer test; its units are unknown."""
    from scipy.io import loadmat

    table = loadmat(REAL / "vibrationtesting_lab_frf" / f"{name}.mat")
    return Measured(table["Freq_domain"].ravel(), table["Hf_chan_2"].astype(complex), "receptance")


def plate() -> Measured:
    """H1 of five sweeps of a thin plate, rectangular windows, 0.5 Hz."""
    records = estimate_frfs(read_campaign(REAL / "mssp_plate_sweep"))
    return Measured(records.frequency, records.value[:1].T, records.form).within(60.0, 500.0)


def fits() -> list[tuple[str, str, EstimatedModes]]:
    """Every fit of the table: dataset, what it is called, modes."""
    found = [("pyuff_accelerance_points", "least squares, six modes at once", _by_choices(beam(), Choices()))]
    found.append(
        ("pyuff_accelerance_points", "lscf, not refined", estimate(beam(), "lscf", Choices(refine=False)))
    )
    one = _by_choices(laboratory("case1"), Choices(band=(190.0, 235.0)))
    found.append(("vibrationtesting_lab_frf/case1", "least squares", one))
    sweep = plate()
    for low, high in PLATE_BANDS:
        choices = Choices(band=(low, high), at=[(low + high) / 2], weighting="logarithmic")
        found.append(("mssp_plate_sweep", f"least squares, {low:g}–{high:g} Hz", _by_choices(sweep, choices)))
    raw = Choices(refine=False, highest_order=60)
    found.append(("mssp_plate_sweep", "lscf, not refined", estimate(sweep, "lscf", raw)))
    return found


def _by_choices(measured: Measured, choices: Choices) -> EstimatedModes:
    """A fit whose covariances also hold how far it moves with choices that another would make as well.

    Those are the residual terms, real or complex, and the weights, uniform or logarithmic. The largest move
    of each number counts as 1.96 standard errors, beside those of noise.
    """
    found = estimate(measured, choices=choices)
    others = [
        estimate(measured, choices=replace(choices, residuals=residuals, weighting=weighting))
        for residuals in ("real", "complex")
        for weighting in ("uniform", "logarithmic")
    ]
    modes = []
    for mode in found:
        near = [min(other.modes, key=lambda one: abs(one.frequency - mode.frequency)) for other in others]
        moves = [
            max(abs(one.frequency - mode.frequency) for one in near),
            max(abs(one.damping_ratio - mode.damping_ratio) for one in near),
        ]
        modes.append(replace(mode, covariance=mode.covariance + np.diag(np.square(moves)) / 1.96**2))
    return replace(found, modes=tuple(modes))


def comparisons() -> list[Comparison]:
    """Each mode that a peer found, with ours nearest to it."""
    known, rows = peers(), []
    for dataset, method, found in fits():
        for (name, number), theirs in known.items():
            frequency = np.array([f for f, _ in theirs])
            if name != dataset or not len(found):
                continue
            mode = min(found.modes, key=lambda mode: abs(mode.frequency - frequency.mean()))
            if abs(mode.frequency / frequency.mean() - 1) > 0.02:
                continue
            damping = [z for _, z in theirs if np.isfinite(z)]
            reach = mode.coverage_factor()
            rows.append(
                Comparison(
                    dataset, number, method, mode.frequency, reach * mode.frequency_error, mode.damping_ratio,
                    reach * mode.damping_error, (frequency.min(), frequency.max()),
                    (min(damping), max(damping)),
                )
            )  # fmt: skip
    return rows


def main() -> None:
    from tables import write

    cells = []
    for row in sorted(
        comparisons(), key=lambda row: (row.dataset, row.method.startswith("lscf"), row.number)
    ):
        low, high = row.peer_damping
        cells.append(
            [
                f"{row.dataset}, {row.number}, {row.method}",
                f"{row.frequency:.3f} ± {row.frequency_reach:.3f}",
                f"{row.peer_frequency[0]:.3f}–{row.peer_frequency[1]:.3f}",
                f"{100 * row.frequency_gap:+.3f}",
                f"{100 * row.damping:.4f} ± {100 * row.damping_reach:.4f}",
                f"{100 * low:.4f}–{100 * high:.4f}",
                "yes" if row.damping_agrees else "no",
            ]
        )
    write(
        "ema_real",
        "Modes of real measurements",
        "Made by `benchmarks/ema_real.py` from the measurements in `tests/data/real`, each with its "
        "origin and "
        "licence there. Peers: sdypy-EMA at several orders, vibrationtesting, a one-mode fit and a "
        "logarithmic "
        "decrement, as `reference_results.csv` lists them. ± is half the 95 % interval with, for "
        "least squares, the largest move of the number among real and complex residual terms and uniform and "
        "logarithmic weights; for LSCF that is not refined, the scatter over the orders.",
        ["data, mode, method", "frequency [Hz]", "peers [Hz]", "gap [%]", "ζ [%]", "peers ζ [%]", "ζ meets"],
        cells,
        "The sweeps of the plate are jagged round their peaks, so that damping there depends on who "
        "weighs what: "
        "at its fifth mode least squares finds more damping than LSCF, and its interval does not reach "
        "LSCF's value. Half-power bands of the beam are 0.04 to 0.25 of one line: "
        "peak picking and circle fit refuse them or say so. The companion `case2` has a peak of "
        "about zero or "
        "negative damping, and the fit says that too.",
    )


if __name__ == "__main__":
    main()
