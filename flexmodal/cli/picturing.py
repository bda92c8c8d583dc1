"""Pictures of a posture search, as options of `flexmodal optimise`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from flexmodal.cli.options import SOURCE, refuse_existing
from flexmodal.cli.printing import progress, say
from flexmodal.errors import Fault, FlexmodalError, InvalidRequest

if TYPE_CHECKING:
    from flexmodal.model import Posture
    from flexmodal.optimisation import Outcome

KINDS = ("receptance", "arm", "self-motion", "descent", "workspace")
_PLACES, _STARTS = 31, 64
"""Of the map of the workspace: places each way, and starts at each."""

plot_option = click.option(
    "--plot",
    "plots",
    multiple=True,
    metavar="KIND=FILE",
    help=f"Draw into a .png or .svg file; KIND is one of {', '.join(KINDS)}. May be repeated.",
)


def pictures_of(
    given: Sequence[str], *, force: bool, hold: bool, start: bool, family: bool
) -> dict[str, Path]:
    """The files asked for, by kind; everything that stands in their way is said before the search.

    Args:
        given: texts of --plot, KIND=FILE.
        force: whether files may be replaced.
        hold: whether a place is held.
        start: whether there is a start to descend from.
        family: whether the search is along a family.

    Raises:
        InvalidRequest: unknown kinds, or kinds that need a hold or a start that is not there.
        OutputExists: a file that exists, or a folder that does not.
    """
    faults, found = [], {}
    for text in given:
        kind, equals, name = text.partition("=")
        if kind not in KINDS or not equals or not name:
            faults.append(Fault(SOURCE, "--plot", repr(text), f"KIND=FILE, KIND one of {', '.join(KINDS)}"))
        elif kind in found:
            faults.append(Fault(SOURCE, "--plot", f"{kind} twice", "each kind once"))
        else:
            found[kind] = Path(name)
    for kind in found:
        if kind in ("self-motion", "workspace") and not hold:
            faults.append(Fault(SOURCE, f"--plot {kind}", "without --hold", "a picture of what is held"))
        if kind == "descent" and (not start or family):
            faults.append(Fault(SOURCE, "--plot descent", "no descent from --start", "--start, no --family"))
    if faults:
        raise InvalidRequest(faults)
    for path in found.values():
        refuse_existing(path, force, (".png", ".svg"), option="--plot")
    return found


def draw_pictures(
    outcome: Outcome, start: Posture | None, pictures: dict[str, Path], *, force: bool, quiet: bool
) -> None:
    """Draw and write them; one that cannot be drawn is said, and the others are drawn.

    Args:
        outcome: of the search.
        start: the posture to compare with; None where there is none.
        pictures: files by kind, see `pictures_of`.
        force: whether files may be replaced.
        quiet: whether to show no bar.
    """
    from flexmodal.report import write_figure

    for kind, path in pictures.items():
        try:
            figure = _draw(kind, outcome, start, quiet)
        except FlexmodalError as error:
            say(f"flexmodal: no picture of the {kind}: {error}", err=True)
            continue
        write_figure(figure, path, overwrite=force)
        say(f"wrote {path}", err=True)


def _draw(kind: str, outcome: Outcome, start: Posture | None, quiet: bool) -> Any:
    from flexmodal.optimisation.pictures import plot, traces

    problem, best = outcome.problem, outcome.best.posture
    if kind == "receptance":
        return plot.draw_receptances(outcome, start)
    if kind == "arm":
        postures = {} if start is None else {"start": start}
        return plot.draw_postures(problem.robot, postures | {"best": best}, target=problem.hold)
    if kind == "self-motion":
        return plot.draw_self_motion(problem, best)
    if kind == "descent":
        assert start is not None
        methods = ("newton", "null-space")
        return traces.draw_traces(problem, {name: traces.follow(problem, start, name) for name in methods})
    return _workspace(outcome, quiet)


def _workspace(outcome: Outcome, quiet: bool) -> Any:
    import numpy as np

    from flexmodal.optimisation.pictures import workspace

    problem = outcome.problem
    axes = [np.linspace(low, high, _PLACES) for low, high in workspace.extent(problem)[:2]]
    with progress(_PLACES**2, "mapping the workspace", quiet=quiet) as advance:
        grid = workspace.workspace_map(problem, axes[0], axes[1], starts=_STARTS, advance=advance)
    return workspace.draw_workspace(problem, axes[0], axes[1], grid)
