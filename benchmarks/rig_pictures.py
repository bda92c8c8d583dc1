"""What does a blow of the virtual rig look like, and what do two hidden effects do to the FRF?

Draws docs/pictures/rig.png: force and response of one blow, then amplitude, phase and coherence of
an FRF with nothing hidden, with a bending link, and with dry friction at two force levels.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import flexmodal
from flexmodal.report import PALETTE, write_figure
from flexmodal.rig import Hide, RigResult, simulate

PICTURES = Path(__file__).parents[1] / "docs" / "pictures"
HIDDEN = {
    "nothing hidden": (),
    "link_1 bends": (Hide("link_flexibility", "link_1", {"bending_stiffness": 1.5e5}),),
    "dry friction in q2": (Hide("coulomb_friction", "q2", {"torque": 6.0}),),
}


def main() -> None:
    from matplotlib.figure import Figure

    robot = flexmodal.load("fanuc_s360")
    found = {
        name: simulate(
            robot, postures=["configuration_2"], points=3, references=["location_1:+z"], trials=2,
            hide=hide, seed=1, parameter_error=0.0,
        )
        for name, hide in HIDDEN.items()
    }  # fmt: skip
    figure = Figure(figsize=(9.2, 7.4), layout="constrained")
    grid = figure.add_gridspec(3, 2, height_ratios=[1.6, 0.8, 0.8], width_ratios=[1, 1.5])
    draw_blow(figure, grid, found["nothing hidden"])
    draw_frfs(figure, grid, found)
    PICTURES.mkdir(parents=True, exist_ok=True)
    write_figure(figure, PICTURES / "rig.png", overwrite=True)
    print(PICTURES / "rig.png")


def draw_blow(figure, grid, result: RigResult) -> None:
    blow = result.campaign.blows[0]
    pulse, whole = figure.add_subplot(grid[0, 0]), figure.add_subplot(grid[1:, 0])
    start = float(blow.time[np.argmax(blow.force)])
    near = np.abs(blow.time - start) < 0.04
    pulse.plot(1e3 * (blow.time[near] - start), blow.force[near], color=PALETTE[0], marker="o", markersize=3)
    pulse.set_xlabel("Time from the peak [ms]")
    pulse.set_ylabel("Force [N]")
    pulse.set_title("One blow, soft tip, as sampled", loc="left", fontsize=10)
    shown = blow.time < 1.2
    whole.plot(blow.time[shown], blow.response[0, shown], color=PALETTE[1], linewidth=0.9)
    whole.set_xlabel("Time in the record [s]")
    whole.set_ylabel("Acceleration [m/s²]")
    whole.set_title("location_1, along +z", loc="left", fontsize=10)
    for axes in (pulse, whole):
        axes.grid(True, color="0.88", linewidth=0.6)


def draw_frfs(figure, grid, found: dict[str, RigResult]) -> None:
    upper = figure.add_subplot(grid[0, 1])
    middle = figure.add_subplot(grid[1, 1], sharex=upper)
    lower = figure.add_subplot(grid[2, 1], sharex=upper)
    curves = [("nothing hidden", 1, "-"), ("link_1 bends", 1, "--"), ("dry friction in q2", 1, "-."),
              ("dry friction in q2", 2, ":")]  # fmt: skip
    for number, (name, trial, style) in enumerate(curves):
        frfs = found[name].campaign.frfs
        assert frfs is not None
        outer = found[name].plan.points[0].id
        one = frfs.select(response=outer, trial=trial)
        force = found[name].plan.trials[trial - 1].force_peak
        label = f"{name}, {force:g} N" if "friction" in name else name
        keep = (frfs.frequency >= 2) & (frfs.frequency <= 200)
        f, h = frfs.frequency[keep], one.value[0, keep]
        given = {"color": PALETTE[number], "linestyle": style, "linewidth": 1.3, "label": label}
        upper.plot(f, np.abs(h), **given)
        middle.plot(f, np.degrees(np.angle(h)), **given)
        lower.plot(f, one.coherence[0, keep], **given)
    upper.set_xscale("log")
    upper.set_yscale("log")
    upper.set_xlim(2, 200)
    upper.set_xticks([2, 5, 10, 20, 50, 100, 200])
    upper.xaxis.set_major_formatter("{x:g}")
    upper.xaxis.set_minor_formatter("")
    upper.set_ylabel("Inertance [m/(s²·N)]")
    upper.set_title("location_1:+z per location_1:+z, H1 of three blows", loc="left", fontsize=10)
    upper.legend(fontsize=8, framealpha=0.9)
    middle.set_ylabel("Phase [°]")
    middle.set_ylim(-190, 190)
    middle.set_yticks([-180, -90, 0, 90, 180])
    lower.set_ylabel("Coherence [–]")
    lower.set_ylim(0.8, 1.01)
    lower.set_xlabel("Frequency [Hz]")
    for axes in (upper, middle, lower):
        axes.grid(True, which="both", color="0.9", linewidth=0.5)


if __name__ == "__main__":
    main()
