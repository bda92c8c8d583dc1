"""How long a diagnosis and an identification take, beside another checkout, and where the time goes.

    python benchmarks/diagnosis_speed.py --against DIR [--rounds N] [--most N]

Campaigns are simulated once by this checkout. Each round lets the two checkouts answer in turn, every answer
in a process of its own on one thread; processor time counts, with imports and the loading of compiled code.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

from tables import write

HERE = Path(__file__).resolve().parent.parent
CAMPAIGNS = (
    ("standard", "fanuc_s360_rigid_link", ("link_flexibility",), 3),
    ("coupled", "six_link", ("joint_coupling",), 4),
    ("foundation", "fanuc_s360", ("base_flexibility",), 7),
    ("absorber", "six_axis", ("local_absorber",), 8),
    ("nothing", "fanuc_s360", (), 9),
    ("friction", "fanuc_s360", ("coulomb_friction",), 6),
    ("unexplained", "fanuc_s360", ("clearance",), 5),
)
"""Name, robot, hidden effects, seed; 5 postures × 5 points × 2 references × 2 levels."""
TASKS = ("diagnose", "identify")
PARTS = {
    "receptances": "structure/kernel.py",
    "receptances in numpy, normal equations": "identification/",
    "structures": "structure/",
    "effects and hypotheses": "diagnosis/effects",
    "time integration": "diagnosis/march",
    "comparison and report": "diagnosis/",
    "numpy and scipy": "site-packages/numpy",
    "import": "<frozen importlib",
}
"""Where a line of a profile belongs, the first that fits."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--against", type=Path, help="another checkout")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--most", type=int, default=len(CAMPAIGNS), help="only so many campaigns")
    parser.add_argument("--answer", nargs=2, metavar=("TASK", "FOLDER"), help=argparse.SUPPRESS)
    parser.add_argument("--profile", action="store_true", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.answer:
        print(json.dumps(answer(given.answer[0], Path(given.answer[1]), profiled=given.profile)))
        return
    with tempfile.TemporaryDirectory() as scratch:
        compare(given.against, given.rounds, CAMPAIGNS[: given.most], Path(scratch))


def answer(task: str, folder: Path, *, profiled: bool) -> dict[str, object]:
    """In a process of its own: what is found, and the processor time since it began."""
    import cProfile
    import time

    import flexmodal
    from flexmodal.campaign import read_campaign
    from flexmodal.diagnosis import diagnose
    from flexmodal.identification import identify

    campaign, robot = read_campaign(folder), flexmodal.load(str(folder / "robot" / "robot.toml"))
    profile = cProfile.Profile() if profiled else None
    before = time.process_time()
    run = profile.runcall if profile else lambda call, *args: call(*args)
    if task == "diagnose":
        found = run(diagnose, campaign, robot)
        says: object = [list(map(list, found.verdict.effects)), round(found.gaps.after, 6)]
    else:
        outcome = run(identify, campaign, robot)
        says = [round(float(value), 5) for value in outcome.fitted.x]
    made: dict[str, object] = {
        "start": before, "seconds": time.process_time() - before, "says": says,
    }  # fmt: skip
    if profile:
        made |= where(profile)
    return made


def where(profile: object) -> dict[str, object]:
    """Shares of the time by part, and the points whose receptances were computed."""
    import pstats

    stats = pstats.Stats(profile).stats  # type: ignore[attr-defined, arg-type]
    share = dict.fromkeys([*PARTS, "other"], 0.0)
    points = calls = 0.0
    for (file, _, name), (_, count, own, _, _) in stats.items():
        place = next((part for part, piece in PARTS.items() if piece in file), "other")
        share[place] += own
        if "structure/kernel.py" in file and name.startswith("solve"):
            points, calls = own, count
    whole = sum(share.values())
    return {
        "parts": {part: seconds / whole for part, seconds in share.items()},
        "solving": points, "solves": calls, "profiled": whole,
    }  # fmt: skip


def ask(checkout: Path, task: str, folder: Path, *more: str) -> dict[str, object]:
    """One answer of a checkout."""
    env = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "PYTHONPATH": str(checkout)}
    command = [sys.executable, __file__, "--answer", task, str(folder), *more]
    done = subprocess.run(command, env=env, capture_output=True, text=True, check=False, cwd=folder)
    if done.returncode:
        raise RuntimeError(f"{checkout.name}, {task}: {done.stderr[-2000:]}")
    return dict(json.loads(done.stdout.splitlines()[-1]))


def compare(
    against: Path | None,
    rounds: int,
    campaigns: tuple[tuple[str, str, tuple[str, ...], int], ...],
    scratch: Path,
) -> None:
    """Both checkouts in turn, campaign by campaign; tables of ratios and of where the time goes."""
    rows: list[list[str]] = []
    parts: list[str] = []
    ratios: dict[str, list[float]] = {task: [] for task in TASKS}
    for name, robot, hidden, seed in campaigns:
        folder = simulated(robot, hidden, seed, scratch / name)
        for task in TASKS:
            here, there, same = in_turn(task, folder, against, rounds)
            ratios[task].append(there / here)
            rows.append([f"{name}: {task}", f"{here:.2f}", f"{there / here:.1f}", "yes" if same else "no"])
            print(rows[-1], flush=True)
        seen = ask(HERE, "diagnose", folder, "--profile")
        shares: dict[str, float] = dict(seen["parts"])  # type: ignore[call-overload]
        limit = float(str(seen["solving"])) / max(float(str(seen["profiled"])), 1e-9)
        row = [
            name,
            *(f"{100 * share:.0f}" for share in shares.values()),
            str(seen["solves"]),
            f"{100 * limit:.0f}",
        ]
        parts.append(f"| {' | '.join(row)} |")
    found = ", ".join(f"{task} {statistics.median(some):.1f}" for task, some in ratios.items())
    header = ["campaign", *PARTS, "other", "solutions", "limit"]
    end = [
        f"Median ratio: {found}.",
        "",
        "Where the time of a diagnosis goes, % under the profiler. The last column is what solving all",
        "structures takes: what no code around it could go below.",
        "",
        f"| {' | '.join(header)} |",
        "|---" * len(header) + "|",
        *parts,
    ]
    write(
        "diagnosis_speed",
        "How long a diagnosis and an identification take",
        "By `python benchmarks/diagnosis_speed.py --against DIR`: processor time of one core with imports, "
        "and its ratio to another checkout's; rounds interleaved, medians; whether both answered the same.",
        ["campaign", "s", "× faster", "same answer"],
        rows,
        "\n".join(end),
    )


def in_turn(task: str, folder: Path, against: Path | None, rounds: int) -> tuple[float, float, bool]:
    """Median seconds here and there, NaN without another checkout, and whether the answers are the same."""
    here, there, same = [], [], True
    for _ in range(rounds + 1):  # the first one compiles
        one = ask(HERE, task, folder)
        here.append(float(str(one["seconds"])))
        if against is not None:
            other = ask(against.resolve(), task, folder)
            there.append(float(str(other["seconds"])))
            same = same and one["says"] == other["says"]
    return statistics.median(here[1:]), statistics.median(there[1:]) if there else float("nan"), same


def simulated(robot: str, hidden: tuple[str, ...], seed: int, folder: Path) -> Path:
    """A standard campaign on disk."""
    import flexmodal
    from flexmodal.campaign import write_campaign
    from flexmodal.rig import draw_scenario, simulate
    from flexmodal.rig.robot_folder import write_robot

    believed = flexmodal.load(robot)
    points = min(5, len(believed.points))
    names = tuple(one.partition("@")[0] for one in hidden)
    scenario = draw_scenario(believed, seed, count=len(names), effects=names or None, points=points)
    made = simulate(
        believed, postures=5, points=points, hide=scenario.hide, parameter_error=scenario.parameter_error,
        seed=seed, time=False,
    )  # fmt: skip
    write_campaign(made.campaign, folder)
    write_robot(made.robot, folder, made.plan.postures, made.plan.points)
    return folder


if __name__ == "__main__":
    main()
