"""Joints whose torque depends on how far they swing: torque over deflection, stiffness and loss."""

from __future__ import annotations

from functools import partial
from typing import Any

from flexmodal.diagnosis.joint_laws import joint_laws
from flexmodal.diagnosis.outcome import Diagnosis
from flexmodal.diagnosis.report.words import placed
from flexmodal.diagnosis.time_domain.swung import Swung
from flexmodal.report import Gallery, Parts, Picture, Text
from flexmodal.report.figure import DASHED, INK, NARROW, PALETTE, SOFT, drawing, log_axis, new_figure

_NOTE = (
    "The joint with what was found in it, swung steadily to and fro at the frequency at which it swings "
    "most, up to its largest swing under a blow of the campaign, and a third as far. Dashed: its straight "
    "spring alone. Stiffness and loss factor are those of the first harmonic, its own damper left out. "
    "Of a spring behind the joint's own that spring is drawn."
)


LITTLE = 0.01
"""Loss factor up to which the axis goes at least."""


def joint_parts(diagnosis: Diagnosis) -> Parts:
    """The section; empty where no joint has such a torque."""
    pictures = [
        Picture(
            partial(draw_swing, swing, placed(*key), sliding=_slides(diagnosis, key[1])),
            f"Torque of {key[1]} over its deflection; stiffness and loss factor over amplitude",
        )
        for key, swing in joint_laws(diagnosis)
    ]
    return [Gallery(pictures), Text(_NOTE, note=True)] if pictures else []


def _slides(diagnosis: Diagnosis, joint: str) -> bool:
    return bool(diagnosis.model.context.robot.urdf.joint_by_name[joint].is_prismatic)


@drawing
def draw_swing(swing: Swung, title: str, *, sliding: bool = False) -> Any:
    """Torque over deflection in the largest swing and a third of it; stiffness and loss over amplitude."""
    length, force = ("mm", "Force [N]") if sliding else ("mrad", "Torque [N·m]")
    spring = "N/m" if sliding else "N·m/rad"
    figure = new_figure(NARROW, 6.4)
    loop, stiff, loss = figure.subplots(3, 1, height_ratios=[2.2, 1.0, 1.0])
    smaller = int(abs(swing.amplitude - swing.amplitude[-1] / 3).argmin())
    for number, colour in ((-1, PALETTE[0]), (smaller, PALETTE[1])):
        loop.plot(1e3 * swing.deflection[number], swing.torque[number], color=colour)
    ends = swing.deflection[-1].min(), swing.deflection[-1].max()
    look = {"color": SOFT, "linestyle": DASHED, "linewidth": 1}
    loop.plot([1e3 * q for q in ends], [swing.straight * q for q in ends], **look)
    stiff.axhline(swing.straight, **look)
    loop.set(xlabel=f"Deflection [{length}]", ylabel=force)
    loop.set_title(title)
    for axes, values, says in (
        (stiff, swing.stiffness, f"Stiffness\n[{spring}]"), (loss, swing.loss_factor, "Loss factor [–]"),
    ):  # fmt: skip
        axes.plot(1e3 * swing.amplitude, values, color=INK)
        axes.set_xscale("log")
        axes.set(ylabel=says)
    stiff.set_ylim(0.0, 1.1 * max(swing.stiffness.max(), swing.straight))
    loss.set_ylim(0.0, max(1.1 * swing.loss_factor.max(), LITTLE))
    log_axis(loss.xaxis)
    loss.set_xlabel(f"Amplitude [{length}]")
    stiff.sharex(loss)
    return figure
