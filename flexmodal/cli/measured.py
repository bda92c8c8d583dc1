"""CAMPAIGN of the commands that take measured data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from flexmodal.cli.printing import say
from flexmodal.errors import Fault, InvalidCampaign, InvalidRequest

if TYPE_CHECKING:
    from flexmodal.campaign import Campaign
    from flexmodal.model import Robot
    from flexmodal.soundness import Finding


def campaign_at(path: str | Path) -> Campaign:
    """Read a campaign, or a universal file by itself, and say what it warns of.

    Raises:
        InvalidCampaign: nothing there, or with every fault of every file.
    """
    from flexmodal.campaign import UNIVERSAL_SUFFIXES, is_campaign, read_campaign
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
    if place.is_file() and not is_campaign(place):
        raise InvalidCampaign(_no_campaign(place))
    measured = read_campaign(place)
    for warning in measured.warnings:
        say(f"warning: {warning}", err=True)
    return measured


def _no_campaign(place: Path) -> Fault:
    """What to do with a file that is no campaign."""
    kind = f"a file of the kind {place.suffix or 'without an ending'}"
    allowed = "a folder with a campaign.toml, a universal file (.uff, .unv) by itself, or a table's map"
    if place.suffix.lower() in (".csv", ".xlsx", ".txt", ".mat", ".h5", ".hdf5", ".tdms"):
        allowed += (
            f"; a table becomes a campaign by a map: flexmodal import {place} --draft map.toml, see "
            "docs/campaign.md"
        )
    elif place.suffix.lower() in (".toml", ".urdf"):
        allowed += "; a robot goes to the other commands, such as flexmodal modes"
    return Fault(str(place), "", kind, allowed)


def of_postures(campaign: Campaign, wanted: Sequence[str]) -> Campaign:
    """Some postures of a campaign, without its modes; all of it where none is named.

    Args:
        campaign: what was measured.
        wanted: names or ids.

    Raises:
        InvalidRequest: a posture that is none of the campaign's.
    """
    if not wanted:
        return campaign
    names = ", ".join(f"{p.id} or {p.name}" for p in campaign.postures)
    known = {one for p in campaign.postures for one in (p.name, str(p.id))}
    faults = [
        Fault("command line", "--posture", repr(one), f"a posture of the campaign: {names}")
        for one in wanted
        if one not in known
    ]
    if faults:
        raise InvalidRequest(faults)
    chosen = tuple(p for p in campaign.postures if p.name in wanted or str(p.id) in wanted)
    ids = [p.id for p in chosen]
    frfs = None if campaign.frfs is None else campaign.frfs.select(posture=ids)
    return replace(
        campaign,
        postures=chosen,
        frfs=frfs if frfs is not None and len(frfs) else None,
        blows=tuple(blow for blow in campaign.blows if blow.posture in ids),
        modes=None,
    )


def of_frfs(campaign: Campaign, wanted: Sequence[str], estimator: str) -> Campaign:
    """Some FRFs of a campaign, without its blows, from which they come if it has none; all if none is named.

    Args:
        campaign: what was measured.
        wanted: RESPONSE/REFERENCE, each a point's id or name with a direction, such as 2:+z/1:+z.
        estimator: of FRFs from blows.

    Raises:
        InvalidRequest: an FRF that is none of the campaign's.
    """
    import numpy as np

    from flexmodal.campaign import named_direction
    from flexmodal.ema import records_of

    if not wanted:
        return campaign
    records = records_of(campaign, estimator)
    ids, names = {}, {}
    for point in campaign.points:
        ids[point.id], names[point.id] = str(point.id), point.name
    known: dict[str, set[int]] = {}
    for row in range(len(records)):
        pair = records.response[row].tolist(), records.reference[row].tolist()
        for table in (ids, names):
            text = "/".join(str(named_direction(place, table)) for place in pair)
            known.setdefault(text.replace("+", ""), set()).add(row)
    faults = [
        Fault("command line", "--frf", repr(one), f"RESPONSE/REFERENCE among {', '.join(sorted(known))}")
        for one in wanted
        if one.replace("+", "") not in known
    ]
    if faults:
        raise InvalidRequest(faults)
    rows = sorted(set().union(*(known[one.replace("+", "")] for one in wanted)))
    return replace(campaign, frfs=records.take(np.array(rows)), blows=(), modes=None)


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
    refuse_export(campaign)
    beside = None if campaign.path is None else campaign.path / campaign.robot
    return str(beside) if beside is not None and beside.is_file() else campaign.robot


def refuse_export(campaign: Campaign) -> None:
    """A universal file by itself names no robot, nor where on it its points are.

    Args:
        campaign: what was measured.

    Raises:
        InvalidCampaign: with what to do instead.
    """
    from flexmodal.campaign.description.tested import NO_ROBOT

    if campaign.robot != NO_ROBOT:
        return
    found = "a universal file by itself, which names neither a robot nor the links its points are on"
    allowed = (
        "a folder with that file as frf.uff beside a campaign.toml that names them, see docs/campaign.md; "
        "modes need no robot: flexmodal fit FILE --out modes.html"
    )
    raise InvalidCampaign(Fault(campaign.title, "robot", found, allowed))


def findings_on(path: str | Path) -> tuple[Finding, ...]:
    """What is wrong with a campaign that can be read, beside the card it names where that can be found.

    Args:
        path: of the campaign.
    """
    from flexmodal.campaign import read_campaign
    from flexmodal.campaign.description.tested import NO_ROBOT
    from flexmodal.errors import FlexmodalError
    from flexmodal.model import load
    from flexmodal.soundness import check_soundness

    measured = read_campaign(path)
    robot = None
    if measured.robot != NO_ROBOT:
        try:
            robot = load(card_of(measured))
        except FlexmodalError as error:
            say(f"note: looked at without the robot: {error}", err=True)
    return check_soundness(measured, robot)


def say_findings(campaign: Campaign, robot: Robot | None) -> None:
    """What is wrong with a campaign, before anything is made of it.

    Args:
        campaign: what was measured.
        robot: to compare with, if there is one.
    """
    from flexmodal.soundness import check_soundness

    for finding in check_soundness(campaign, robot):
        if not finding.harmless:
            say(f"finding: {finding}", err=True)


def robot_of(campaign: Campaign, given: str | None) -> Robot:
    """The robot asked for, or the one the campaign names.

    Args:
        campaign: what was measured.
        given: a card's name or a path; None for the campaign's own.

    Raises:
        RobotNotFound: nothing answers to that.
    """
    from flexmodal.model import load

    refuse_export(campaign)
    return load(card_of(campaign) if given is None else given)
