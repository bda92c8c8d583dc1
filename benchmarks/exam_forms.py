"""The exams of forms that the rig's own formulas are not: what they ask, and their tables.

Each form three times: once on a shipped robot, twice on arms drawn at random; pairs, three to five at once,
nothing, and effects outside the catalogue on both kinds of robot.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from dataclasses import replace
from itertools import pairwise

import numpy as np
from exam_question import ARM, NAMED, OUTSIDE, ROBOTS, WHICH, Question

from flexmodal.rig import FORM_SETS

ON_ARMS = 2
"""Campaigns of each form on drawn arms, beside one on a shipped robot."""
NOTHING, PAIRS, SEVERAL, UNKNOWN = 12, 12, 12, 8
SPATIAL = "six_axis"
ONLY_SPATIAL = {"link_flexibility:twisting"}
"""Forms that a chain in a plane has no place for."""


def plan_forms(seed: int, which: str) -> list[Question]:
    """All questions of an exam of forms, in an order in which any beginning is a fair sample.

    Args:
        seed: of everything drawn.
        which: a key of `FORM_SETS`.
    """
    table = FORM_SETS[which]
    random = np.random.default_rng([seed, 95, WHICH.index(which)])
    turn = iter(random.integers(0, len(ROBOTS), 1000).tolist())

    def shipped(*keys: str) -> str:
        return SPATIAL if ONLY_SPATIAL & set(keys) else ROBOTS[next(turn)]

    found: list[Question] = []

    def ask(kind: str, names: tuple[str, ...], forms: tuple[str, ...], robot: str) -> None:
        found.append(Question("", robot, kind, names, 0, forms))

    for name in NAMED:
        for form in table[name]:
            ask("single", (name,), (form,), shipped(f"{name}:{form}"))
            for _ in range(ON_ARMS):
                ask("single", (name,), (form,), ARM)
    for kind, many in (("pair", PAIRS), ("several", SEVERAL)):
        for number in range(many):
            count = 2 if kind == "pair" else 3 + number % 3
            names = tuple(random.choice(NAMED, count, replace=False).tolist())
            forms = tuple(str(random.choice(table[name])) for name in names)
            keys = [f"{name}:{form}" for name, form in zip(names, forms, strict=True)]
            ask(kind, names, forms, ARM if number % 3 else shipped(*keys))
    for number in range(NOTHING):
        ask("nothing", (), (), ARM if number % 3 else shipped())
    for number in range(UNKNOWN):
        ask("outside", (OUTSIDE[number % len(OUTSIDE)],), ("own",), ARM if number % 2 else shipped())
    order = random.permutation(len(found)).tolist()
    seeds, arms = random.integers(1, 2**31, (2, len(found))).tolist()
    return [
        replace(found[k], name=f"{place:03d}", seed=seeds[k], arm=arms[k] if found[k].robot == ARM else 0)
        for place, k in enumerate(order, start=1)
    ]


def by_form(rows: list[dict]) -> list[str]:
    """A table of singles by form: named, placed, and the share of named ones."""
    groups: dict[tuple[str, str], list[dict]] = defaultdict(list)
    for row in rows:
        if row["kind"] == "single":
            groups[row["hidden"][0][0], row["forms"][0]].append(row)
    lines = [
        "| hidden | form | named | placed | share named | said instead |",
        "|---|---|---:|---:|---:|---|",
    ]
    for (name, form), some in sorted(groups.items(), key=lambda item: NAMED.index(item[0][0])):
        named, placed = sum(r["effect"] for r in some), sum(r["place"] for r in some)
        wrong = Counter(
            " + ".join(said for said, _ in r["said"]) or "nothing" for r in some if not r["effect"]
        )
        told = ", ".join(f"{what} ({count})" for what, count in wrong.most_common())
        share = f"{100 * named / len(some):.0f} %"
        lines.append(f"| {name} | {form} | {named}/{len(some)} | {placed}/{len(some)} | {share} | {told} |")
    return lines


EDGES = (0.0, 0.1, 0.3, 1.0, 3.0)
"""Heights with all else re-tuned, over the noise of one record, from which effects are counted together."""


def by_height(rows: list[dict]) -> list[str]:
    """A table of all hidden effects that have a name: how many are named in their place, by what is left."""
    known = [
        (height, where in row["said"], len(row["hidden"]) > 1)
        for row in rows
        if row["kind"] in ("single", "pair", "several") and row["retuned"]
        for where, height in zip(row["hidden"], row["retuned"], strict=True)
    ]
    if not known:
        return []
    lines = [
        "",
        "How high an effect stands once the robot's parameters and the numbers of what else is hidden are",
        "fitted to it, over the noise of one record:",
        "",
        "| height re-tuned | alone: named in its place | beside others |",
        "|---|---:|---:|",
    ]
    for low, high in pairwise((*EDGES, float("inf"))):
        some = [(named, beside) for height, named, beside in known if low <= height < high]
        alone = [named for named, beside in some if not beside]
        other = [named for named, beside in some if beside]
        what = f"{low:g} to {high:g}" if high < float("inf") else f"{low:g} and more"
        lines.append(f"| {what} | {sum(alone)} of {len(alone)} | {sum(other)} of {len(other)} |")
    return lines


def at_once(rows: list[dict]) -> list[str]:
    """A table of campaigns with several effects: all of them named, and what part of those hidden."""
    lines = [
        "| hidden at once | campaigns | all named | all placed | of the effects, named | named beside |",
        "|---:|---:|---:|---:|---:|---:|",
    ]
    groups: dict[int, list[dict]] = defaultdict(list)
    for row in rows:
        if row["kind"] in ("pair", "several"):
            groups[len(row["hidden"])].append(row)
    for count, some in sorted(groups.items()):
        hidden = [Counter(name for name, _ in r["hidden"]) for r in some]
        said = [Counter(name for name, _ in r["said"]) for r in some]
        met = sum((one & other).total() for one, other in zip(hidden, said, strict=True))
        beside = sum((other - one).total() for one, other in zip(hidden, said, strict=True))
        whole, placed = sum(r["effect"] for r in some), sum(r["place"] for r in some)
        lines.append(
            f"| {count} | {len(some)} | {whole} | {placed} | {met} of {count * len(some)} | {beside} |"
        )
    return lines
