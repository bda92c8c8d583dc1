"""Ports of a link that bends: its compliance along it, or that of each place where it is cut."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
from jaxtyping import Complex

from flexmodal.diagnosis.effects import hinges, link_flexibility, link_motion
from flexmodal.diagnosis.effects.context import Context
from flexmodal.diagnosis.effects.effect import Bodies, Placement, along
from flexmodal.diagnosis.lawfree.port import BETWEEN, Patterns, PortKind, Wider, constant, outer
from flexmodal.structure.assembly import Assembly

MOST = 28
"""Functions of a link that is cut, beyond which they are too many for what is measured."""


def _link_hinges(context: Context, where: str) -> tuple[np.ndarray, np.ndarray]:
    """Where a link bends, and weights: three of Gauss's points have any compliance for a load at its end."""
    return hinges.fixed(context, where) or hinges.gauss(3)


def _link_functions(context: Context, where: str) -> tuple[str, ...]:
    planes = range(link_motion.planes_of(context))
    names = [f"bend {plane + 1}" for plane in planes]
    own = [f"{name}{end}" for end in ("", ", outwards", ", to the ends") for name in names]
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
    places, weights = _link_hinges(context, where)
    planes = link_motion.planes_of(context)
    rows = [assembly.row(name) for name in link_motion.names_of(context, where, len(places))]
    found = np.zeros((len(_link_functions(context, where)), *(len(assembly.coordinates),) * 2))
    for hinge, (weight, way) in enumerate(zip(weights, 2 * places - 1, strict=True)):
        bends = rows[planes * hinge : planes * (hinge + 1)]
        for plane, row in enumerate(bends):
            for degree, size in enumerate((1.0, way, (3 * way**2 - 1) / 2)):
                found[degree * planes + plane] += size * weight * np.diag(row)
        if planes == 2:
            found[3 * planes] += weight * outer(bends[0], bends[1], 1)[0]
    length, _ = along(context, where)
    for section in link_motion.sections(context, where, places):
        for name in section.twist:
            found[3 * planes + 1] += section.share * np.diag(assembly.row(name))
        for k, name in enumerate(reversed(section.shears), start=1):
            found[-k] += section.share * length**2 / 12 * np.diag(assembly.row(name))
    return Patterns(compliance=found)


def _link_starts(context: Context, where: str) -> tuple[tuple[float, ...], ...]:
    planes = link_motion.planes_of(context)
    more = len(_link_functions(context, where)) - planes
    return tuple((*(size,) * planes, *(0.0,) * more) for size in (0.03, 0.1, 0.3, 1.0, 3.0))


def _cuts(
    context: Context, where: str, row: Callable[[str], np.ndarray]
) -> list[tuple[str, str, np.ndarray, float]]:
    """Of each place where a link is cut: a name, that for the whole link, its pattern, and how far out."""
    places, weights = _link_hinges(context, where)
    planes, (length, _), found = link_motion.planes_of(context), along(context, where), []
    rows = [row(name) for name in link_motion.names_of(context, where, len(places))]
    for hinge, (weight, way) in enumerate(zip(weights.tolist(), (2 * places - 1).tolist(), strict=True)):
        bends = rows[planes * hinge : planes * (hinge + 1)]
        each = [(f"bend {plane + 1}", weight * np.diag(one)) for plane, one in enumerate(bends)]
        if planes == 2:
            each.append((f"bend 1{BETWEEN}bend 2", weight * outer(bends[0], bends[1], 1)[0]))
        found += [(f"{name}, {hinge + 1}", name, pattern, way) for name, pattern in each]
    for number, section in enumerate(link_motion.sections(context, where, places), start=1):
        slides = [(f"shear {k}", one, length**2 / 12) for k, one in enumerate(section.shears, start=1)]
        for name, one, size in (*(("twist", one, 1.0) for one in section.twist), *slides):
            found.append((f"{name}, {number}", name, section.share * size * np.diag(row(one)), 0.0))
    return found


def _cut_functions(context: Context, where: str) -> tuple[str, ...]:
    return tuple(name for name, *_ in _cuts(context, where, lambda coordinate: np.zeros(1)))


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
    whole = dict(zip(_link_functions(context, where), functions, strict=True))
    found = []
    for _, name, _, way in _cuts(context, where, lambda coordinate: np.zeros(1)):
        outwards, ends = (whole.get(f"{name}{end}", 0.0) for end in (", outwards", ", to the ends"))
        found.append(whole[name] + way * outwards + (3 * way**2 - 1) / 2 * ends)
    return np.array(found)


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
        compliance=np.stack([one[2] for one in _cuts(placement.context, placement.where, assembly.row)])
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
