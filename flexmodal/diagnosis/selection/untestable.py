"""Which effects modes alone cannot tell of."""

from __future__ import annotations

from flexmodal.diagnosis.effects import Context, Effect


def of_modes(effect: Effect, context: Context) -> str | None:
    """Why modes alone cannot tell of an effect; None if they can.

    Args:
        effect: of the catalogue.
        context: of the diagnosis.
    """
    if effect.read is not None or effect.turn is not None:
        return "modes have no calibrated FRF of a single sensor"
    if effect.by_force:
        return "modes were measured at one force, or do not say at which"
    if "response" in effect.variants:
        return "one set of modes for all places of the sensor"
    if effect.name == "structural_damping":
        return "a mode has one damping ratio; how loss depends on frequency is in the FRFs"
    return effect.untestable(context)
