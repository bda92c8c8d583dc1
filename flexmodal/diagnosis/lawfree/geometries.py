"""Where a port may be, if its geometry matters: many places, the structures solved for all at once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from flexmodal.diagnosis.effects.effect import Placement
from flexmodal.diagnosis.lawfree.at_parameters import AtParameters
from flexmodal.diagnosis.lawfree.model import PortedModel, Unknown
from flexmodal.diagnosis.lawfree.port import Patterns, Port
from flexmodal.diagnosis.lawfree.profile import Profile, State
from flexmodal.errors import SingularResponse
from flexmodal.structure.assembly import Assembly

ROUGHLY = 3
"""One geometry in so many is tried for a rough look; odd, so that a grid's every value is met."""


def placed_best(
    profile: Profile, at: AtParameters, none: Unknown, most: int, *, roughly: bool = False
) -> list[State]:
    """The last port, of one stiffness, where a constant does most; the best first, none without a model.

    Args:
        profile: of the model.
        at: parameters; the port's own are those of the middle of its prior.
        none: functions, that of the last port zero.
        most: how many.
        roughly: whether only some of the places are tried.
    """
    model, last = profile.model, none.shape[1] - 1
    context, port = model.root.context, model.ports[-1]
    places = port.kind.geometries(context, port.where)[:: ROUGHLY if roughly else 1]
    at_all = _at_all(port, places, model)
    everywhere = replace(profile, model=replace(model, ports=(*model.ports[:-1], at_all)))
    there = AtParameters(everywhere.model, at.x)
    z = np.concatenate([none[:, :last], np.zeros((len(none), len(places), none.shape[2]))], axis=1)
    constants = [one for (one,) in port.kind.starts(context, port.where)]
    tried = there.residuals_with(z, range(len(places)), constants)
    try:
        costs = [(everywhere.misfit(residual), number, constant) for number, constant, residual in tried]
    except (np.linalg.LinAlgError, SingularResponse):  # no receptance even without it
        return []
    found = []
    for _, number, constant in sorted(costs)[:most]:
        z, x = none.copy(), at.x.copy()
        z[:, last] = constant
        for k in model.geometry[-1].tolist():
            parameter = model.space.parameters[k]
            x[k] = parameter.coordinate(places[number][parameter.name.rpartition(".")[2]])
        found.append(profile.state(x, z))
    return found


def _at_all(port: Port, places: Sequence[Mapping[str, float]], model: PortedModel) -> Port:
    """The port at several places together, with a function at each."""
    kind, context = port.kind, model.root.context

    def patterns(assembly: Assembly, placement: Placement) -> Patterns:
        assert kind.patterns is not None
        values = [{**placement.values, **one} for one in places]
        each = [kind.patterns(assembly, replace(placement, values=one)).stiffness for one in values]
        return Patterns(np.concatenate([one for one in each if one is not None]))

    def sizes(context: object, where: str, frequency: np.ndarray) -> np.ndarray:
        return np.repeat(kind.sizes(model.root.context, where, frequency), len(places), axis=0)

    names = tuple(str(number) for number in range(len(places)))
    several = replace(kind, functions=lambda context, where: names, sizes=sizes, patterns=patterns)
    return Port.at(several, port.where, context)
