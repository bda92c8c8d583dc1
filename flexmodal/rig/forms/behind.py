"""Something that gives behind the spring of a joint, with a hub between both."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from flexmodal.rig.effects.effect import Site, Stand
from flexmodal.rig.plant.assembly import PlantAssembly


def draw_hub(stand: Stand, random: np.random.Generator) -> dict[str, float]:
    """What turns between the joint's spring and the link behind it, beyond the band.

    Args:
        stand: whose band.
        random: drawn from twice.
    """
    return {
        "frequency": float(random.uniform(2.0, 3.5)) * stand.plan.band[1],
        "damping_time": float(random.uniform(2e-4, 1e-3)),
    }


def behind(what: str) -> Callable[[PlantAssembly, Site], None]:
    """The joint's own spring is stretched by q less what a hub, a flange or a spider gives."""

    def shape(assembly: PlantAssembly, site: Site) -> None:
        assembly.add_coordinates([f"{site.where} {what}"])
        given = assembly.row(f"{site.where} {what}")
        assembly.elongation[site.where] = assembly.stretch(site.where) - given

    return shape


def hold(assembly: PlantAssembly, site: Site, hub: np.ndarray, own: float, stiffest: float) -> None:
    """A spring behind the joint's; the hub swings at its frequency where it is held by the stiffest.

    Args:
        assembly: with the hub's coordinate.
        site: of the form, with `frequency` and `damping_time`.
        hub: row of what it turns by.
        own: stiffness of the spring [N·m/rad].
        stiffest: the most that holds it, beside the joint's spring [N·m/rad].
    """
    assembly.add_spring(hub, own, site["damping_time"] * own)
    held = site.stand.true.stiffness[site.where] + stiffest
    assembly.add_inertia(hub, held / (2 * np.pi * site["frequency"]) ** 2)
