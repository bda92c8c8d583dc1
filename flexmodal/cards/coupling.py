"""`[coupling."jointA+jointB"]`: which joints it means, and whether the springs still hold together."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from flexmodal.cards.card import CouplingCard, JointCard
from flexmodal.text.words import FaultList, listing, shown

_LEAST = 1e-12
"""Smallest eigenvalue of the stiffness matrix, its diagonal scaled to one."""


def couplings_of(
    given: Mapping[str, float], joints: Mapping[str, JointCard], faults: FaultList
) -> dict[str, CouplingCard]:
    """Couplings by their names.

    Args:
        given: off-diagonal stiffness [N·m/rad] by the two names joined by a plus sign.
        joints: the flexible joints.
        faults: where names that are no such pair go, pairs that occur twice, and springs that together push
            instead of holding.
    """
    found: dict[str, CouplingCard] = {}
    taken: set[frozenset[str]] = set()
    for name, stiffness in given.items():
        pair = pair_of(name, joints)
        if pair is None:
            allowed = f"two flexible joints of this card with + between them, of {listing(joints)}"
            faults.add(f"coupling.{name}", f"the name {shown(name)}", allowed)
        elif frozenset(pair) in taken:
            faults.add(f"coupling.{name}", "a pair that is coupled already", "each pair once")
        else:
            taken.add(frozenset(pair))
            found[name] = CouplingCard(pair, stiffness)
    if found and not faults.faults:
        _check_definite(found, joints, faults)
    return found


def pair_of(name: str, joints: Mapping[str, JointCard]) -> tuple[str, str] | None:
    """The two different joints that `jointA+jointB` names; a name may hold plus signs itself.

    Args:
        name: two names joined by a plus sign.
        joints: the flexible joints.
    """
    for place, letter in enumerate(name):
        if letter == "+":
            one, other = name[:place], name[place + 1 :]
            if one in joints and other in joints and one != other:
                return one, other
    return None


def stiffness_matrix(joints: Mapping[str, JointCard], couplings: Mapping[str, CouplingCard]) -> np.ndarray:
    """K over the joints in their order [N·m/rad, N/m].

    Args:
        joints: the flexible joints, in the order of the rows.
        couplings: off-diagonal stiffness [N·m/rad].
    """
    matrix = np.diag([float(joint.stiffness) for joint in joints.values()])
    index = {name: place for place, name in enumerate(joints)}
    for coupling in couplings.values():
        one, other = (index[name] for name in coupling.joints)
        matrix[one, other] = matrix[other, one] = coupling.stiffness
    return matrix


def _check_definite(
    couplings: Mapping[str, CouplingCard], joints: Mapping[str, JointCard], faults: FaultList
) -> None:
    matrix = stiffness_matrix(joints, couplings)
    scale = 1 / np.sqrt(np.diag(matrix))
    values, vectors = np.linalg.eigh(matrix * scale[:, None] * scale)
    if values[0] > _LEAST:
        return
    names = list(joints)
    heavy = [names[place] for place in np.argsort(-np.abs(vectors[:, 0]))[:2]]
    found = f"stiffness that together with that of {listing(heavy)} is not positive definite"
    allowed = "of each pair less than the square root of the product of the two joints' stiffness"
    faults.add("coupling", found, allowed)
