"""Which effect a place is, told by its free function alone, whatever law that follows.

Where one effect only sits at a kind of port, a function of its class or of none that is known is that effect.
What a sensor reads too late has a phase that grows with the frequency and next to no gain; what it reads too
large or too small has a gain, or a phase that comes back. What moves along as a mass where it is slow and
pulls against the motion where it is fast is attached by a spring. A torque that takes energy, and the more
the weaker the blow, rubs. Foundations and bearings are not told like this: a machine beside the robot, felt
through the floor, acts at the same place in the same way. Nor are springs that are not straight, as play is
none, nor couplings of two joints, as a link between these that bends does much the same. Sensors
that change from posture to posture are told by what each of these makes of them, see `changing`.
"""

from __future__ import annotations

import numpy as np

from flexmodal.diagnosis.lawfree.effects_at import CLASSES_OF, PORT_OF
from flexmodal.diagnosis.lawfree.port import BETWEEN
from flexmodal.diagnosis.lawfree.result import Curve, Found, Loss

WHATEVER = ("carried", "damping", "joint", "link")
"""Kinds of port whose functions of no known class are that of their only effect, too."""
BODIES = ("body", "ground", "across")
"""Those of bodies, which may be a mass or an absorber."""
OF_CLASS = (*BODIES, *WHATEVER)
"""Those that are told by a class. At joints springs, dampers and masses are the robot's own."""
TREND = (0.7, 0.97)
"""Part of a sensor's squared phase that grows with the frequency: at most of a gain, at least of a delay.
Of fourteen that were looked at delays had 0.99 and more, notches 0.41 at most, steps of the sensitivity 0.62
to 0.96."""
PHASE = (2.0, 6.0)
"""Squared phase over squared ln gain, likewise: 12 and more of delays, 0.4 to 1.7 of steps."""
LEAST = 1e-3
"""Standard deviation that a line of a sensor counts with at least."""
PARTS, CLEARLY = 20, 4.0
"""Into how many parts of the band a body's function is divided, and standard deviations from which it moves
along or pulls against the motion in one."""
RUBS = 0.12, 0.1
"""`Loss.share` and `Loss.weaker` from which a torque rubs. Of fifteen that were looked at seven that do had
0.16 and 0.18 at least, eight springs and clearances 0.06 and 0.15 at most."""


def told_by(found: Found) -> str | None:
    """Name of the effect; None where the function does not tell a single one.

    Args:
        found: a place whose function explains everything; one that is not apart from others tells nothing.
    """
    if not found.is_apart:
        return None
    if found.loss is not None:
        return "coulomb_friction" if _rubs(found.loss) else None
    if found.changes:
        return found.changes
    if found.curve is None:
        return None
    if found.port == "sensor":
        return _of_sensor(found.curve) or _by_class(found)
    if found.port not in OF_CLASS:
        return None
    if not found.classes and found.port in BODIES:
        return "local_absorber" if _is_attached(found.curve) else None
    if not found.classes and found.port not in WHATEVER:
        return None
    return _by_class(found)


def _by_class(found: Found) -> str | None:
    """The only effect at such a port whose curves are of these classes; of a curve of none, the only one."""
    port = "body" if found.port in BODIES else found.port
    able, known = [name for name, one in PORT_OF.items() if one == port], {one.name for one in found.classes}
    if known or found.port not in WHATEVER:
        able = [name for name in able if known & set(CLASSES_OF.get(name, ()))]
    return able[0] if len(able) == 1 else None


def _rubs(loss: Loss) -> bool:
    return loss.share >= RUBS[0] and loss.weaker >= RUBS[1]


def _of_sensor(curve: Curve) -> str | None:
    """A gain or a delay, of ln(reading / motion)."""
    gain, phase = curve.value[0].real, np.unwrap(curve.value[0].imag)
    weight = 1 / np.maximum(curve.deviation[0], LEAST) ** 2
    squared, turned = float(weight @ gain**2), float(weight @ phase**2)
    growing = float(weight @ (phase * curve.frequency)) ** 2 / float(weight @ curve.frequency**2)
    trend = growing / max(turned, 1e-300)
    if trend >= TREND[1] and turned >= PHASE[1] * squared:
        return "time_delay"
    return "sensor_gain" if trend <= TREND[0] or turned <= PHASE[0] * squared else None


def _is_attached(curve: Curve) -> bool:
    """Whether along one way it clearly moves along, as a mass, and at higher frequencies pulls against."""
    square = (2 * np.pi * curve.frequency) ** 2
    for name, value, deviation in zip(curve.names, curve.value, curve.deviation, strict=True):
        if BETWEEN in name:
            continue
        mass, weight = -value.real / square, (square / np.maximum(deviation, 1e-300)) ** 2
        parts = np.array_split(np.arange(len(mass)), min(PARTS, len(mass)))
        total = np.array([max(float(weight[part].sum()), 1e-300) for part in parts])
        means = np.array([weight[part] @ mass[part] for part in parts]) / total
        signs = np.sign(means)[np.abs(means) * np.sqrt(total) > CLEARLY]
        if len(signs) and signs[0] > 0 and signs.min() < 0:
            return True
    return False
