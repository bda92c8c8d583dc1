"""Ports that hold another one, and those that one holds: each begins where the fit of the other ended."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.lawfree.port import Port, Wider
from flexmodal.diagnosis.lawfree.sighting import Sighting, Start


def widened(one: Sighting, wider: Wider, context: Context) -> tuple[Port, Start]:
    """A wider port in place of the last one.

    Args:
        one: where that ended.
        wider: the kind of port that can do more.
        context: of the diagnosis.
    """
    model, state = one.profile.model, one.state
    values = model.hypothesis.values_of(model.hypothesis.placed[-1], model.space.values(state.x))
    port, own = Port.at(wider.kind, one.port.where, context), model.spans[-1]
    found = [wider.begin(context, one.port.where, values, each[own] * model.size[own]) for each in state.z]
    size = wider.kind.sizes(context, port.where, model.observations.axis.frequency[model.lines])
    z = np.concatenate([state.z[:, : own.start], np.array(found) / size], axis=1)
    about = wider.kind.motions.parameters(context, port.where)
    own_geometry = [one.coordinate(values[one.name]) if one.name in values else 0.0 for one in about]
    return port, (np.concatenate([state.x[: len(state.x) - len(model.geometry[-1])], own_geometry]), z)


def parts(one: Sighting, context: Context) -> Iterator[tuple[Port, Start]]:
    """The narrower ports that the last one holds: joints of a mechanism between two.

    A search from nothing may miss one of them that the wider one came to.

    Args:
        one: where that ended.
        context: of the diagnosis.
    """
    for kind, where, number in one.port.kind.parts(one.port.where):
        state, own = one.state, one.profile.model.spans[-1]
        z = np.concatenate([state.z[:, : own.start], state.z[:, own][:, [number]]], axis=1)
        yield Port.at(kind, where, context), (state.x, z)
