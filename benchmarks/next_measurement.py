"""How many measurements until one explanation stands: by expected information, by chance, by habit.

    python benchmarks/next_measurement.py [--campaigns N] [--first SEED]

Small campaigns of one sensor, one hammer point and one posture, with an effect hidden, of which the
ambiguous ones count: those whose diagnosis leaves ties, an unknown or a doubt. Each then goes on by one FRF
at a time: the one that the diagnosis asks for; one drawn from everything that could be asked for, by two
seeds; and the one of habit, the same FRF in the next posture of the robot's card. An explanation stands once
the model is at the noise and no other has a probability of 5 % or more. Rows are kept in build/, so that a
run goes on.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import Any

import numpy as np
from tables import answered, write

import flexmodal
from flexmodal.diagnosis import Diagnosis, diagnose
from flexmodal.diagnosis.effects import Context
from flexmodal.diagnosis.next_measurement.setups import Bench, postures_to_try
from flexmodal.diagnosis.selection.comparison import TIE
from flexmodal.errors import InvalidRequest
from flexmodal.identification import observe
from flexmodal.rig import Hide, RigResult, simulate
from flexmodal.rig.asked import Asked
from flexmodal.rig.continued import measured_besides

FIRST = 61_000
"""Of the seeds: none from here on was looked at while the choice was made; `--first` looks at others."""
HIDDEN = (
    "added_mass", "local_absorber", "joint_coupling", "servo_compliance", "link_flexibility",
    "base_flexibility", "bearing_flexibility",
)  # fmt: skip
HEIGHTS = (4.0, 20.0)
"""Of the effect over the noise floor."""
ROBOT, MOST, CHANCES = "fanuc_s360", 4, 2
"""The most measurements that are taken, and how often chance is tried."""
SMALL = {
    "postures": 1, "points": 1, "references": 1, "trials": 2, "averages": 2, "record_length": 2.0,
    "band": (2.0, 120.0), "peaks": [120.0], "parameter_error": 0.05, "time": False,
}  # fmt: skip

Policy = Callable[[RigResult, Diagnosis, int], Asked]


def stands(found: Diagnosis) -> bool:
    """Whether one explanation does: the model is at the noise, and nothing else is probable."""
    if not found.verdict.explained:
        return False
    if any(step.ties for step in found.steps):
        return False
    others = [one.confidence for one in found.refused if one.effect != "none"]
    return bool(found.steps) or max(others, default=0.0) < TIE


def by_information(made: RigResult, found: Diagnosis, number: int) -> Asked:
    """What the diagnosis asks for; by habit where it asks for nothing."""
    one = found.next_measurement
    if one is None:
        return by_habit(made, found, number)
    return Asked(
        one.posture, one.response, one.reference, one.force_peak, one.new_points, one.locked, one.masses
    )


def by_habit(made: RigResult, found: Diagnosis, number: int) -> Asked:
    """The same FRF in the posture of the card that comes next."""
    (u, v), (s, t) = Bench.of(observe(made.campaign), context_of(made)).rows[0]
    listed = list(made.robot.postures.values())
    return Asked(dict(listed[(1 + number) % len(listed)]), (u, v), (s, t))


def by_chance(seed: int) -> Policy:
    """Anything that could be asked for: a posture, a place of sensor or hammer, perhaps a lock or a mass."""
    random = np.random.default_rng([seed, 5])

    def drawn(made: RigResult, found: Diagnosis, number: int) -> Asked:
        context = context_of(made)
        bench = Bench.of(observe(made.campaign), context)
        postures = postures_to_try(context, int(random.integers(2**31)))
        q = postures[int(random.integers(len(postures)))]
        kind = int(random.integers(3))
        rows = bench.other_rows if kind == 1 else bench.rows
        moving = [row for row in rows if _moves(bench, context, row)]
        response, reference = moving[int(random.integers(len(moving)))]
        locked, masses = (), {}
        if kind == 2:
            locked, masses = bench.fixtures[int(random.integers(len(bench.fixtures)))]
        new = {point.id: point.name for point in bench.new if point.id in (response[0], reference[0])}
        bolted = {point.id: point.name for point in bench.new if point.name in masses}
        return Asked(dict(q), response, reference, None, {**new, **bolted}, locked, masses)

    return drawn


def _moves(bench: Bench, context: Context, row: tuple[tuple[int, int], tuple[int, int]]) -> bool:
    """Whether both places move along their directions: across the plane of a planar arm nothing does."""
    normal = context.normal
    if normal is None:
        return True
    ways = np.eye(3)
    return all(abs(ways[place[1] - 1] @ normal) < 0.5 for place in row)


def context_of(made: RigResult) -> Context:
    """Of a campaign as the diagnosis sees it."""
    return Context.of(made.robot, observe(made.campaign))


def posed(seed: int) -> RigResult | None:
    """A small campaign with an effect hidden in it; None where the place that is drawn can have none."""
    effect = HIDDEN[seed % len(HIDDEN)]
    try:
        return simulate(
            flexmodal.load(ROBOT),
            hide=[Hide(effect, height=HEIGHTS)],
            seed=seed,
            **SMALL,  # type: ignore[arg-type]
        )
    except InvalidRequest:
        return None


def followed(made: RigResult, first: Diagnosis, policy: Policy) -> dict[str, Any]:
    """Measurements until one explanation stands, and whether it is the one that is hidden."""
    found, now = first, made
    asked: list[str] = []
    for number in range(MOST + 1):
        if stands(found):
            return {"count": number, "right": right(made, found), "asked": asked}
        if number == MOST:
            break
        one = policy(now, found, number)
        asked.append(told(one))
        try:
            now = measured_besides(now.campaign, now.truth, now.robot, one)
        except InvalidRequest as error:
            asked[-1] += f" (refused: {error.faults[0].key})"
            continue
        found = diagnose(now.campaign, now.robot)
    return {"count": None, "right": right(made, found), "asked": asked}


def right(made: RigResult, found: Diagnosis) -> bool:
    """Whether what is said is what is hidden."""
    return sorted(found.verdict.effects) == sorted((one.effect, one.where) for one in made.truth.effects)


def told(one: Asked) -> str:
    """A measurement in a word or two."""
    kinds = ["lock"] * bool(one.locked) + ["mass"] * bool(one.masses)
    return "+".join([*kinds, *(["place"] if one.new_points else [])]) or "posture"


def one(seed: int) -> dict[str, Any]:
    """A campaign from its seed, and what came of it by each policy."""
    made = posed(seed)
    if made is None:
        return {"seed": seed, "ambiguous": None}
    first = diagnose(made.campaign, made.robot)
    hidden = [(one.effect, one.where) for one in made.truth.effects]
    row: dict[str, Any] = {
        "seed": seed,
        "hidden": hidden,
        "said": first.verdict.effects,
        "ambiguous": not stands(first),
    }
    if row["ambiguous"]:
        row["information"] = followed(made, first, by_information)
        row["habit"] = followed(made, first, by_habit)
        row["chance"] = [followed(made, first, by_chance(seed * CHANCES + k)) for k in range(CHANCES)]
    return row


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--campaigns", type=int, default=40, help="posed; about two in five are ambiguous")
    parser.add_argument("--first", type=int, default=FIRST, help="of the seeds")
    given = parser.parse_args()
    seeds = range(given.first, given.first + given.campaigns)
    report(answered(f"next-{given.first}", seeds, one), given.first == FIRST)


def report(rows: list[dict[str, Any]], published: bool) -> None:
    """Print the table, and write it for the seeds that nobody looked at."""
    posed_ = [row for row in rows if row["ambiguous"] is not None]
    some = [row for row in posed_ if row["ambiguous"]]
    table = [
        [f"{row['seed']}", ", ".join(f"{e} {w}" for e, w in row["hidden"]),
         ", ".join(f"{e} {w}" for e, w in row["said"]) or "nothing missing",
         _word(row["information"]), *(_word(each) for each in row["chance"]), _word(row["habit"])]
        for row in some
    ]  # fmt: skip
    by = {
        "information": [row["information"] for row in some],
        "chance": [each for row in some for each in row["chance"]],
        "habit": [row["habit"] for row in some],
    }
    end = "\n\n".join(f"By {name}: {_sum(each)}." for name, each in by.items() if each)
    header = [
        "seed",
        "hidden",
        "said at first",
        "information",
        *(f"chance {k + 1}" for k in range(CHANCES)),
        "habit",
    ]
    lead = (
        f"Made by `python benchmarks/next_measurement.py`: {len(posed_)} campaigns of one sensor, one hammer "
        f"point and one posture on {ROBOT}, of which {len(some)} are ambiguous. Each then goes on by one "
        f"FRF at a time, {MOST} at most, until one explanation stands. Told is how many that took, – where "
        "none stood yet, × where it is not what was hidden. None of these seeds was looked at before."
    )
    if published:
        write(
            "next_measurement", "How many measurements until one explanation stands", lead, header, table, end
        )
    else:
        print(lead, *(" | ".join(line) for line in table), end, sep="\n")


def _word(found: dict[str, Any]) -> str:
    return ("–" if found["count"] is None else str(found["count"])) + ("" if found["right"] else " ×")


def _sum(some: list[dict[str, Any]]) -> str:
    """Mean number of measurements, those that never ended counted as one more than the most."""
    counts = [MOST + 1 if each["count"] is None or not each["right"] else each["count"] for each in some]
    stood = sum(each["count"] is not None for each in some)
    right_ = sum(each["count"] is not None and each["right"] for each in some)
    return (
        f"one explanation stands in {stood} of {len(some)}, the hidden one in {right_}; "
        f"{np.mean(counts):.2f} measurements on average until that, {MOST + 1} where it never did"
    )


if __name__ == "__main__":
    main()
