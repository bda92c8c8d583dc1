"""`flexmodal lookup`."""

from __future__ import annotations

import math
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from flexmodal.cli.options import (
    SOURCE,
    force_option,
    json_option,
    number,
    quiet_option,
    refuse_existing,
)
from flexmodal.cli.printing import print_json, print_table, progress, say
from flexmodal.errors import Fault, InvalidRequest

if TYPE_CHECKING:
    from flexmodal.atlas import Atlas, Reach, Spot, Task

_ENDINGS = (".html", ".png", ".svg")


@click.command()
@click.argument("store", type=click.Path(path_type=Path))
@click.option("--nearest", metavar="POSTURE", help="What it has nearest to q1=50deg,q2=-0.8.")
@click.option("--interpolate", metavar="POSTURE", help="What a grid has there, linearly in between.")
@click.option("--best", "count", type=click.IntRange(1, 1000), help="So many of the best postures.")
@click.option(
    "--map", "out", type=click.Path(path_type=Path), help="A map of the workspace: .html, .png, .svg."
)
@click.option("--frequency", metavar="HZ", help="The line that counts; of several LOW:HIGH the worst.")
@click.option("--speed", metavar="RPM", help="The spindle speed that counts, or LOW:HIGH; all if none.")
@click.option("--direction", default="", metavar="POINT:AXIS", help="The direction or pair that counts.")
@click.option(
    "--mode", type=click.IntRange(min=1), default=1, show_default=True, help="The mode that counts."
)
@click.option("--near", metavar="X,Y,Z", help="Only postures with the tool near there [m].")
@click.option("--radius", default="0.1", show_default=True, metavar="METRES", help="How near.")
@click.option("--plane", type=click.Choice(["xz", "xy", "yz"]), help="Of --map; the widest if none.")
@force_option
@quiet_option
@json_option
def lookup(
    store: Path,
    nearest: str | None,
    interpolate: str | None,
    count: int | None,
    out: Path | None,
    frequency: str | None,
    speed: str | None,
    direction: str,
    mode: int,
    near: str | None,
    radius: str,
    plane: str | None,
    force: bool,
    quiet: bool,
    as_json: bool,
) -> None:
    """What an atlas has: near a posture, between postures, the best for a task, a map of the workspace."""
    from flexmodal import atlas as room

    asked = [nearest is not None, interpolate is not None, count is not None, out is not None]
    if sum(asked) > 1:
        allowed = "one of --nearest, --interpolate, --best and --map"
        raise InvalidRequest(Fault(SOURCE, "", "several questions", allowed))
    refuse_existing(out, force, _ENDINGS, option="--map")
    task = room.Task(_band(frequency, speed), direction, mode)
    read = room.open_atlas(store)
    _check_band(read, frequency, speed)
    if not read.is_complete:
        say(f"note: {len(read.standing)} of {read.layout.chunks} chunks are there", err=True)
    if nearest is not None:
        spot, found = room.nearest(read, _posture(nearest, "--nearest"))
        _give_values(found, as_json, spot)
    elif interpolate is not None:
        _give_values(room.interpolated(read, _posture(interpolate, "--interpolate")), as_json, None)
    elif count is not None:
        with progress(len(read.standing), "looking", quiet=quiet) as advance:
            spots = room.best(read, task, count=count, where=_where(near, radius), advance=advance)
        _give_best(read, task, spots, as_json)
    elif out is not None:
        _write_map(read, task, out, plane or "", force, quiet)
        if as_json:
            print_json({"out": str(out)})
    else:
        _give_summary(read, as_json)


def _band(frequency: str | None, speed: str | None) -> tuple[float, float] | None:
    if frequency is not None and speed is not None:
        raise InvalidRequest(Fault(SOURCE, "--speed", "given with --frequency", "one of them"))
    text, option = (frequency, "--frequency") if frequency is not None else (speed, "--speed")
    if text is None:
        return None
    ends = [number(part, option, "a value, or LOW:HIGH") for part in text.split(":")]
    if len(ends) > 2 or ends[0] > ends[-1]:
        raise InvalidRequest(Fault(SOURCE, option, repr(text[:60]), "a value, or LOW:HIGH"))
    return ends[0], ends[-1]


def _check_band(read: Atlas, frequency: str | None, speed: str | None) -> None:
    for option, text, quantity in (("--frequency", frequency, "receptance"), ("--speed", speed, "depth")):
        if text is not None and read.quantity != quantity:
            found = f"given for an atlas of {read.quantity}"
            raise InvalidRequest(Fault(SOURCE, option, found, f"an atlas of {quantity}"))


def _posture(text: str, option: str) -> dict[str, float]:
    found: dict[str, float] = {}
    for part in text.split(","):
        name, equals, value = (piece.strip() for piece in part.partition("="))
        if not name or not equals or name in found:
            raise InvalidRequest(Fault(SOURCE, option, repr(part[:60]), "JOINT=VALUE, each joint once"))
        plain = number(value.removesuffix("deg"), f"{option} {name}", "a number in rad or m, or like 50deg")
        found[name] = math.radians(plain) if value.endswith("deg") else plain
    return found


def _where(near: str | None, radius: str) -> Any:
    import numpy as np

    from flexmodal.atlas import within

    if near is None:
        return None
    place = [number(part, "--near", "coordinates X,Y,Z [m]") for part in near.split(",")]
    if len(place) != 3:
        raise InvalidRequest(Fault(SOURCE, "--near", f"{len(place)} coordinates", "X,Y,Z [m]"))
    return within(np.eye(3), np.array(place), number(radius, "--radius", "a length [m]"))


def _give_values(found: Any, as_json: bool, spot: Spot | None) -> None:
    import numpy as np

    values = {str(name): np.asarray(array.values) for name, array in found.data_vars.items()}
    labels = {str(name): np.asarray(found[name].values) for name in found.dims}
    head: dict[str, Any] = {"tool": found["tool"].values.tolist()}
    if spot is not None:
        head |= {"posture": spot.posture, "distance": spot.distance}
    if as_json:
        plain = {name: one.tolist() for name, one in labels.items() if name != "axis"}
        print_json({**head, **plain, **{name: _plain(one) for name, one in values.items()}})
        return
    for key, value in head.items():
        say(f"{key}: {value}")
    for name, one in values.items():
        dims = [str(dim) for dim in found[name].dims]
        rows = []
        for place in list(np.ndindex(one.shape))[:40]:
            cells = [str(labels[dim][index]) for dim, index in zip(dims, place, strict=True)]
            rows.append([*cells, f"{np.abs(one[place]):.5g}"])
        more = f" (first 40 of {one.size}; --json gives all)" if one.size > 40 else ""
        word = "amplitude" if np.iscomplexobj(one) else name
        print_table(f"{name}{more}", [*dims, f"{word} [{found[name].attrs.get('units', '')}]"], rows)


def _plain(array: Any) -> Any:
    """Lists for JSON; what is not a number or infinite is null."""
    import numpy as np

    if np.iscomplexobj(array):
        return {"re": _plain(array.real), "im": _plain(array.imag)}
    if array.ndim == 0:
        return float(array) if np.isfinite(array) else None
    return [_plain(one) for one in array]


def _give_best(read: Atlas, task: Task, spots: list[Spot], as_json: bool) -> None:
    from flexmodal.atlas import reach

    unit, told = task.unit(read.quantity), [reach(read, task, one) for one in spots]
    if as_json:
        found = [
            {"value": one.value, "posture": one.posture, "tool": list(one.tool)}
            | ({} if there is None else {"prediction": asdict(there)})
            for one, there in zip(spots, told, strict=True)
        ]
        print_json({"unit": unit, "best": found})
        return
    rows = [
        [
            f"{one.value:.5g}",
            *([] if there is None else [f"{there.low:.3g} to {there.high:.3g}", _outside(there)]),
            ", ".join(f"{x:.4f}" for x in one.tool),
            ",".join(f"{k}={v:.6g}" for k, v in one.posture.items()),
        ]
        for one, there in zip(spots, told, strict=True)
    ]
    band = [] if read.source is None else [f"95 % band [{unit}]", "struck there"]
    print_table(
        "The best postures; a start for flexmodal optimise --start",
        [f"value [{unit}]", *band, "tool [m]", "posture"],
        rows,
    )
    if read.source is not None:
        say(f"receptances {read.source['verdict']}")


def _outside(there: Reach) -> str:
    """Where a posture is beside what was struck."""
    if there.beyond:
        return f"no: {there.beyond} joint{'s' if there.beyond > 1 else ''} outside"
    return "within" if there.remote <= 1 else f"within, {there.remote:.1f} times as far"


def _give_summary(read: Atlas, as_json: bool) -> None:
    sizes = {str(name): int(size) for name, size in read.dataset.sizes.items()}
    if as_json:
        print_json(
            {
                "robot": read.facts["robot"],
                "quantity": read.quantity,
                "sizes": sizes,
                "chunks": read.layout.chunks,
                "standing": len(read.standing),
                "ranges": {name: list(ends) for name, ends in read.ranges.items()},
            }
        )
        return
    say(str(read.dataset.attrs.get("title", read.path.name)))
    rows = [
        [name, f"{low:.6g}", f"{high:.6g}", str(sizes.get(name, 1))]
        for name, (low, high) in read.ranges.items()
    ]
    print_table("Joints", ["joint", "from", "to", "values"], rows)
    if read.source is not None:
        say(f"of {read.source['campaign']}: receptances {read.source['verdict']}")
    others = ", ".join(f"{name} {size}" for name, size in sizes.items() if name not in read.ranges)
    say(f"{others}; {len(read.standing)} of {read.layout.chunks} chunks are there")


def _write_map(read: Atlas, task: Task, out: Path, plane: str, force: bool, quiet: bool) -> None:
    from flexmodal.atlas import best, draw_map, workspace_map, write_map_page
    from flexmodal.report import write_figure

    with progress(2 * len(read.standing), "looking", quiet=quiet) as advance:
        found = workspace_map(read, task, plane=plane, advance=advance)
        spots = best(read, task, advance=advance)
    what = _words(read, task)
    if out.suffix.lower() == ".html":
        write_map_page(read, found, spots, out, what=what, task=task, overwrite=force)
    else:
        write_figure(draw_map(found, f"{read.facts['robot']}: {what}"), out, overwrite=force)
    say(f"wrote {out}", err=True)


def _words(read: Atlas, task: Task) -> str:
    band = ""
    if task.band is not None:
        low, high = task.band
        unit = "rev/min" if read.quantity == "depth" else "Hz"
        band = f" at {low:g} {unit}" if low == high else f" from {low:g} to {high:g} {unit}"
    kind = {
        "receptance": "receptance",
        "modes": f"natural frequency {task.mode}",
        "stiffness": "stiffness",
        "depth": "depth of cut",
    }
    return f"{kind[read.quantity]} {task.label_in(read.dataset, read.quantity)}".strip() + band
