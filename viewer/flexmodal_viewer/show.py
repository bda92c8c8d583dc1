"""What people ask for: show me this robot, what a search or a diagnosis found, how it was tested."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from flexmodal.campaign import Campaign
from flexmodal.diagnosis import Diagnosis
from flexmodal.ema.shapes import FittedShapes
from flexmodal.frf import PointDirection
from flexmodal.model import Posture, Robot
from flexmodal.optimisation import Outcome
from flexmodal_viewer.campaign_scene import campaign_scene
from flexmodal_viewer.diagnosis_scene import diagnosis_scene
from flexmodal_viewer.live_answers import LiveAnswers
from flexmodal_viewer.live_numbers import is_live
from flexmodal_viewer.live_outcome import live_outcome_scene
from flexmodal_viewer.live_scene import live_scene
from flexmodal_viewer.outcome_scene import outcome_scene
from flexmodal_viewer.page import page_html, write_page
from flexmodal_viewer.photograph import KINDS, write_picture
from flexmodal_viewer.robot_scene import robot_scene
from flexmodal_viewer.scene import Scene
from flexmodal_viewer.serve import HOST, serve
from flexmodal_viewer.socket_talk import Answer

Announce = Callable[[str], None]


def show_robot(
    robot: Robot,
    posture: Posture,
    *,
    modes: bool = False,
    response: str | PointDirection | None = None,
    frequency: float | None = None,
    live: bool = True,
    others: Mapping[str, Robot] | None = None,
    measured: Campaign | None = None,
    workspace: bool = False,
    out: str | Path | None = None,
    port: int | None = None,
    host: str = HOST,
    overwrite: bool = False,
    open_browser: bool = True,
    announce: Announce = print,
    block: bool = True,
) -> str:
    """Show a robot in the browser, or write it as a page.

    Args:
        robot: what to show.
        posture: how it stands.
        modes: swinging in its first mode when the page opens; without `live` with a button for each mode.
        response: point and direction of a force; the tool along z if none.
        frequency: swinging as it does under that force at this frequency [Hz] when the page opens.
        live: with a slider for each joint, receptance and modes following on the page; an arm with joints
            that neither turn about one axis nor slide along one is drawn as it stands.
        others: models whose receptance is drawn on the same axes, by what they are called.
        measured: a campaign whose FRFs stand on the same axes while the arm is in one of its postures.
        workspace: with the receptance over the places that the tool comes to, laid when the page opens.
        out: write a self-contained page here instead of serving it; a picture where it ends in .png, a film
            where it ends in .gif or .mp4.
        port: port to serve on; a free one if none.
        host: address to serve on; others can reach any but 127.0.0.1, which is said.
        overwrite: replace a page that stands there already.
        open_browser: open the user's browser when serving.
        announce: told where the picture is.
        block: serve until Ctrl-C; otherwise serve in the background until `close_all` or the end.

    Returns:
        Path of the page, or address it is served at.

    Raises:
        InvalidPoint, InvalidFrequencies, InvalidPosture, SingularResponse: see `live_scene`.
        InvalidRequest: the port cannot be used, or a film is asked for of what stands still.
        OutputExists: the page exists already, or its folder does not.
        MissingExtra: a picture without Playwright or Chromium.
    """
    answer: Answer | None = None
    if live and is_live(robot):
        swing = "force" if frequency is not None else "mode" if modes else ""
        asked: dict[str, Any] = {"response": response, "frequency": frequency, "swing": swing}
        beside: dict[str, Any] = {"others": others, "measured": measured, "workspace": workspace}
        scene = live_scene(robot, posture, **beside, **asked)
        answer = LiveAnswers(robot)
    else:
        scene = robot_scene(robot, posture, modes=modes, response=response, frequency=frequency)
    return _deliver(scene, _Place(out, port, host, overwrite, open_browser, announce, block), answer)


def show_outcome(
    outcome: Outcome,
    *,
    start: Posture | None,
    live: bool = True,
    out: str | Path | None = None,
    port: int | None = None,
    host: str = HOST,
    overwrite: bool = False,
    open_browser: bool = True,
    announce: Announce = print,
    block: bool = True,
) -> str:
    """Show what a posture search found in the browser, or write it as a page.

    Args:
        outcome: result of the search.
        start: posture to compare with, if any.
        live: with the descent from the start on a slider, and the joints to be moved from there, where
            `show_robot` can. Without it start and optimum swing under the same force.
        out: as in `show_robot`, as are all the others.
        port: see there.
        host: see there.
        overwrite: see there.
        open_browser: see there.
        announce: see there.
        block: see there.

    Returns:
        Path of the page, or address it is served at.

    Raises:
        InvalidRequest, OutputExists: see `show_robot`.
    """
    place = _Place(out, port, host, overwrite, open_browser, announce, block)
    if live and is_live(outcome.problem.robot):
        return _deliver(live_outcome_scene(outcome, start=start), place, LiveAnswers(outcome.problem.robot))
    return _deliver(outcome_scene(outcome, start=start), place)


def show_campaign(
    robot: Robot,
    campaign: Campaign,
    *,
    shapes: Sequence[FittedShapes] = (),
    out: str | Path | None = None,
    port: int | None = None,
    host: str = HOST,
    overwrite: bool = False,
    open_browser: bool = True,
    announce: Announce = print,
    block: bool = True,
) -> str:
    """Show how a robot was tested, posture by posture, or write it as a page.

    Args:
        robot: what was tested.
        campaign: postures, points, and where sensor and hammer were.
        shapes: of fitted modes, animated on the points.
        out: as in `show_robot`, as are all the others.
        port: see there.
        host: see there.
        overwrite: see there.
        open_browser: see there.
        announce: see there.
        block: see there.

    Returns:
        Path of the page, or address it is served at.

    Raises:
        InvalidCampaign: see `campaign_scene`.
        InvalidRequest, OutputExists: see `show_robot`.
    """
    place = _Place(out, port, host, overwrite, open_browser, announce, block)
    return _deliver(campaign_scene(robot, campaign, shapes), place)


def show_diagnosis(
    diagnosis: Diagnosis,
    *,
    out: str | Path | None = None,
    port: int | None = None,
    host: str = HOST,
    overwrite: bool = False,
    open_browser: bool = True,
    announce: Announce = print,
    block: bool = True,
) -> str:
    """Show a diagnosis on its robot, step by step, or write it as a page.

    Args:
        diagnosis: what `flexmodal.diagnose` found.
        out: as in `show_robot`, as are all the others.
        port: see there.
        host: see there.
        overwrite: see there.
        open_browser: see there.
        announce: see there.
        block: see there.

    Returns:
        Path of the page, or address it is served at.

    Raises:
        InvalidRequest, OutputExists: see `show_robot`.
    """
    place = _Place(out, port, host, overwrite, open_browser, announce, block)
    return _deliver(diagnosis_scene(diagnosis), place)


@dataclass(frozen=True)
class _Place:
    """Where a scene goes: into a file, or on the air."""

    out: str | Path | None
    port: int | None
    host: str
    overwrite: bool
    open_browser: bool
    announce: Announce
    block: bool


def _deliver(scene: Scene, to: _Place, answer: Answer | None = None) -> str:
    if to.out is None:
        page = page_html(scene, served=answer is not None)
        return serve(
            page,
            port=to.port,
            host=to.host,
            open_browser=to.open_browser,
            announce=to.announce,
            block=to.block,
            answer=answer,
        )
    write = write_picture if Path(to.out).suffix.lower() in KINDS else write_page
    path = write(scene, to.out, overwrite=to.overwrite)
    to.announce(f"Written to {path}")
    return str(path)
