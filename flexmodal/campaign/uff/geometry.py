"""The geometry of a test as a universal file has it: nodes and the trace lines between them."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from flexmodal.campaign.uff.nodal import key_of, read_nodal
from flexmodal.campaign.uff.scan import NODES, TRACE_LINE, Other, UffContent, scan_uff
from flexmodal.errors import Fault, InvalidCampaign
from flexmodal.text.words import FaultList, listing

ALIKE = 1e-5
"""Relative difference of two places that are one, rounded differently."""

Place = tuple[float, float, float]


@dataclass(frozen=True)
class Geometry:
    """Nodes and lines, in the coordinates of whoever measured them."""

    nodes: Mapping[int, Place] = field(default_factory=dict)
    """Place of each node [m]."""
    lines: tuple[tuple[int, ...], ...] = ()
    """Nodes one after the other, of each stretch that is drawn without lifting the pen."""
    turned: tuple[int, ...] = ()
    """Nodes whose directions are along a coordinate system of their own, which is not read."""


def read_geometry(path: str | os.PathLike[str]) -> Geometry:
    """Read the nodes (datasets 15 and 2411) and trace lines (82) of a universal file.

    Args:
        path: of the file.

    Raises:
        InvalidCampaign: with every fault.
    """
    faults: list[Fault] = []
    file = Path(os.path.abspath(path))
    found = FaultList(file, faults)
    geometry = geometry_of(scan_uff(file, found), found)
    if faults:
        raise InvalidCampaign(faults)
    return geometry


def geometry_of(content: UffContent, faults: FaultList) -> Geometry:
    """The geometry among the datasets of a file; a trace line goes through nodes of the file alone.

    Args:
        content: of the file.
        faults: where faults go.
    """
    nodes: dict[int, Place] = {}
    turned: list[int] = []
    lines: list[tuple[int, ...]] = []
    for other in content.others:
        if other.kind in NODES:
            turned += _add_nodes(other, nodes, faults)
    for other in content.others:
        if other.kind == TRACE_LINE:
            lines += _lines(other, nodes, faults)
    return Geometry(nodes, tuple(lines), tuple(dict.fromkeys(turned)))


def _add_nodes(other: Other, nodes: dict[int, Place], faults: FaultList) -> list[int]:
    """Take up the nodes of a dataset; those with a coordinate system of their own for displacements."""
    table = read_nodal(other, faults)
    columns = [] if table is None else [table[name] for name in ("node_nums", "disp_cs", "x", "y", "z")]
    turned = []
    for number, system, x, y, z in zip(*columns, strict=True):
        node, place = int(number), (float(x), float(y), float(z))
        if node < 1 or node != number:
            faults.add(key_of(other), f"node {number:g}", "whole numbers from 1")
        elif node in nodes and not np.allclose(nodes[node], place, rtol=ALIKE, atol=1e-9):
            faults.add(key_of(other), f"node {node} at another place", "each node once, or at one place")
        else:
            nodes[node] = place
            turned += [node] if system != 0 else []
    return turned


def _lines(other: Other, nodes: Mapping[int, Place], faults: FaultList) -> list[tuple[int, ...]]:
    """A trace line, cut where the pen is lifted: at a 0."""
    table = read_nodal(other, faults)
    along = [] if table is None else [int(node) for node in table["nodes"]]
    if table is not None and int(table["n_nodes"]) != len(along):
        faults.add(key_of(other), f"{len(along)} nodes", f"{table['n_nodes']}, as it declares")
    unknown = sorted({node for node in along if node and node not in nodes})
    if unknown:
        allowed = "nodes of datasets 15 or 2411 of the same file, or 0 where the pen is lifted"
        faults.add(key_of(other), f"node {listing(map(str, unknown[:10]))}", allowed)
    found: list[list[int]] = [[]]
    for node in along:
        if node == 0:
            found.append([])
        elif not found[-1] or found[-1][-1] != node:
            found[-1].append(node)
    return [tuple(one) for one in found if len(one) > 1]
