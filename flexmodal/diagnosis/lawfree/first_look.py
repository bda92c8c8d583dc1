"""The law-free look at the start of every diagnosis of FRFs."""

from __future__ import annotations

from collections.abc import Callable

from flexmodal.diagnosis.lawfree.findings import summed_up
from flexmodal.diagnosis.lawfree.look import law_free
from flexmodal.diagnosis.lawfree.result import Findings
from flexmodal.diagnosis.selection.frf_comparison import FittedFrfs
from flexmodal.diagnosis.setup import Setup


def looked_freely(
    setup: Setup, root: FittedFrfs, *, by_force: bool, advance: Callable[[str, float], None]
) -> Findings:
    """Look without a law.

    Args:
        setup: what the diagnosis works with.
        root: the robot re-tuned.
        by_force: whether FRFs change with the force of the blow.
        advance: called with what is being done and the part of it that is done.
    """
    held = setup.observations.keeping(setup.held) if setup.held.any() else None
    look = law_free(
        root.hypothesis,
        root.x,
        setup.fitted,
        held,
        by_force=by_force,
        advance=lambda part: advance("looking without a law", part),
    )
    return summed_up(look)
