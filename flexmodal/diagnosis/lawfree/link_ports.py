"""Ports of a link that bends: its compliance along it, or that of each place where it is cut."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.diagnosis.effects import hinges, link_flexibility, link_motion
from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Bodies, Placement, along
from flexmodal.diagnosis.lawfree.port import BETWEEN, Patterns, PortKind, Wider, constant, outer
from flexmodal.structure.assembly import Assembly

MOST = 28
"""Functions of a link that is cut, beyond which they are too many for what is measured."""


END, OUTWARDS, TO_ENDS = ", ", "outwards", "to the ends"
"""How a function of the whole link is told from that which is even along it."""


@dataclass(frozen=True, eq=False)
class _Cut:
    """What gives in one place where a link is cut."""

    name: str
    of: str
    """The function of the whole link that is even along it."""
    pattern: Float[np.ndarray, "dof dof"]
    way: float
    """How far out it is: -1 where the link begins, 1 where it ends; 0 of what is even along it alone."""


def _grown(end: str, way: float) -> float:
    """Legendre's polynomial by which a function of the whole link goes along it."""
    return {"": 1.0, OUTWARDS: way, TO_ENDS: (3 * way**2 - 1) / 2}[end]


def _link_hinges(context: Context, where: str) -> tuple[np.ndarray, np.ndarray]:
    """Where a link bends, and weights: three of Gauss's points have any compliance for a load at its end."""
    return hinges.fixed(context, where) or hinges.gauss(3)


def _link_functions(context: Context, where: str) -> tuple[str, ...]:
    planes = range(link_motion.planes_of(context))
    names = [f"bend {plane + 1}" for plane in planes]
    own = [f"{name}{end}" for end in ("", END + OUTWARDS, END + TO_ENDS) for name in names]
    shears = [f"shear {plane + 1}" for plane in planes if hinges.fixed(context, where) is not None]
    return (*own, *shears) if len(names) == 1 else (*own, f"bend 1{BETWEEN}bend 2", "twist", *shears)


def _link_shape(assembly: Assembly, placement: Placement) -> None:
    places, _ = _link_hinges(placement.context, placement.where)
    link_motion.add_hinges(assembly, placement, places)


def _link_body(assembly: Assembly, placement: Placement, bodies: Bodies, link: str) -> bool:
    places, _ = _link_hinges(placement.context, placement.where)
    return link_motion.cut_body(assembly, placement, bodies, link, places)


def _link_patterns(assembly: Assembly, placement: Placement) -> Patterns:
    """Even compliance along the link, what grows along it, and what grows to its ends: Legendre's.

    Of shear Φ/k, where 1/k is the compliance of bending and Φ what its spring is softer by.
    """
    context, where = placement.context, placement.where
    cuts, found = _cuts(context, where, assembly.row), []
    for name in _link_functions(context, where):
        whole, _, end = name.partition(END)
        found.append(sum(_grown(end, one.way) * one.pattern for one in cuts if one.of == whole))
    return Patterns(compliance=np.stack(found))


def _link_starts(context: Context, where: str) -> tuple[tuple[float, ...], ...]:
    planes = link_motion.planes_of(context)
    more = len(_link_functions(context, where)) - planes
    return tuple((*(size,) * planes, *(0.0,) * more) for size in (0.03, 0.1, 0.3, 1.0, 3.0))


def _cuts(context: Context, where: str, row: Callable[[str], np.ndarray]) -> list[_Cut]:
    """What gives in each of them."""
    places, weights = _link_hinges(context, where)
    planes, (length, _), found = link_motion.planes_of(context), along(context, where), []
    rows = [row(name) for name in link_motion.names_of(context, where, len(places))]
    for hinge, (weight, way) in enumerate(zip(weights.tolist(), (2 * places - 1).tolist(), strict=True)):
        bends = rows[planes * hinge : planes * (hinge + 1)]
        each = [(f"bend {plane + 1}", weight * np.diag(one)) for plane, one in enumerate(bends)]
        if planes == 2:
            each.append((f"bend 1{BETWEEN}bend 2", weight * outer(bends[0], bends[1], 1)[0]))
        found += [_Cut(f"{name}, {hinge + 1}", name, pattern, way) for name, pattern in each]
    for number, section in enumerate(link_motion.sections(context, where, places), start=1):
        slides = [(f"shear {k}", one, length**2 / 12) for k, one in enumerate(section.shears, start=1)]
        for name, one, size in (*(("twist", one, 1.0) for one in section.twist), *slides):
            found.append(_Cut(f"{name}, {number}", name, section.share * size * np.diag(row(one)), 0.0))
    return found


def _cut_functions(context: Context, where: str) -> tuple[str, ...]:
    return tuple(one.name for one in _cuts(context, where, lambda coordinate: np.zeros(1)))


def _cut_places(context: Context) -> tuple[str, ...]:
    """Links that are cut where they are seen, with no more functions than the data may tell."""
    seen = [one for one in link_flexibility.EFFECT.places(context) if hinges.fixed(context, one) is not None]
    return tuple(one for one in seen if len(_cut_functions(context, one)) <= MOST)


def _cut_begin(
    context: Context,
    where: str,
    values: Mapping[str, float],
    functions: Complex[np.ndarray, "function line"],
) -> Complex[np.ndarray, "more line"]:
    """Those of the whole link at each of the places."""
    whole = [name.partition(END) for name in _link_functions(context, where)]
    cuts = _cuts(context, where, lambda coordinate: np.zeros(1))
    shares = [[_grown(end, one.way) * (one.of == name) for name, _, end in whole] for one in cuts]
    return np.array(shares) @ functions


def _compliant(functions: Callable[[Context, str], tuple[str, ...]]) -> Callable[..., np.ndarray]:
    """Sizes of compliances: that of the stiffest joint that carries the link."""

    def sizes(context: Context, where: str, frequency: np.ndarray) -> np.ndarray:
        return constant([1 / hinges.stiffest(context, where)] * len(functions(context, where)), frequency)

    return sizes


SHAPE = replace(
    link_flexibility.EFFECT,
    name="port",
    parameters=lambda c, w: (),
    shape=_link_shape,
    bodies=_link_body,
    geometry=(),
    act=None,
    extend=None,
)
CUT = PortKind(
    name="link",
    says="the bending of the link",
    places=_cut_places,
    functions=_cut_functions,
    sizes=_compliant(_cut_functions),
    unit="rad/(N·m)",
    shape=SHAPE,
    patterns=lambda assembly, placement: Patterns(
        compliance=np.stack([one.pattern for one in _cuts(placement.context, placement.where, assembly.row)])
    ),
)
"""What gives in each place where a link is cut, as beside an opening."""
LINK = replace(
    CUT,
    places=link_flexibility.EFFECT.places,
    functions=_link_functions,
    sizes=_compliant(_link_functions),
    starts=_link_starts,
    patterns=_link_patterns,
    wider=(Wider(CUT, _cut_begin),),
)
