"""`flexmodal atlas`."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from flexmodal.cli.options import (
    SOURCE,
    RobotOptions,
    frequencies_of,
    json_option,
    number,
    quiet_option,
    robot_options,
)
from flexmodal.cli.printing import print_json, say
from flexmodal.cli.sources import Sourcing, source_options
from flexmodal.cli.waiting import shown_bar
from flexmodal.errors import Fault, InvalidRequest

if TYPE_CHECKING:
    from flexmodal.atlas import Built, Plan, Points, Quantity
    from flexmodal.model import Robot
    from flexmodal.prediction import PredictedReceptances

_QUANTITIES = ("receptance", "modes", "stiffness", "depth")
_MOST_WORKERS = 1024


@click.command()
@robot_options
@source_options
@click.option(
    "--grid",
    multiple=True,
    metavar="JOINT=START:STOP:COUNT",
    help="Values of a joint, both ends included, or JOINT=VALUE; once for each joint [rad, m; deg].",
)
@click.option("--sample", type=click.IntRange(min=1), metavar="COUNT", help="Random postures, not a grid.")
@click.option(
    "--range",
    "ranges",
    multiple=True,
    metavar="JOINT=START:STOP",
    help="Of --sample; the joint's limits, one turn at most, if none.",
)
@click.option("--seed", type=click.IntRange(min=0), default=0, show_default=True, help="Of --sample.")
@click.option("--quantity", type=click.Choice(_QUANTITIES), default="receptance", show_default=True)
@click.option(
    "--frequencies", metavar="START:STOP:STEP", help="Of receptances, in Hz; or values with commas."
)
@click.option(
    "--direction",
    "directions",
    multiple=True,
    metavar="POINT:AXIS",
    help="Such as tool:+z, or RESPONSE/REFERENCE; may be repeated; the tool along z if none.",
)
@click.option("--single", is_flag=True, help="Keep receptances in single precision: half the space.")
@click.option("--cut", "cut_file", type=click.Path(path_type=Path), help="Of depths: the TOML file of a cut.")
@click.option("--speeds", type=click.IntRange(2, 10_000), default=24, show_default=True, help="Of depths.")
@click.option("--out", required=True, type=click.Path(path_type=Path), help="The store, such as arm.zarr.")
@click.option(
    "--scheduler", metavar="ADDRESS", help="A Dask scheduler, tcp://HOST:PORT; this machine if none."
)
@click.option(
    "--workers", type=click.IntRange(1, _MOST_WORKERS), help="On this machine; as many as cores if none."
)
@click.option("--no-verify", is_flag=True, help="Do not look at the checksums of what stands already.")
@quiet_option
@json_option
def atlas(
    robot: RobotOptions,
    sourcing: Sourcing,
    grid: tuple[str, ...],
    sample: int | None,
    ranges: tuple[str, ...],
    seed: int,
    quantity: str,
    frequencies: str | None,
    directions: tuple[str, ...],
    single: bool,
    cut_file: Path | None,
    speeds: int,
    out: Path,
    scheduler: str | None,
    workers: int | None,
    no_verify: bool,
    quiet: bool,
    as_json: bool,
) -> None:
    """A sweep over many postures, kept as a Zarr store; killed and called again, it goes on.

    Read it with xarray, or with `flexmodal lookup`.
    """
    from flexmodal.atlas import Plan, build_atlas

    arm = robot.load()
    points = _points(arm, grid, sample, ranges, seed)
    source = _source(sourcing, arm, quantity, single, quiet)
    plan = Plan(points, _quantity(arm, quantity, frequencies, directions, single, cut_file, speeds, source))
    if not quiet:
        each = f"{plan.layout.size / 1e9:.3g} GB in {plan.chunks} chunks"
        say(f"{points.count:,} postures, {quantity}: {each}", err=True)
    with _bar(quiet) as (begin, advance):
        built = build_atlas(
            plan,
            out,
            scheduler=scheduler,
            workers=workers,
            verify=not no_verify,
            begin=begin,
            advance=advance,
        )
    _tell(plan, built, out, as_json)


def _tell(plan: Plan, built: Built, out: Path, as_json: bool) -> None:
    for one in built.others:
        say(f"note: begun with {one}; the last digits of what was added may differ", err=True)
    if built.spoilt:
        say(f"note: {built.spoilt} chunks had a wrong checksum and were computed again", err=True)
    done = built.chunks - built.standing
    say(f"wrote {out}: {done} chunks in {built.seconds:.3g} s, {built.standing} stood already", err=True)
    if as_json:
        print_json(
            {
                "robot": plan.robot.name,
                "quantity": plan.quantity.name,
                "out": str(out),
                "postures": plan.points.count,
                "chunks": built.chunks,
                "standing": built.standing,
                "spoilt": built.spoilt,
                "bytes": plan.layout.size,
                "seconds": built.seconds,
            }
        )


@contextmanager
def _bar(quiet: bool) -> Iterator[tuple[Any, Any]]:
    """A bar over the chunks that are missing, with the time left; nothing off a terminal."""
    with shown_bar(desc="chunks", quiet=quiet) as bar:

        def begin(chunks: int, standing: int) -> None:
            bar.reset(chunks - standing)

        yield begin, bar.update


def _points(arm: Robot, grid: Sequence[str], sample: int | None, ranges: Sequence[str], seed: int) -> Points:
    from flexmodal.atlas import Grid, Sample, whole_range

    if bool(grid) == (sample is not None):
        found = "both of them" if grid else "none of them"
        raise InvalidRequest(Fault(SOURCE, "", found, "either --grid, once for each joint, or --sample"))
    if grid:
        if ranges:
            raise InvalidRequest(Fault(SOURCE, "--range", "given with --grid", "--sample"))
        return Grid(arm, _axes(arm, grid))
    assert sample is not None
    given = {name: _range(text, name) for name, text in _named(ranges, "--range").items()}
    return Sample(arm, sample, {**whole_range(arm, given), **given}, seed)


def _axes(arm: Robot, grid: Sequence[str]) -> dict[str, Any]:
    import numpy as np

    found = {}
    for name, text in _named(grid, "--grid").items():
        parts = text.split(":")
        if len(parts) not in (1, 3):
            allowed = "JOINT=START:STOP:COUNT or JOINT=VALUE"
            raise InvalidRequest(Fault(SOURCE, f"--grid {name}", repr(text[:60]), allowed))
        start = _value(parts[0], f"--grid {name}")
        if len(parts) == 1:
            found[name] = np.array([start])
            continue
        stop, count = _value(parts[1], f"--grid {name}"), parts[2].strip()
        if not count.isdecimal() or len(count) > 7 or not 1 <= int(count) <= 1_000_000:
            raise InvalidRequest(
                Fault(SOURCE, f"--grid {name}", repr(count[:60]), "a count from 1 to 1,000,000")
            )
        found[name] = np.linspace(start, stop, int(count))
    return found


def _range(text: str, name: str) -> tuple[float, float]:
    ends = [_value(part, f"--range {name}") for part in text.split(":")]
    if len(ends) not in (1, 2):
        raise InvalidRequest(Fault(SOURCE, f"--range {name}", repr(text[:60]), "JOINT=START:STOP"))
    return ends[0], ends[-1]


def _value(text: str, key: str) -> float:
    value = number(text.strip().removesuffix("deg"), key, "a number in rad or m, or like 50deg")
    return math.radians(value) if text.strip().endswith("deg") else value


def _named(texts: Sequence[str], option: str) -> dict[str, str]:
    found: dict[str, str] = {}
    for part in (part.strip() for text in texts for part in text.split(",")):
        name, equals, value = (piece.strip() for piece in part.partition("="))
        if not name or not equals or not value:
            raise InvalidRequest(Fault(SOURCE, option, repr(part[:60]), "JOINT=…"))
        if name in found:
            raise InvalidRequest(Fault(SOURCE, option, f"{name[:60]} twice", "each joint once"))
        found[name] = value
    return found


def _source(
    sourcing: Sourcing, arm: Robot, quantity: str, single: bool, quiet: bool
) -> PredictedReceptances | None:
    """The prediction asked for, if any."""
    if sourcing.campaign is not None:
        if quantity not in ("receptance", "depth"):
            allowed = "receptance or depth with --campaign: the others are of a model"
            raise InvalidRequest(Fault(SOURCE, "--quantity", quantity, allowed))
        if single:
            raise InvalidRequest(Fault(SOURCE, "--single", "given with --campaign", "none"))
    return sourcing.source(arm, quiet=quiet)


def _quantity(
    arm: Robot,
    quantity: str,
    frequencies: str | None,
    directions: Sequence[str],
    single: bool,
    cut_file: Path | None,
    speeds: int,
    source: PredictedReceptances | None,
) -> Quantity:
    from flexmodal.atlas import DepthOfCut, NaturalModes, Receptances, SourcedReceptances, Stiffnesses
    from flexmodal.machining import read_cut
    from flexmodal.prediction import PredictedTips

    wanted = {"--frequencies": quantity == "receptance", "--cut": quantity == "depth"}
    given = {"--frequencies": frequencies is not None, "--cut": cut_file is not None}
    for option, is_needed in wanted.items():
        if is_needed != given[option]:
            found = "missing" if is_needed else "given"
            allowed = f"it with --quantity {'receptance' if option == '--frequencies' else 'depth'} alone"
            raise InvalidRequest(Fault(SOURCE, option, f"{found} with --quantity {quantity}", allowed))
    if directions and quantity in ("modes", "depth"):
        raise InvalidRequest(Fault(SOURCE, "--direction", f"given with --quantity {quantity}", "none"))
    along = directions or (f"{arm.tool}:+z",)
    if quantity == "modes":
        return NaturalModes(arm)
    if quantity == "stiffness":
        return Stiffnesses.of(arm, along)
    if cut_file is not None:
        tips = None if source is None else PredictedTips(source)
        return DepthOfCut(arm, read_cut(cut_file), speeds, tips)
    pairs = [tuple(one.split("/", 1)) if "/" in one else one for one in along]
    if source is not None:
        return SourcedReceptances.of(arm, pairs, frequencies_of(frequencies or ""), source)  # type: ignore[arg-type]
    return Receptances.of(arm, pairs, frequencies_of(frequencies or ""), single=single)  # type: ignore[arg-type]
