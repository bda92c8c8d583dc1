"""Do the lobes agree with printed values, with each other and with a cut simulated tooth by tooth?

Writes docs/tables/machining.md and draws docs/pictures/machining_lobes.png: the benchmark cutter of
Insperger and Stépán, its limit by three methods, and simulated cuts on a grid of speeds and depths.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from tables import write

from flexmodal.machining import (
    Cut,
    CutFrame,
    Cutter,
    CuttingForce,
    Engagement,
    ModelTip,
    ToolMode,
    average,
    immersion_angles,
    modal_tip,
    multipliers,
    simulate,
    stability_lobes,
    unconditional_depth,
)
from flexmodal.report import PALETTE, write_figure

PICTURES = Path(__file__).parents[1] / "docs" / "pictures"
STIFFNESS = 0.03993 * (2 * math.pi * 922) ** 2
KICK = (1e-3, 7e-4, 0.0)
PRINTED = {2e-4: 0.8192, 5e-4: 1.0726, 7e-4: 1.2196, 1e-3: 1.4039}
"""Largest multiplier by depth [m], slot at 5000 rev/min: Ding and others, IJMTM 50 (2010) 502."""
SPEEDS = (9000.0, 15000.0, 19000.0, 21000.0)


@dataclass(frozen=True)
class Case:
    """A cut of the benchmark cutter."""

    name: str
    immersion: float
    milling: str
    axes: str
    helix: float = 0.0
    teeth: int = 2

    def build(self) -> tuple[Cut, ModelTip]:
        """The cut and its tip."""
        entry, leaving = immersion_angles(self.immersion, self.milling)
        modes = tuple(ToolMode(axis, 922.0, 0.011, STIFFNESS) for axis in self.axes)
        cut = Cut(
            Cutter(self.teeth, 0.01, helix=self.helix),
            CuttingForce(6e8, 1 / 3),
            Engagement(entry, leaving, (5000.0, 25000.0)),
            CutFrame("tool", "+z", "+x"),
            modes,
        )
        return cut, modal_tip(modes)


CASES = (
    Case("slot, one direction", 1.0, "down", "x"),
    Case("slot, one direction, four teeth", 1.0, "down", "x", teeth=4),
    Case("half immersion, up-milling", 0.5, "up", "xy"),
    Case("a twentieth, down-milling", 0.05, "down", "xy"),
    Case("a twentieth, down-milling, 30° helix", 0.05, "down", "xy", math.radians(30)),
)


def main() -> None:
    rows = [row for case in CASES for row in limits(case)]
    write(
        "machining",
        "Stability limits by four routes",
        "Made by `benchmarks/machining_checks.py`. One or two equal modes of 922 Hz, 1.1 %, 0.03993 kg; "
        "K_t = 6·10⁸, K_n = 2·10⁸ N/m²; two teeth unless said (Insperger and Stépán 2004). Depths in mm. The "
        "last column is where a kick neither grows nor dies in the cut simulated tooth by tooth, 200 steps "
        "a tooth; a star marks period doubling.",
        ["cut", "speed [rev/min]", "zero-order", "multi-frequency", "semi-discretisation", "simulated"],
        rows,
        "\n".join(multiplier_lines()),
    )
    draw(CASES[0])


def multiplier_lines() -> list[str]:
    """Printed multipliers beside ours, as a second table."""
    cut, tip = CASES[0].build()
    lines = [
        "Largest multiplier of the slot in one direction at 5000 rev/min, against the reference values of "
        "Ding and others (2010); 200 of our intervals give those, more give 0.1 to 0.2 % more:",
        "",
        "| depth [mm] | printed | 200 intervals | 800 intervals | growth in the simulated cut |",
        "|---|---:|---:|---:|---:|",
    ]
    for depth, printed in PRINTED.items():
        ours = [abs(multipliers(tip, cut, 5000.0, depth, intervals=n)[0]) for n in (200, 800)]
        done = simulate(tip, cut, 5000.0, depth, periods=110, steps=400, kick=KICK, linear=True)
        values = f"{ours[0]:.4f} | {ours[1]:.4f} | {done.growth(60):.4f}"
        lines.append(f"| {1e3 * depth:g} | {printed:.4f} | {values} |")
    tlusty = 2 * STIFFNESS * 0.011 * 1.011 / -average(cut)[0, 0]
    found = unconditional_depth(tip, cut)[0]
    lines += [
        "",
        "Depth stable at any speed, in one direction: "
        f"{1e3 * found:.6f} mm; 2kζ(1 + ζ)/K of Tlusty is {1e3 * tlusty:.6f} mm.",
    ]
    return lines


def limits(case: Case) -> list[list[str]]:
    cut, tip = case.build()
    speeds = np.array(SPEEDS) * 2 / case.teeth
    found = {
        method: stability_lobes(tip, cut, method=method, speeds=speeds)
        for method in ("zero-order", "multi-frequency", "semi-discretisation")
    }
    rows = []
    for place, speed in enumerate(speeds):
        depths = [one.depth[place] for one in found.values()]
        flips = [one.flip[place] for one in found.values()]
        simulated = bisect(tip, cut, float(speed), float(depths[1]))
        cells = [f"{1e3 * d:.4f}{'*' if flip else ''}" for d, flip in zip(depths, flips, strict=True)]
        rows.append([case.name, f"{speed:g}", *cells, f"{1e3 * simulated:.4f}"])
        print(rows[-1])
    return rows


def bisect(tip: ModelTip, cut: Cut, speed: float, near: float) -> float:
    """Depth where a kick neither grows nor dies: regula falsi on the logarithm of its growth."""
    depths = [0.93 * near, 1.07 * near]
    rates = [rate(tip, cut, speed, depth) for depth in depths]
    for _ in range(2):
        middle = depths[0] - rates[0] * (depths[1] - depths[0]) / (rates[1] - rates[0])
        here = rate(tip, cut, speed, middle)
        side = int(here > 0)
        depths[side], rates[side] = middle, here
    return depths[0] - rates[0] * (depths[1] - depths[0]) / (rates[1] - rates[0])


def rate(tip: ModelTip, cut: Cut, speed: float, depth: float) -> float:
    """Logarithm of the growth of a kick in a tooth period."""
    done = simulate(tip, cut, speed, depth, periods=120, steps=200, kick=KICK, linear=True)
    return math.log(done.growth(50))


def draw(case: Case) -> None:
    from matplotlib.figure import Figure

    cut, tip = case.build()
    figure = Figure(figsize=(7.8, 5.0), layout="constrained")
    axes = figure.subplots()
    styles = {"zero-order": "--", "multi-frequency": "-"}
    for place, (method, style) in enumerate(styles.items()):
        found = stability_lobes(tip, cut, method=method, speeds=160)
        axes.plot(
            found.speed, 1e3 * found.depth, style, color=PALETTE[1 - place], linewidth=1.7, label=method
        )
    speed, depth = np.meshgrid(np.linspace(5500, 24500, 20), np.linspace(0.3, 4.2, 14))
    stable = np.array(
        [
            simulate(
                tip, cut, float(s), float(d) * 1e-3, periods=110, steps=100, kick=KICK, linear=True
            ).growth(40)
            < 1
            for s, d in zip(speed.ravel(), depth.ravel(), strict=True)
        ]
    ).reshape(speed.shape)
    axes.plot(speed[stable], depth[stable], ".", color="0.25", markersize=5, label="simulated, stable")
    axes.plot(
        speed[~stable], depth[~stable], "x", color=PALETTE[3], markersize=4.5, label="simulated, chatter"
    )
    axes.set_xlabel("Spindle speed [rev/min]")
    axes.set_ylabel("Axial depth of cut [mm]")
    axes.set_xlim(5000, 25000)
    axes.set_ylim(0, 4.4)
    axes.grid(True, color="0.9", linewidth=0.6)
    axes.set_title("Slot, one mode of 922 Hz, two teeth (Insperger and Stépán 2004)", loc="left", fontsize=11)
    figure.legend(fontsize=9, loc="outside lower center", ncols=4)
    write_figure(figure, PICTURES / "machining_lobes.png", overwrite=True)
    print(PICTURES / "machining_lobes.png")


if __name__ == "__main__":
    main()
