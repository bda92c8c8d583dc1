"""CAMPAIGN of the commands that take measured data."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from flexmodal.cli.printing import say
from flexmodal.errors import Fault, InvalidCampaign

if TYPE_CHECKING:
    from flexmodal.campaign import Campaign
    from flexmodal.model import Robot


def campaign_at(path: str | Path) -> Campaign:
    """Read a campaign, or a universal file by itself, and say what it warns of.

    Raises:
        InvalidCampaign: nothing there, or with every fault of every file.
    """
    from flexmodal.campaign import UNIVERSAL_SUFFIXES, read_campaign
    from flexmodal.files import complete, path_or_shipped, shipped

    place = path_or_shipped(path, "campaigns")
    complete(place)
    if not place.exists():
        names = ", ".join(shipped("campaigns"))
        allowed = f"a folder with a campaign.toml, a universal file by itself, or the name of one: {names}"
        raise InvalidCampaign(Fault(str(path), "", "no such file or folder", allowed))
    if place.is_dir() and not (place / "campaign.toml").exists():
        files = sorted(one.name for one in place.iterdir() if one.suffix.lower() in UNIVERSAL_SUFFIXES)
        named = f", such as {place / files[0]}" if files else ""
        allowed = f"one that has; or a universal file by itself{named}"
        raise InvalidCampaign(Fault(str(path), "", "a folder without a campaign.toml", allowed))
    measured = read_campaign(place)
    for warning in measured.warnings:
        say(f"warning: {warning}", err=True)
    return measured


def say_doubled(campaign: Campaign, source: str | None) -> None:
    """Warn where FRFs and modes both count and one may have been made from the other.

    Args:
        campaign: what was measured.
        source: what was asked for; None for everything.
    """
    from flexmodal.identification.source import doubled

    for warning in doubled(campaign, source):  # type: ignore[arg-type]  # click has seen to it
        say(f"warning: {warning}", err=True)


def card_of(campaign: Campaign) -> str:
    """The card that a campaign names: a file beside it, or a name."""
    beside = None if campaign.path is None else campaign.path / campaign.robot
    return str(beside) if beside is not None and beside.is_file() else campaign.robot


def robot_of(campaign: Campaign, given: str | None) -> Robot:
    """The robot asked for, or the one the campaign names.

    Args:
        campaign: what was measured.
        given: a card's name or a path; None for the campaign's own.

    Raises:
        RobotNotFound: nothing answers to that.
    """
    from flexmodal.model import load

    return load(card_of(campaign) if given is None else given)
