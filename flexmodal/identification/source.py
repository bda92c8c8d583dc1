"""Which of a campaign's data count: its FRFs, its modes, or both."""

from __future__ import annotations

from typing import Literal

from flexmodal.campaign import Campaign

Source = Literal["frf", "modes", "both"]


def source_of(campaign: Campaign, wanted: Source | None = None) -> Source:
    """What was asked for, or everything that was measured.

    Args:
        campaign: with FRFs, blows or modes.
        wanted: None for everything.
    """
    if wanted is not None:
        return wanted
    if campaign.frfs is None and not campaign.blows:
        return "modes"
    return "frf" if campaign.modes is None else "both"


def doubled(campaign: Campaign, wanted: Source | None) -> tuple[str, ...]:
    """A warning where both kinds count, nobody asked for that, and one may have been made from the other.

    Args:
        campaign: which may say that its modes were measured apart.
        wanted: what was asked for; None for everything.
    """
    if wanted is not None or source_of(campaign) != "both" or campaign.separate_modes:
        return ()
    return (
        "FRFs and modes.csv both count, as two measurements: if these modes were estimated from these FRFs, "
        "the same data count twice. Choose one kind (--from frf or --from modes), or say in campaign.toml "
        "that they were measured apart (separate_modes = true).",
    )
