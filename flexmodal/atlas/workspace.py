"""Where the tool comes to and how good the best posture there is: a map of the workspace."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Bool, Float, Int

from flexmodal.atlas.atlas import Atlas
from flexmodal.atlas.best import scan
from flexmodal.atlas.near import Spot
from flexmodal.atlas.reach import reach
from flexmodal.atlas.task import Task
from flexmodal.errors import Fault, FlexmodalError, InvalidRequest
from flexmodal.report import Column, Picture, Section, Table, drawing, new_figure, page_text, write_page
from flexmodal.report.figure import FITTED

PLANES = ("xz", "xy", "yz")
MOST_CELLS = 400
"""Along a side."""


@dataclass(frozen=True, eq=False)
class WorkspaceMap:
    """The best value over each cell of a plane that the tool was seen in."""

    plane: str
    edges: tuple[Float[np.ndarray, " first_edge"], Float[np.ndarray, " second_edge"]]
    """Of the cells along both axes [m]."""
    value: Float[np.ndarray, "first second"]
    """By the task; not a number where no posture of the atlas brings the tool."""
    count: Int[np.ndarray, "first second"]
    """Postures in each cell."""
    unit: str
    larger_is_better: bool
    outside: Bool[np.ndarray, "first second"]
    """Where the best posture is outside what was struck; nowhere in an atlas of the robot itself."""


def workspace_map(
    atlas: Atlas,
    task: Task,
    *,
    plane: str = "",
    cells: int = 60,
    advance: Callable[[], None] = lambda: None,
) -> WorkspaceMap:
    """Map an atlas over the places of the tool.

    Args:
        atlas: to look in.
        task: what is asked of a posture.
        plane: "xz", "xy" or "yz"; the one the tool sweeps widest if empty.
        cells: along the longer side.
        advance: called after each chunk, which is read once for its places and once for its values.

    Raises:
        InvalidRequest: no such plane, a number of cells out of range, a task it has nothing for.
        FlexmodalError: nothing is there yet, or a chunk is spoilt.
    """
    faults = []
    if plane and plane not in PLANES:
        faults.append(Fault("call", "plane", repr(plane[:20]), ", ".join(PLANES)))
    if not 1 <= cells <= MOST_CELLS:
        faults.append(Fault("call", "cells", str(cells), f"1 to {MOST_CELLS}"))
    if faults:
        raise InvalidRequest(faults)
    low, high = _reach(atlas)
    wide = high - low
    plane = plane or max(PLANES, key=lambda one: wide["xyz".index(one[0])] * wide["xyz".index(one[1])])
    axes = ["xyz".index(name) for name in plane]
    step = max(wide[axes].max(), 1e-6) / cells
    edges = [_edges(low[one], high[one], step) for one in axes]
    shape = (len(edges[0]) - 1, len(edges[1]) - 1)
    larger = task.larger(atlas.quantity)
    worst = -np.inf if larger else np.inf
    value, count = np.full(shape, worst), np.zeros(shape, dtype=np.int64)
    within, better = np.full(shape, worst), np.maximum if larger else np.minimum
    for some in scan(atlas, task, advance):
        seen = ~np.isnan(some.value)
        cell = tuple(
            np.clip(np.searchsorted(edge, some.tool[seen, one], side="right") - 1, 0, len(edge) - 2)
            for edge, one in zip(edges, axes, strict=True)
        )
        better.at(value, cell, some.value[seen])
        better.at(within, cell, np.where(some.inside[seen], some.value[seen], worst))
        np.add.at(count, cell, 1)
    outside = (count > 0) & (within != value)
    value[count == 0] = np.nan
    unit = task.unit(atlas.quantity)
    return WorkspaceMap(plane, (edges[0], edges[1]), value, count, unit, larger, outside)


def _reach(atlas: Atlas) -> tuple[np.ndarray, np.ndarray]:
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for number in atlas.standing:
        _, region = atlas.layout.region(number)
        with atlas.reading():
            tool = atlas.dataset["tool"][region].values.reshape(-1, 3)
        low, high = np.minimum(low, tool.min(axis=0)), np.maximum(high, tool.max(axis=0))
    if not np.all(np.isfinite(low)):
        raise FlexmodalError(f"{atlas.path}: no chunk is there yet; compute the atlas first")
    return low, high


def _edges(low: float, high: float, step: float) -> np.ndarray:
    count = max(1, int(np.ceil((high - low) / step - 1e-9)))
    return np.linspace(low, max(high, low + step), count + 1)


@drawing
def draw_map(found: WorkspaceMap, title: str) -> Any:
    """The map as a figure; values over several decades on a logarithmic scale.

    Args:
        found: the map.
        title: above it.
    """
    from matplotlib.colors import LogNorm

    figure = new_figure(7.5, 6.0)
    axes = figure.subplots()
    shown = found.value[np.isfinite(found.value)]
    low, high = (
        np.percentile(shown, [2, 98]) if len(shown) else (0.0, 1.0)
    )  # a singular posture tells nothing
    log = low > 0 and high > 10 * low
    scale: dict[str, Any] = {"norm": LogNorm(low, high)} if log else {"vmin": low, "vmax": high}
    colours = "cividis" if found.larger_is_better else "cividis_r"
    held = np.ma.masked_invalid(found.value.T)
    mesh = axes.pcolormesh(*found.edges, held, cmap=colours, rasterized=True, **scale)
    if found.outside.any():
        middles = [(edge[:-1] + edge[1:]) / 2 for edge in found.edges]
        first, second = np.nonzero(found.outside)
        size = 4 + 600 / max(found.value.shape)
        label = "the best posture is outside what was struck"
        at = middles[0][first], middles[1][second]
        axes.scatter(*at, s=size, color=FITTED, marker="x", linewidths=1.2, label=label)
        axes.legend(loc="lower left", bbox_to_anchor=(0.0, -0.28))
    word = "largest" if found.larger_is_better else "smallest"
    figure.colorbar(mesh, ax=axes, extend="both", label=f"{word} there [{found.unit}]")
    axes.set_xlabel(f"{found.plane[0]} of the tool [m]")
    axes.set_ylabel(f"{found.plane[1]} of the tool [m]")
    axes.set_aspect("equal")
    axes.set_title(title)
    return figure


def write_map_page(
    atlas: Atlas,
    found: WorkspaceMap,
    best: list[Spot],
    path: Path,
    *,
    what: str,
    task: Task | None = None,
    overwrite: bool = False,
) -> None:
    """Write a map as a page that needs no network, with the best postures below it.

    Args:
        atlas: of which it is.
        found: the map.
        best: the best postures.
        path: a new `.html` file.
        what: the task in words.
        task: by which the best were found; all lines of the first pair if None.
        overwrite: replace an existing file.

    Raises:
        OutputExists: the file exists.
        NotWritten: the disk is full, or the folder may not be written.
    """
    title = f"{atlas.facts['robot']}: {what}"
    seen = int(found.count.sum())
    lead = (
        f"Each cell shows the best of the postures that bring the tool there, {seen:,} in all, out of "
        f"{len(atlas.standing)} of {atlas.layout.chunks} chunks of the atlas. White: none does."
    )
    if atlas.source is not None:
        lead += (
            " Crossed: the best posture there has a joint outside the range that was struck. Receptances "
            f"{atlas.source['verdict']}."
        )
    picture = Picture(lambda: draw_map(found, title), f"Map of the workspace: {what}")
    columns = [Column("Value", found.unit), Column("Tool x, y, z", "m")]
    columns += [Column(name, "rad or m") for name in atlas.joints]
    rows = [
        [
            f"{one.value:.5g}",
            ", ".join(f"{x:.4f}" for x in one.tool),
            *(f"{v:.4f}" for v in one.posture.values()),
        ]
        for one in best
    ]
    if atlas.source is not None:
        columns += [Column("95 % band", found.unit), Column("Joints outside what was struck")]
        told = [reach(atlas, task or Task(), one) for one in best]
        rows = [
            [*row, f"{one.low:.3g} to {one.high:.3g}", str(one.beyond)]
            for row, one in zip(rows, told, strict=True)
            if one is not None
        ]
    text = page_text(title, [lead, picture], [Section("The best postures", [Table(columns, rows)])])
    write_page(path, text, overwrite=overwrite)
