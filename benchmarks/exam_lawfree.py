"""What the law-free look alone says of single effects: where, and of what class, before any law is tried."""

from __future__ import annotations

from collections import defaultdict

from exam_question import NAMED

from flexmodal.diagnosis.lawfree.result import CLASSES_OF, PORT_OF, holds


def law_free(rows: list[dict]) -> list[str]:
    """A table by effect: the true place among those that cannot be told apart, alone, and its class.

    Args:
        rows: campaigns with a single effect, with the places that the look for one place points to.
    """
    able = [row for row in rows if row["look"]]
    if not able:
        return []
    groups: dict[str, list[dict]] = defaultdict(list)
    for row in able:
        groups[row["hidden"][0][0]].append(row)
    lines = [
        "", "## Without a law", "",
        "What the law-free look says before any effect of the catalogue is fitted. *Among* counts campaigns "
        "in which the true place is the first or cannot be told from it, *alone* those in which nothing else "
        "is, *class* those whose curve may be of a class that the effect has (of those with a curve).", "",
        "| hidden | campaigns | among | alone | class |", "|---|---:|---:|---:|---:|",
    ]  # fmt: skip
    total = [0, 0, 0, 0, 0]
    for name in (*NAMED, *(other for other in groups if other not in NAMED)):
        some = groups.get(name, [])
        if not some:
            continue
        figures = [_placed(row) for row in some]
        found = [len(some), *(sum(one[k] for one in figures) for k in range(4))]
        total = [one + other for one, other in zip(total, found, strict=True)]
        lines.append(_row(name, found))
    return [*lines, _row("all", total)]


def _row(name: str, found: list[int]) -> str:
    many, among, alone, classed, curves = found
    told = f"{classed} of {curves}" if curves else "–"
    return f"| {name} | {many} | {among} | {alone} | {told} |"


def _placed(row: dict) -> tuple[bool, bool, bool, bool]:
    """Whether the true place is there, is there alone, has the right class, and has a curve."""
    (name, where), first = row["hidden"][0], row["look"][0]
    true = PORT_OF.get(name, ""), where
    alike = [tuple(one) for one in first["alike"]]
    among = any(one[1] == where and holds(one, true) for one in alike)
    alone = among and all(holds(one, true) or holds(true, one) for one in alike)
    curve = among and first["curve"] and name in CLASSES_OF and first["where"] == where
    return among, alone, curve and any(one in CLASSES_OF[name] for one in first["classes"]), curve
