"""Peaks of 8 dB that a fit finds without a person, on simulated arms and on real measurements, beside peers.

What a peak is, and what a false mode, is decided here from the FRFs and from the structure that was struck,
never from a fit. `python benchmarks/ema_peaks.py` makes docs/tables/ema_peaks.md; the peers come with the
group `bench`.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from ema_peers import PEERS, Modes
from ema_selection import random_postures, true_modes

from flexmodal.campaign import Campaign, read_campaign
from flexmodal.ema import Choices, Fit, fit
from flexmodal.frf.form import convert
from flexmodal.model import Robot, load
from flexmodal.rig import Hide, simulate

HEIGHT = 8.0
"""Of a peak over the higher of its valleys [dB]."""
NEAR = 0.01
"""A mode belongs to a peak, or to a true mode, within this part of its frequency; a wide one within half its
half-power bandwidth."""
BUMP = 2.0
"""Of real data a mode is false where no FRF rises by so much near it [dB]."""
HEAVIEST = 0.3
"""Of real data a mode damped more is false."""
REAL = Path(__file__).parents[1] / "tests" / "data" / "real"
REAL_BANDS = (
    ("free_free_beam", (10.0, 990.0)),
    ("free_free_beam", (10.0, 600.0)),
    ("laboratory_hammer", (190.0, 235.0)),
    ("laboratory_hammer", (10.0, 490.0)),
    ("mssp_plate_sweep", (60.0, 500.0)),
    ("mssp_plate_sweep", (60.0, 300.0)),
)
"""Campaign and band [Hz]; a band that changes must not change what is found."""


@dataclass(frozen=True)
class Arm:
    """A robot of the rig, with joints that are all alike where its card says nothing of them."""

    robot: str
    hidden: tuple[str, ...]
    stiffness: float | None = None
    """[N·m/rad]."""
    damping: float | None = None
    """[N·m·s/rad]."""

    def load(self) -> Robot:
        """The robot as its card says, or with those joints."""
        if self.stiffness is None:
            return load(self.robot)
        return load(self.robot, stiffness=self.stiffness, damping=self.damping)

    def __str__(self) -> str:
        return f"{self.robot}, {' and '.join(self.hidden) or 'nothing hidden'}"


ARMS = (
    Arm("six_axis", ()),
    Arm("six_axis", ("local_absorber",)),
    Arm("six_axis", ("link_flexibility", "local_absorber")),
    Arm("ur5", ("local_absorber",), 1e4, 2.0),
    Arm("ur5", ("link_flexibility", "base_flexibility"), 1e4, 2.0),
    Arm("panda", ("local_absorber",), 1e4, 2.0),
    Arm("xarm7", ("link_flexibility",), 1e4, 2.0),
    Arm("kinova", ("local_absorber", "base_flexibility"), 5e3, 1.0),
)
LOOKED_AT, FRESH = range(1, 4), range(1001, 1004)
"""Seeds of the campaigns that were looked at while the choice was tuned, and of those that judge it."""
MODES = (6, 12)
"""Modes in the band of a posture that counts."""


@dataclass(frozen=True, eq=False)
class Case:
    """FRFs of one posture and what is known of them."""

    name: str
    axis: np.ndarray
    """[Hz]."""
    matrix: np.ndarray
    """Mobilities by line, response and reference."""
    ours: Fit
    true: tuple[tuple[float, float], ...] | None
    """Natural frequency [Hz] and damping ratio; None where nobody knows."""


@dataclass(frozen=True)
class Score:
    """What one program made of one case or several."""

    peaks: int = 0
    found: int = 0
    modes: int = 0
    false: int = 0
    missed: tuple[float, ...] = ()
    """[Hz]."""
    wrong: tuple[tuple[float, float], ...] = ()
    """Frequency [Hz] and damping ratio of false modes."""

    def __add__(self, other: Score) -> Score:
        return Score(*(getattr(self, name) + getattr(other, name) for name in self.__dataclass_fields__))


def case_of(name: str, one: Fit, true: Sequence[tuple[float, float]] | None) -> Case:
    """One posture's FRFs, as the fit had them, as a matrix."""
    measured = one.modes.measured
    value = convert(measured.value, measured.frequency, measured.form, "mobility")
    outputs = {place: k for k, place in enumerate(dict.fromkeys(p.response for p in one.places))}
    inputs = {place: k for k, place in enumerate(dict.fromkeys(p.reference for p in one.places))}
    matrix = np.zeros((len(value), len(outputs), len(inputs)), dtype=complex)
    for frf, place in enumerate(one.places):
        matrix[:, outputs[place.response], inputs[place.reference]] = value[:, frf]
    return Case(name, measured.frequency, matrix, one, None if true is None else tuple(true))


def rig_cases(arm: Arm, seed: int) -> Iterator[Case]:
    """Two postures drawn at random, of those with 6 to 12 modes in the band.

    Args:
        arm: what is struck at four points.
        seed: of the postures and of the campaign.
    """
    robot = arm.load()
    result = simulate(
        robot,
        postures=random_postures(robot, 2, seed),
        points=4,
        trials=2,
        hide=[Hide(one, height=10.0) for one in arm.hidden],
        seed=seed,
        time=False,
    )
    for one in fit(result.campaign, per="posture", choices=Choices(vary=False)):
        true = true_modes(result, one.posture)
        if MODES[0] <= len(true) <= MODES[1]:
            yield case_of(f"{arm}, seed {seed}, posture {one.posture}", one, true)


def real_cases() -> Iterator[Case]:
    """Every campaign in tests/data/real, in its band and in others."""
    for folder, band in REAL_BANDS:
        campaign: Campaign = read_campaign(REAL / folder)
        (one,) = fit(replace(campaign, band=band), per="posture", choices=Choices(vary=False))
        yield case_of(f"{folder}, {band[0]:g} to {band[1]:g} Hz", one, None)


def level_of(matrix: np.ndarray) -> np.ndarray:
    """Largest singular value at each line, a complex mode indicator function [dB]."""
    return np.asarray(20 * np.log10(np.linalg.norm(matrix, ord=2, axis=(1, 2))))


def peaks_of(case: Case) -> list[tuple[float, float]]:
    """Frequency and width of the peaks of 8 dB of the indicator [Hz].

    By SciPy's prominence, in the indicator as it stands and after a running median over three lines, which
    takes single lines of noise out.
    """
    from scipy.signal import find_peaks, medfilt

    level = level_of(case.matrix)
    places = find_peaks(level, prominence=HEIGHT)[0]
    steady = find_peaks(medfilt(np.pad(level, 2, mode="edge"), 3)[2:-2], prominence=HEIGHT)[0]
    kept = [int(place) for place in places if len(steady) and np.min(np.abs(steady - place)) <= 3]
    return [(float(case.axis[place]), width(case.axis, level, place)) for place in kept]


def width(axis: np.ndarray, level: np.ndarray, place: int) -> float:
    """Twice the way from a peak to the nearest line that lies 3 dB below it [Hz]."""
    below = np.flatnonzero(level < level[place] - 3)
    return 2 * float(np.min(np.abs(axis[below] - axis[place]))) if len(below) else float(np.ptp(axis))


def bumps_of(case: Case) -> np.ndarray:
    """Frequencies at which any FRF rises by 2 dB over its valleys [Hz]."""
    from scipy.signal import find_peaks

    curves = 20 * np.log10(np.abs(case.matrix.reshape(len(case.axis), -1)))
    return np.concatenate([case.axis[find_peaks(curve, prominence=BUMP)[0]] for curve in curves.T])


def scored(case: Case, modes: Modes) -> Score:
    """Peaks with a mode of their own, and modes where nothing is.

    Args:
        case: what was measured.
        modes: what a program found in it.
    """
    peaks = peaks_of(case)
    spacing = float(np.median(np.diff(case.axis)))
    pairs = paired(
        [(f, max(NEAR * f, w / 2, spacing)) for f, w in peaks], [frequency for frequency, _ in modes]
    )
    missed = tuple(f for number, (f, _) in enumerate(peaks) if number not in pairs)
    if case.true is not None:
        reach = [(f, max(NEAR, z) * f) for f, z in case.true]
        right = set(paired(reach, [frequency for frequency, _ in modes]).values())
        wrong = [mode for number, mode in enumerate(modes) if number not in right]
    else:
        bumps = bumps_of(case)
        wrong = [
            (f, z) for f, z in modes
            if z > HEAVIEST or not np.any(np.abs(bumps - f) <= max(NEAR * f, z * f, spacing))
        ]  # fmt: skip
    return Score(len(peaks), len(pairs), len(modes), len(wrong), missed, tuple(wrong))


def paired(places: Sequence[tuple[float, float]], frequencies: Sequence[float]) -> dict[int, int]:
    """Each place with the mode nearest to it within its reach, nearest pairs first, each mode once."""
    near = sorted(
        (abs(f - place) / reach, number, mode)
        for number, (place, reach) in enumerate(places)
        for mode, f in enumerate(frequencies)
        if abs(f - place) <= reach
    )
    found: dict[int, int] = {}
    for _, number, mode in near:
        if number not in found and mode not in found.values():
            found[number] = mode
    return found


def modes_by(case: Case, program: str) -> Modes:
    """What flexmodal or one of the peers finds."""
    if program == "flexmodal":
        return [(mode.frequency, mode.damping_ratio) for mode in case.ours.modes]
    return PEERS[program](case.axis, case.matrix)


PROGRAMS = ("flexmodal", *PEERS)


def scores(cases: Sequence[Case]) -> dict[str, Score]:
    """Of every program, over some cases."""
    total = {program: Score() for program in PROGRAMS}
    for case in cases:
        for program in PROGRAMS:
            total[program] += scored(case, modes_by(case, program))
    return total


LEAD = f"""\
Made by `benchmarks/ema_peaks.py`. Arms of the rig: two postures drawn at random for each seed, those with
{MODES[0]} to {MODES[1]} modes from 2 to 200 Hz, struck at two points and measured at four, two trials of
three blows, noise of 1 %, each effect hidden ten times the noise floor high. Real: every campaign in
`tests/data/real`, in its band and in another. All FRFs of a posture together, nothing chosen by hand. Peak:
of the largest singular value of the mobilities, {HEIGHT:g} dB over the higher of its valleys (SciPy's
prominence), as it stands and after a median over three lines.
Found: with a mode of its own within {100 * NEAR:g} %, or half the peak's width 3 dB down. False: of an arm a
mode without a mode of the structure that was struck within {100 * NEAR:g} % or half its half-power bandwidth;
of real data a mode damped by more than {100 * HEAVIEST:g} %, or near which no FRF rises by {BUMP:g} dB. The
peers: LSCF of sdypy-EMA and poly-reference LSCF of pyOMA2, both to order 40, what is stable in three tenths
of the orders (1 % in frequency, 5 % in damping)."""


def rows_of(name: str, cases: Sequence[Case]) -> tuple[list[str], dict[str, Score]]:
    """One row of the table."""
    of = scores(cases)
    row = [name, str(len(cases)), str(of["flexmodal"].peaks)]
    for program in PROGRAMS:
        row += [str(of[program].found), f"{of[program].false} of {of[program].modes}"]
    return row, of


def total_row(name: str, parts: Sequence[dict[str, Score]], cases: int) -> list[str]:
    """Sums with their shares."""
    row = [f"**{name}**", str(cases)]
    for program in PROGRAMS:
        whole = sum((part[program] for part in parts), Score())
        if program == "flexmodal":
            row.append(str(whole.peaks))
        row.append(f"{whole.found} ({100 * whole.found / whole.peaks:.1f} %)")
        row.append(f"{whole.false} of {whole.modes} ({100 * whole.false / max(whole.modes, 1):.1f} %)")
    return row


def main() -> None:
    from tables import write

    rows = []
    for name, seeds in (("looked at", LOOKED_AT), ("fresh", FRESH)):
        parts, count = [], 0
        for arm in ARMS:
            cases = [case for seed in seeds for case in rig_cases(arm, seed)]
            if not cases:
                continue
            print(name, arm, file=sys.stderr, flush=True)
            row, of = rows_of(f"{name}: {arm}", cases)
            rows.append(row)
            parts.append(of)
            count += len(cases)
        rows.append(total_row(f"arms, seeds {name} ({seeds[0]} to {seeds[-1]})", parts, count))
    real = list(real_cases())
    found = [rows_of(f"real: {case.name}", [case]) for case in real]
    rows += [row for row, _ in found]
    rows.append(total_row("real data", [of for _, of in found], len(real)))
    header = ["data", "postures", "peaks"]
    for program in PROGRAMS:
        header += [f"{program}: found", "false"]
    wrong = [f"{f:.4g} Hz in {case.name}" for case, (_, of) in zip(real, found, strict=True)
             for f, _ in of["flexmodal"].wrong]  # fmt: skip
    end = f"False on real data: {'; '.join(wrong) or 'none'}."
    write("ema_peaks", "Peaks found without a person", LEAD.replace("\n", " "), header, rows, end)


if __name__ == "__main__":
    main()
