"""What the ripples in the plate's FRF do to dampings that are known: sdypy-EMA's LSCF, and least squares.

An FRF with chosen poles, made as like the plate's as these poles allow, takes the ripples that the measured
one has around its average over neighbouring lines, turned by a phase drawn at random. Beside it stands what
sdypy-EMA makes of the measurement itself: over the orders of its diagram, and run by run.
"""

from __future__ import annotations

import contextlib
import io
from collections.abc import Sequence

import numpy as np
from ema_real import PLATE_BANDS, REAL, averaged_h1
from tables import write

from flexmodal.campaign import estimate_frfs, read_campaign
from flexmodal.campaign.estimate import spectra
from flexmodal.ema import Choices, Measured, ModeEstimate, estimate

TRUE = (
    (77.0, 0.0245),
    (126.0, 0.0155),
    (213.5, 0.0208),
    (263.5, 0.0245),
    (347.3, 0.0290),
    (448.3, 0.0330),
)
"""Frequencies [Hz] and damping ratios to be found again, about those of the plate."""
BAND = (60.0, 500.0)
ORDERS = range(8, 40)
NEAR = 0.015
"""Relative distance from the true frequency at which a pole of the diagram is that mode's."""
REPETITIONS = 30


def measured_h1() -> tuple[np.ndarray, np.ndarray]:
    """Frequencies [Hz] and H1 of the plate, five runs."""
    frfs = estimate_frfs(read_campaign(REAL / "mssp_plate_sweep"))
    return frfs.frequency, frfs.value[0]


def ripples() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Frequencies [Hz], the averaged H1, and what the H1 as it stands has beside it, relative."""
    axis, value = measured_h1()
    _, smooth = averaged_h1()
    return axis[1:], smooth[1:], value[1:] / smooth[1:] - 1


def known(axis: np.ndarray, like: np.ndarray) -> np.ndarray:
    """Inertance with the true poles, the rest fitted to another one, each line by its relative error."""
    omega = 2 * np.pi * axis
    terms = [np.ones_like(axis), -1 / omega**2]
    for frequency, damping in TRUE:
        natural = 2 * np.pi * frequency
        pole = natural * (-damping + 1j * np.sqrt(1 - damping**2))
        one, other = 1 / (1j * omega - pole), 1 / (1j * omega - pole.conjugate())
        terms += [one + other, 1j * (one - other)]
    table = -(omega**2)[:, None] * np.array([*terms, 1j * terms[0], 1j * terms[1]]).T
    inside = (axis >= BAND[0]) & (axis <= BAND[1])
    equations = table[inside] / np.abs(like[inside, None])
    right = like[inside] / np.abs(like[inside])
    stacked = np.vstack([equations.real, equations.imag])
    size = np.linalg.norm(stacked, axis=0)
    found = np.linalg.lstsq(stacked / size, np.concatenate([right.real, right.imag]), rcond=None)[0] / size
    return np.asarray(table @ found)


def rippled(number: int) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies [Hz] and the known inertance with the plate's ripples, turned by a phase of this draw."""
    axis, smooth, ripple = ripples()
    phase = np.random.default_rng([7, number]).uniform(0, 2 * np.pi)
    return axis, known(axis, smooth) * (1 + ripple * np.exp(1j * phase))


def least_squares(axis: np.ndarray, value: np.ndarray, mode: int) -> ModeEstimate | None:
    """That mode in its band, called as in ema_real; None where nothing is found."""
    low, high = map(float, PLATE_BANDS[mode].split(":"))
    choices = Choices(band=(low, high), at=[(low + high) / 2], weighting="logarithmic")
    return next(iter(estimate(Measured(axis, value[:, None], "inertance"), choices=choices)), None)


def sdypy(axis: np.ndarray, value: np.ndarray) -> list[np.ndarray]:
    """Damping ratios [%] of each mode over the orders at which sdypy-EMA's diagram has it."""
    from sdypy import EMA

    keep = axis <= BAND[1]
    whole = np.concatenate([[0.0], value[keep]])[None]  # it takes the lines to begin at 0 Hz
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        model = EMA.Model(
            whole, np.append(0.0, axis[keep]), lower=BAND[0], upper=BAND[1],
            pol_order_high=max(ORDERS) + 1, frf_form="accelerance",
        )  # fmt: skip
        model.get_poles(method="lscf", show_progress=False)
    found = []
    for frequency, _ in TRUE:
        per_order = []
        for order in ORDERS:
            pole = np.asarray(model.all_poles[order])
            gap = np.abs(np.abs(pole) / (2 * np.pi * frequency) - 1)
            damping = -pole.real / np.abs(pole)
            near = (pole.imag > 0) & (gap < NEAR) & (damping > 0.003) & (damping < 0.1)
            if near.any():
                per_order.append(100 * damping[np.argmin(np.where(near, gap, np.inf))])
        found.append(np.array(per_order))
    return found


def single_runs() -> list[tuple[np.ndarray, np.ndarray]]:
    """Frequencies [Hz] and response over force of each run by itself."""
    runs = []
    for blow in read_campaign(REAL / "mssp_plate_sweep").blows:
        axis, s_ff, _, s_fr = spectra(blow.force[None], blow.response[:1], 1 / blow.step)
        runs.append((axis[1:], (s_fr / s_ff)[1:]))
    return runs


def _range(values: Sequence[float], middle: float | None = None) -> str:
    centre = float(np.mean(values)) if middle is None else middle
    return f"{centre:.2f} ({min(values):.2f}–{max(values):.2f})"


LEAD = f"""\
Made by `benchmarks/ema_ripple.py`: ζ [%]. An FRF with known poles takes the ripples of the plate's H1,
turned by {REPETITIONS} random phases; each way reads it as it reads the plate in
[ema_real](ema_real.md). sdypy-EMA: its LSCF in 60–500 Hz, median over the orders {ORDERS[0]} to
{ORDERS[-1]}. In brackets the range, of the FRF as measured that from the 5th to the 95th percentile of the
orders. Held: how often the 95 % interval of least squares holds what is true."""
END = """\
Without ripples LSCF finds what is true. With them it finds the fifth mode a sixth too light and the third a
third too light, as light as it finds them in the measurement. The first mode hardly stands out, and least
squares, too, is off there by more than its interval tells in a third of the draws. From run to run LSCF
scatters by more than the three reference orders tell, which for the fifth mode are one pole of one order,
picked three times: sdypy-EMA takes the nearest of all orders. Its highest orders rest on rounding: their
extremes change a little from run to run."""


def main() -> None:
    axis, smooth, _ = ripples()
    clean = sdypy(axis, known(axis, smooth))
    draws = [rippled(number) for number in range(REPETITIONS)]
    theirs = [[float(np.median(mode)) for mode in sdypy(*draw)] for draw in draws]
    frequency, value = measured_h1()
    real = sdypy(frequency[1:], value[1:])
    runs = [sdypy(*run) for run in single_runs()]
    rows = []
    for mode, (natural, damping) in enumerate(TRUE):
        ours = [one for one in (least_squares(*draw, mode) for draw in draws) if one is not None]
        held = sum(one.damping_interval()[0] <= damping <= one.damping_interval()[1] for one in ours)
        orders = np.percentile(real[mode], [5, 95]).tolist()
        rows.append([
            f"{mode + 1}, {natural:.1f} Hz",
            f"{100 * damping:.2f}",
            f"{np.median(clean[mode]):.2f}",
            _range([one[mode] for one in theirs]),
            _range([100 * one.damping_ratio for one in ours]),
            f"{held} of {REPETITIONS}",
            _range(orders, float(np.median(real[mode]))),
            _range([float(np.median(run[mode])) for run in runs]),
        ])  # fmt: skip
    header = [
        "mode", "true", "sdypy-EMA, no ripples", "sdypy-EMA, ripples", "least squares, ripples", "held",
        "sdypy-EMA, as measured", "sdypy-EMA, single runs",
    ]  # fmt: skip
    write("ema_ripple", "Ripples and damping", LEAD.replace("\n", " "), header, rows, END.replace("\n", " "))


if __name__ == "__main__":
    main()
