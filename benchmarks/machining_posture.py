"""When does a better posture give a deeper cut, and when does it not?

The Fanuc of the thesis mills aluminium in its plane of motion in three postures: with its arm alone, with a
spindle, and with a slender tool. Draws docs/pictures/machining_posture.png.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

import flexmodal
from flexmodal.machining import Cut, ToolMode, modal_tip, read_cut, stability_lobes, tool_tip
from flexmodal.report import PALETTE, write_figure

ROOT = Path(__file__).parents[1]
PICTURES = ROOT / "docs" / "pictures"
POSTURES = {"configuration_1": "50°", "configuration_4": "90°", "configuration_7": "123°"}
SLENDER = 0.12
"""Stiffness of the slender tool's modes over that of the spindle in the file."""


def main() -> None:
    from matplotlib.figure import Figure

    robot = flexmodal.load("fanuc_s360")
    given = read_cut(ROOT / "robots" / "fanuc_s360" / "cuts" / "aluminium.toml")
    cut = replace(given, engagement=replace(given.engagement, spindle_speed=(600.0, 30000.0)))
    tools = {
        "arm alone": (),
        "arm and spindle": cut.modes,
        "arm and slender tool": tuple(softer(mode) for mode in cut.modes),
    }
    figure = Figure(figsize=(9.6, 6.4), layout="constrained")
    upper, lower = figure.subplots(2, 3, sharex=True, sharey="row", height_ratios=[2, 1])
    speed = np.geomspace(600, 30000, 500)
    for axes, below, (name, modes) in zip(upper, lower, tools.items(), strict=True):
        panel(axes, below, robot, replace(cut, modes=modes), speed, name)
    upper[0].set_ylabel("Axial depth of cut [mm]")
    lower[0].set_ylabel("Best over worst posture [–]")
    figure.suptitle(
        "Fanuc S-360, side milling aluminium, zero-order solution", x=0.01, ha="left", fontsize=12
    )
    write_figure(figure, PICTURES / "machining_posture.png", overwrite=True)
    print(PICTURES / "machining_posture.png")


def panel(axes, below, robot: flexmodal.Robot, cut: Cut, speed: np.ndarray, name: str) -> None:
    depths = []
    for place, (posture, angle) in enumerate(POSTURES.items()):
        found = stability_lobes(tool_tip(robot.at(posture), cut), cut, speeds=speed)
        depths.append(found.depth)
        shown = np.where(np.isfinite(found.depth), 1e3 * found.depth, np.nan)
        style = ("-", "--", "-.")[place]
        axes.plot(speed, shown, style, color=PALETTE[place], linewidth=1.6, label=f"first link at {angle}")
    if cut.modes:
        alone = stability_lobes(modal_tip(cut.modes), cut, speeds=speed)
        axes.plot(speed, 1e3 * alone.depth, ":", color="0.2", linewidth=1.5, label="tool alone, arm rigid")
    best, worst = np.max(depths, axis=0), np.min(depths, axis=0)
    ratio = np.where(np.isfinite(best), best, np.nan) / worst
    below.plot(speed, ratio, color="0.2", linewidth=1.6)
    print(name, {at: round(float(np.interp(at, speed, ratio)), 2) for at in (1000, 3000, 8000, 12000, 20000)})
    axes.set_title(name, loc="left", fontsize=10)
    axes.set_yscale("log")
    axes.set_ylim(0.02, 60)
    axes.yaxis.set_major_formatter("{x:g}")
    below.set_yscale("log")
    below.set_ylim(0.9, 30)
    below.yaxis.set_major_formatter("{x:g}")
    below.set_xscale("log")
    below.set_xlim(600, 30000)
    below.set_xticks([1000, 3000, 10000, 30000])
    below.xaxis.set_major_formatter("{x:g}")
    below.xaxis.set_minor_formatter("")
    below.set_xlabel("Spindle speed [rev/min]")
    axes.legend(fontsize=8, loc="upper left", framealpha=0.9)
    for one in (axes, below):
        one.grid(True, which="major", color="0.85", linewidth=0.6)
        one.grid(True, which="minor", color="0.94", linewidth=0.4)


def softer(mode: ToolMode) -> ToolMode:
    return replace(mode, stiffness=SLENDER * mode.stiffness)


if __name__ == "__main__":
    main()
