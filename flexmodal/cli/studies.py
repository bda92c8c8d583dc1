"""`flexmodal studies`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from flexmodal.cli.options import MOST_STARTS, SOURCE, json_option, quiet_option
from flexmodal.cli.printing import print_json, print_table, progress, say
from flexmodal.errors import Fault, InvalidRequest

if TYPE_CHECKING:
    from flexmodal.optimisation.studies import Study, StudyResult


@click.command()
@click.argument("names", nargs=-1, metavar="[NAME]…")
@click.option(
    "--starts",
    type=click.IntRange(1, MOST_STARTS),
    help="Starts of each global search; as `flexmodal optimise` if none.",
)
@click.option("--seed", type=click.IntRange(min=0), default=0, show_default=True)
@quiet_option
@json_option
def studies(names: tuple[str, ...], starts: int | None, seed: int, quiet: bool, as_json: bool) -> None:
    """Published optimisations run again beside their printed numbers; without a name, which there are."""
    from flexmodal.optimisation.studies import run_study, shipped_studies

    known = shipped_studies()
    unknown = [name for name in names if name not in known]
    if unknown:
        raise InvalidRequest(Fault(SOURCE, "NAME", ", ".join(unknown), ", ".join(known)))
    if not names:
        _list(known, as_json)
        return
    with progress(len(names), "studies", quiet=quiet) as advance:
        found = []
        for name in names:
            found.append(run_study(known[name], starts=starts, seed=seed))
            advance()
    if as_json:
        print_json({"studies": [_json(result) for result in found]})
        return
    for result in found:
        _print(result)


def _list(known: dict[str, Study], as_json: bool) -> None:
    if as_json:
        listed = [
            {"name": study.name, "robot": study.robot, "kind": study.kind, "title": study.title}
            for study in known.values()
        ]
        print_json({"studies": listed})
        return
    rows = [[study.name, study.robot, study.title] for study in known.values()]
    print_table("studies: flexmodal studies NAME…", ["name", "robot", "what"], rows)


def _json(result: StudyResult) -> dict[str, Any]:
    study = result.study
    return {
        "name": study.name,
        "unit": result.unit,
        "start": result.start,
        "printed": result.printed,
        "best": result.best,
        "at": result.at,
        "ends": [value if value < float("inf") else None for value in result.ends],
        "minima": list(result.minima),
        "hops": list(result.hops),
        "printed_start": study.printed_start,
        "printed_final": study.printed_final,
        "printed_ends": [value if value < float("inf") else None for value in study.printed_ends],
        "verdict": None if result.outcome is None else result.outcome.verdict,
        "says": study.says,
    }


def _print(result: StudyResult) -> None:
    study = result.study
    rows = [
        [label, "–" if printed is None else f"{printed:.4g}", "–" if ours is None else f"{ours:.4g}"]
        for label, printed, ours in _rows(result)
    ]
    print_table(f"{study.name}: {study.title}", ["", "printed", "in this model"], rows)
    if result.outcome is not None and study.kind == "posture":
        say(result.outcome.verdict)
    for hop in result.hops:
        say(f"a fixed gain hops over a maximum from {hop}")
    say(study.says)


def _rows(result: StudyResult) -> list[tuple[str, float | None, float | None]]:
    """Label, printed and ours."""
    study = result.study
    if study.kind == "posture":
        return [
            (f"start [{result.unit}]", study.printed_start, result.start),
            (f"printed final posture [{result.unit}]", study.printed_final, result.printed),
            (f"best found [{result.unit}]", None, result.best),
        ]
    if study.kind == "frequency":
        pairs = zip(study.starts, study.printed_ends, result.ends, strict=False)
        descents = [(f"from {start:g} Hz, downhill to [Hz]", end, ours) for start, end, ours in pairs]
        minima: list[tuple[str, float | None, float | None]] = [
            ("minimum [Hz]", None, place) for place in result.minima
        ]
        return [*descents, *minima]
    printed = study.printed_ends or (None, None)
    return [
        (f"|receptance| at the start [{result.unit}]", printed[0], result.ends[0]),
        (f"|receptance| at the end [{result.unit}]", printed[1], result.ends[1]),
        ("sum over the poles at the start [s/rad]", printed[0], result.pole_sum[0]),
        ("sum over the poles at the end [s/rad]", printed[1], result.pole_sum[1]),
        ("best member [rad]", study.printed_best, result.at),
    ]
