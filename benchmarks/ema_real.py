"""Modes of real measurements, as `flexmodal fit` gives them, beside those that other programs found in them.

`python benchmarks/ema_real.py` makes docs/tables/ema_real.md; with `--references` it first makes
tests/data/real/reference_averaged.csv again, which needs sdypy-EMA.
"""

from __future__ import annotations

import contextlib
import csv
import io
import json
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from flexmodal.campaign import read_campaign
from flexmodal.campaign.estimate import spectra

REAL = Path(__file__).parents[1] / "tests" / "data" / "real"
AVERAGED = REAL / "reference_averaged.csv"

PLATE_BANDS = ("62:95", "110:145", "190:240", "245:285", "325:370", "400:490")
REACH = 2
"""Cross-spectra are averaged over so many lines to either side, weighed by a Hann window, for AVERAGED."""


@dataclass(frozen=True)
class Case:
    """One call of `flexmodal fit`."""

    folder: str
    dataset: str
    """What the reference results call it."""
    options: tuple[str, ...]

    @property
    def refined(self) -> bool:
        """Whether the numbers are those of least squares."""
        return "--no-refine" not in self.options

    def arguments(self) -> list[str]:
        """The command line."""
        return ["fit", str(REAL / self.folder), *self.options]


RAW = ("--method", "lscf", "--no-refine")
BEAM = Case("free_free_beam", "pyuff_accelerance_points", ("--per", "posture"))
HAMMER = Case("laboratory_hammer", "vibrationtesting_lab_frf/case1", ())
PLATE = tuple(
    Case(
        "mssp_plate_sweep",
        "mssp_plate_sweep",
        ("--band", band, "--at", f"{sum(map(float, band.split(':'))) / 2:g}", "--weighting", "logarithmic"),
    )
    for band in PLATE_BANDS
)
SIXTH = Case(
    "mssp_plate_sweep",
    "mssp_plate_sweep",
    ("--band", PLATE_BANDS[5], "--at", "448,472", "--weighting", "uniform", "--residuals", "real"),
)
"""The sixth mode with its neighbour, a shoulder at 470 Hz; complex residual terms would take its place."""
CASES = (
    BEAM,
    HAMMER,
    *PLATE,
    SIXTH,
    Case(BEAM.folder, BEAM.dataset, ("--per", "posture", *RAW)),
    Case("mssp_plate_sweep", "mssp_plate_sweep", RAW),
)


@dataclass(frozen=True)
class Reference:
    """What another program, or another way, found."""

    peer: str
    frequency: float
    damping: float

    @property
    def averaged(self) -> bool:
        """Whether it is one of those from the averaged cross-spectra."""
        return self.peer.endswith("averaged")


@dataclass(frozen=True)
class Comparison:
    """One mode, ours and theirs."""

    case: Case
    number: int
    row: dict[str, Any]
    """As `flexmodal fit --json` prints it."""
    references: tuple[Reference, ...]

    @property
    def gap(self) -> float:
        """Relative distance from the middle of the reference frequencies."""
        middle = np.mean([reference.frequency for reference in self.references])
        return float(self.row["frequency"] / middle - 1)

    def dampings(self, *, averaged: bool = False) -> list[float]:
        """Of the references that give one, from the FRF as it stands or averaged over lines."""
        return [
            one.damping for one in self.references if np.isfinite(one.damping) and one.averaged is averaged
        ]

    def held(self, *, averaged: bool = False) -> int:
        """How many of them lie in the 95 % interval."""
        low, high = self.row["uncertainty"]["damping_ratio_95"]
        return sum(low <= damping <= high for damping in self.dampings(averaged=averaged))


def references() -> dict[tuple[str, int], list[Reference]]:
    """All of them, by dataset and mode."""
    found: dict[tuple[str, int], list[Reference]] = {}
    for path in (path for path in (REAL / "reference_results.csv", AVERAGED) if path.exists()):
        with path.open(newline="") as file:
            for row in csv.DictReader(file):
                damping = float(row["damping_ratio"]) if row["damping_ratio"] else np.nan
                one = Reference(row["peer"], float(row["natural_frequency_hz"]), damping)
                found.setdefault((row["dataset"], int(row["mode"])), []).append(one)
    return found


def modes_of(printed: dict[str, Any]) -> list[dict[str, Any]]:
    """Each mode once, whatever number of FRFs it was fitted to."""
    first: dict[int, dict[str, Any]] = {}
    for row in printed["modes"]:
        first.setdefault(row["mode"], row)
    return list(first.values())


def compared(case: Case, printed: dict[str, Any]) -> Iterator[Comparison]:
    """Each reference mode of the dataset with ours nearest to it, where there is one within 2 %."""
    rows = modes_of(printed)
    for (dataset, number), theirs in references().items():
        middle = np.mean([one.frequency for one in theirs])
        near = [row for row in rows if abs(row["frequency"] / middle - 1) <= 0.02]
        if dataset == case.dataset and near:
            best = min(near, key=lambda row: abs(row["frequency"] - middle))
            yield Comparison(case, number, best, tuple(theirs))


def run(case: Case) -> dict[str, Any]:
    """Call the command line in this process."""
    from flexmodal.cli.main import main

    out = io.StringIO()
    with (
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(io.StringIO()),
        contextlib.suppress(SystemExit),
    ):
        main([*case.arguments(), "--json"])
    return dict(json.loads(out.getvalue()))


def averaged_h1() -> tuple[np.ndarray, np.ndarray]:
    """Frequencies [Hz] and H1 of the plate from cross-spectra averaged over lines.

    That leaves out what comes long before or after the force: its ripples in the FRF go from line to line.
    """
    blows = read_campaign(REAL / "mssp_plate_sweep").blows
    force = np.array([blow.force for blow in blows])
    response = np.array([blow.response[0] for blow in blows])
    frequency, s_ff, _, s_fr = spectra(force, response, 1 / blows[0].step)
    window = np.hanning(2 * REACH + 3)[1:-1]
    smooth = [np.convolve(part, window, mode="same") for part in (s_fr, s_ff)]
    return frequency, smooth[0] / smooth[1]


def write_references() -> None:
    """sdypy-EMA on the averaged H1, at the three orders at which the given references have it."""
    from importlib.metadata import version

    from sdypy import EMA

    axis, value = averaged_h1()
    keep = axis <= 500
    start = [references()[("mssp_plate_sweep", number)][0].frequency for number in range(1, 7)]
    spacing = axis[1]
    peer = f"sdypy-EMA {version('sdypy-EMA')} (lscf), averaged"
    note = f"as before from cross-spectra averaged over ±{REACH * spacing:g} Hz; benchmarks/ema_real.py"
    with AVERAGED.open("w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["dataset", "peer", "mode", "natural_frequency_hz", "damping_ratio", "note"])
        for order in (40, 60, 80):
            with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
                model = EMA.Model(
                    value[keep][None], axis[keep], lower=60, upper=500, pol_order_high=order,
                    frf_form="accelerance",
                )  # fmt: skip
                model.get_poles(method="lscf", show_progress=False)
                model.select_closest_poles(start)
            for number, (f, z) in enumerate(zip(model.nat_freq, model.nat_xi, strict=True), start=1):
                table.writerow(
                    ["mssp_plate_sweep", peer, number, f"{f:.4f}", f"{z:.7f}", f"order {order}, {note}"]
                )


LEAD = """\
Made by `benchmarks/ema_real.py`, which calls `flexmodal fit` on the campaigns in `tests/data/real`, each
with its origin and licence there. ± is half the 95 % interval, in brackets its parts by noise and by
choices of the analyst; of LSCF that is not refined it is the scatter over the orders. References: the
programs and ways that `reference_results.csv` lists; none of them states an uncertainty. Averaged: the
same program on the plate's cross-spectra averaged over ±1 Hz (`reference_averaged.csv`). The gap is that
from the mean of both. In: how many of them lie in the interval of ζ."""
END = """\
The plate's FRF ripples from line to line, which stands for a delay of 0.9 s (or 1.1 s, as the record is
2 s long); a plate damped by 2 % is at rest after a tenth of that. LSCF, theirs as ours where it is not
refined, takes ripples for lighter damping: with the plate's ripples on an FRF whose fifth mode is damped
by 2.90 % it finds 2.43 %, and 1.37 % for 2.08 % at the third ([ema_ripple](ema_ripple.md)). That is why
least squares, which goes through the middle of the ripples, holds the averaged references of the fifth
mode and not those of the FRF as it stands. These three are moreover one pole of one order, picked three
times; run by run the same program gives 2.1 to 2.8 %. At the sixth mode the FRF has a shoulder at
470 Hz, a mode of its own. One mode for both gets 3.73 %, and how many modes a band holds is no part of
the interval; both, with real residual terms, since complex ones take the place of the smaller, get
3.1 %, and theirs 2.9 to 3.3 % in the FRF as it stands at the orders 8 to 22. At 60 and 80, where it is
4.1 and 1.1 %, several poles lie there. Half-power bands of the
beam are 0.04 to 0.25 of one line: peak picking and circle fit refuse them or say so, and the two
references of its first mode are a sixth apart, those of its sixth a twelfth."""


def main() -> None:
    from tables import write

    if "--references" in sys.argv:
        write_references()
    found = [comparison for case in CASES for comparison in compared(case, run(case))]
    write(
        "ema_real",
        "Modes of real measurements",
        LEAD.replace("\n", " "),
        [
            "data, mode: options",
            "frequency [Hz]",
            "references [Hz]",
            "gap [%]",
            "ζ [%]",
            "references ζ [%]",
            "in",
            "averaged ζ [%]",
            "in",
        ],
        [_cells(one) for one in found],
        END.replace("\n", " "),
    )


def _cells(one: Comparison) -> list[str]:
    from flexmodal.ema.table import decimals

    stated, frequency, damping = one.row["uncertainty"], one.row["frequency"], 100 * one.row["damping_ratio"]
    reach = (stated["frequency_95"][1] - stated["frequency_95"][0]) / 2
    width = 50 * (stated["damping_ratio_95"][1] - stated["damping_ratio_95"][0])
    digits = decimals(width, damping)
    choice = 196 * stated["choices"]["damping_ratio"]
    noise = np.sqrt(max(width**2 - choice**2, 0.0))
    frequencies = [reference.frequency for reference in one.references]
    options = " ".join(one.case.options)
    return [
        f"{one.case.folder}, {one.number}" + (f": `{options}`" if options else ""),
        f"{frequency:.3f} ± {reach:.3f}",
        f"{min(frequencies):.3f}–{max(frequencies):.3f}",
        f"{100 * one.gap:+.3f}",
        f"{damping:.{digits}f} ± {width:.{digits}f} ({noise:.{digits}f}, {choice:.{digits}f})",
        *_dampings(one, averaged=False),
        *_dampings(one, averaged=True),
    ]


def _dampings(one: Comparison, *, averaged: bool) -> tuple[str, str]:
    """Range of the references and how many are held."""
    theirs = [100 * value for value in one.dampings(averaged=averaged)]
    if not theirs:
        return "–", "–"
    return f"{min(theirs):.4f}–{max(theirs):.4f}", f"{one.held(averaged=averaged)} of {len(theirs)}"


if __name__ == "__main__":
    main()
