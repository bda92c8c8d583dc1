"""Bias and spread of each method on simulated FRFs with known poles and 1 % noise."""

from __future__ import annotations

import numpy as np
from tables import write

from flexmodal.ema import Choices, Measured, estimate

REPEATS = 60
AXIS = np.linspace(5.0, 100.0, 381)

CASES = {
    "one mode, ζ 4 %": ([50.0], [0.04]),
    "apart: 30, 50, 80 Hz, ζ 3 %": ([30.0, 50.0, 80.0], [0.03, 0.03, 0.03]),
    "close: 50, 54 Hz, ζ 3 % (4 Hz apart, bands 3 Hz)": ([50.0, 54.0], [0.03, 0.03]),
    "closer: 50, 52 Hz, ζ 3 %": ([50.0, 52.0], [0.03, 0.03]),
    "heavy: 30, 60 Hz, ζ 15 %": ([30.0, 60.0], [0.15, 0.15]),
}
METHODS = {
    "peaks": ("peaks", Choices()),
    "circle": ("circle", Choices()),
    "least squares": ("least-squares", Choices()),
    "LSCF, not refined": ("lscf", Choices(refine=False, highest_order=20)),
    "LSCF, refined": ("lscf", Choices(highest_order=20)),
}


def simulate(
    frequency: list[float], damping: list[float], rng: np.random.Generator
) -> tuple[Measured, np.ndarray]:
    """Two mobilities of real modes with 1 % noise of their maximum; also the residues [frf, mode]."""
    natural, ratio = 2 * np.pi * np.array(frequency), np.array(damping)
    pole = natural * (-ratio + 1j * np.sqrt(1 - ratio**2))
    shape = np.array([[1.0] * len(natural), [0.8, -0.9, 0.7][: len(natural)]])
    residue = shape * shape[:1] / (2j * pole.imag)
    s = 2j * np.pi * AXIS[:, None, None]
    value = (s * (residue / (s - pole) + residue.conj() / (s - pole.conj()))).sum(-1)
    sigma = 0.01 * np.max(np.abs(value), axis=0)
    noise = rng.normal(size=(2, *value.shape)) / np.sqrt(2)
    variance = np.broadcast_to(sigma**2, value.shape).copy()
    return Measured(AXIS, value + sigma * (noise[0] + 1j * noise[1]), "mobility", variance), residue


LEAD = f"""\
Made by `benchmarks/ema_methods.py`: two mobilities, 5 to 100 Hz in steps of 0.25 Hz, noise of 1 % of
the maximum, {REPEATS} repetitions with a fixed seed, peaks chosen automatically or by hand at 0.5 %
off. Bias ± standard deviation, relative, of the mode whose bias is worst; the residue is that of the
first FRF. Held: how often the whole 95 % interval, choices included, holds the truth, least of all
modes and of frequency, damping and residue; in brackets that of the interval by noise alone."""
END = """\
The circle fit takes the whole motion round a peak for one mode. Its residue is off by a few per cent
among modes that are well apart and by a third among heavily damped ones; where half-power bands touch
it breaks down. Its interval by noise does not tell; the whole one does, since it knows what least
squares finds with all modes at once. Close modes make one peak here, and poles that stay tell them
apart; told of both, peak picking still reads one peak twice. LSCF by itself is biased by noise, mostly
in damping, and its scatter over the orders does not tell; refining takes the bias out."""


def main() -> None:
    rows = []
    for title, (frequency, damping) in CASES.items():
        methods = dict(METHODS)
        if title.startswith("close"):
            by_hand = Choices(at=[1.005 * f for f in frequency])
            methods |= {f"{name}, by hand": (METHODS[name][0], by_hand) for name in list(METHODS)[:3]}
        for name, (method, choices) in methods.items():
            rng = np.random.default_rng(1)
            answers = [one_run(frequency, damping, method, choices, rng) for _ in range(REPEATS)]
            rows.append([f"{title}: {name}", *cells([one for one in answers if one is not None])])
    header = ["case: method", "all modes found", "frequency [%]", "ζ [%]", "residue [%]", "held [%]"]
    lead, end = (text.replace("\n", " ") for text in (LEAD, END))
    write("ema_methods", "Bias and spread of the methods", lead, header, rows, end)


def one_run(
    frequency: list[float], damping: list[float], method: str, choices: Choices, rng: np.random.Generator
) -> np.ndarray | None:
    """Relative error, whether the whole interval holds it, and whether that by noise does [mode number 3].

    None where some mode was not found.
    """
    measured, residue = simulate(frequency, damping, rng)
    found = estimate(measured, method, choices)
    near = [min(found.modes, key=lambda m: abs(m.frequency - f), default=None) for f in frequency]
    if None in near or len({id(mode) for mode in near}) < len(frequency):
        return None
    answer = []
    for k, mode in enumerate(near):
        true = np.array([frequency[k], damping[k], abs(residue[0, k])])
        away = np.array([mode.frequency, mode.damping_ratio, abs(mode.residue[0])]) - true
        whole, noise = mode.reach()[:3], 1.96 * mode.by_noise[:3]
        answer.append(np.stack([away / true, np.abs(away) <= whole, np.abs(away) <= noise], axis=1))
    return np.array(answer)


def cells(answers: list[np.ndarray]) -> list[str]:
    """How often all modes were found, bias and spread of each number, and how often the interval holds."""
    count = f"{len(answers)} of {REPEATS}"
    if len(answers) < 2:
        return [count, "–", "–", "–", "–"]
    table = np.array(answers)
    bias = 100 * table[..., 0].mean(axis=0)
    spread = 100 * table[..., 0].std(axis=0, ddof=1)
    worst = np.argmax(np.abs(bias), axis=0)
    whole, noise = (100 * table[..., which].mean(axis=0).min() for which in (1, 2))
    errors = [f"{bias[w, k]:+.2f} ± {spread[w, k]:.2f}" for k, w in enumerate(worst)]
    return [count, *errors, f"{whole:.0f} ({noise:.0f})"]


if __name__ == "__main__":
    main()
