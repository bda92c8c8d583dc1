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


def main() -> None:
    rows = []
    for title, (frequency, damping) in CASES.items():
        methods = dict(METHODS)
        if title.startswith("close"):  # one peak: a person has to say that there are two modes
            by_hand = Choices(at=[1.005 * f for f in frequency])
            methods |= {f"{name}, by hand": (METHODS[name][0], by_hand) for name in list(METHODS)[:3]}
        for name, (method, choices) in methods.items():
            rng = np.random.default_rng(1)
            errors, found_all = [], 0
            for _ in range(REPEATS):
                measured, residue = simulate(frequency, damping, rng)
                found = estimate(measured, method, choices)
                near = [min(found.modes, key=lambda m: abs(m.frequency - f), default=None) for f in frequency]
                if None in near or len({id(mode) for mode in near}) < len(frequency):
                    continue
                found_all += 1
                errors.append(
                    [
                        [
                            mode.frequency / frequency[k] - 1,
                            mode.damping_ratio / damping[k] - 1,
                            abs(mode.residue[0]) / abs(residue[0, k]) - 1,
                        ]
                        for k, mode in enumerate(near)
                    ]
                )
            cells = ["–"] * 3
            if len(errors) > 1:
                table = 100 * np.array(errors)
                bias, spread = table.mean(axis=0), table.std(axis=0, ddof=1)
                worst = np.argmax(np.abs(bias), axis=0)
                cells = [f"{bias[w, k]:+.2f} ± {spread[w, k]:.2f}" for k, w in enumerate(worst)]
            rows.append([f"{title}: {name}", f"{found_all} of {REPEATS}", *cells])
    write(
        "ema_methods",
        "Bias and spread of the methods",
        "Made by `benchmarks/ema_methods.py`: two mobilities, 5 to 100 Hz in steps of 0.25 Hz, noise "
        "of 1 % of the "
        f"maximum, {REPEATS} repetitions with a fixed seed, peaks chosen automatically. Bias ± "
        "standard deviation, "
        "relative, of the mode whose bias is worst; the residue is that of the first FRF.",
        ["case: method", "all modes found", "frequency [%]", "ζ [%]", "residue [%]"],
        rows,
        "The circle fit takes the whole motion round a peak for one mode. Its residue is off by a "
        "few per cent among "
        "modes that are well apart and by a third among heavily damped ones; where half-power bands "
        "touch it breaks "
        "down, and its interval does not tell, since that holds noise only. Close modes make one "
        "peak here: the "
        "automatic choice sees one, and least squares has to be told of both (`at=`, off by 0.5 % "
        "here). LSCF sees "
        "both; by itself it is biased by noise, mostly in damping, and refining takes the bias out.",
    )


if __name__ == "__main__":
    main()
