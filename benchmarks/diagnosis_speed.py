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
    ("foundation", "fanuc_s360", ("base_flexibility",), 7),
    ("nothing", "fanuc_s360", (), 9),
    ("coupled", "six_link", ("joint_coupling",), 4),
    ("standard", "fanuc_s360_rigid_link", ("link_flexibility",), 3),
    ("absorber", "six_axis", ("local_absorber",), 8),
    ("unexplained", "fanuc_s360", ("clearance",), 5),
    ("friction", "fanuc_s360", ("coulomb_friction",), 6),
)
"""Name, robot, hidden effects, seed; 5 postures × 5 points × 2 references × 2 levels."""
POSTURES, MANY_POSTURES = 5, 22
"""The second for diagnoses that are asked once more, of the same robots and effects."""
SAME = 1e-2
"""Relative difference of gaps up to which two answers are the same."""
TASKS = ("diagnose", "identify")
STAGES = {
    "reading and noise": (("diagnosis/setup.py", "prepare"),),
    "law-free looks": (("lawfree/first_look.py", "one"), ("lawfree/first_look.py", "several")),
    "searches": (
        ("search/explanations.py", "explanations"),
        ("search/explanations.py", "from_each_start"),
        ("search/next_level.py", "at_next_level"),
    ),
    "last fits": (
        ("selection/selection.py", "drop_needless"),
        ("selection/frf_data.py", "conclude"),
        ("selection/frf_data.py", "stand_in"),
    ),
}
"""Functions whose own time and that of all they call makes a stage; none of them calls another one."""
KERNELS = {
    "solving": ("structure/solve_kernel.py", "solve"),
    "derivatives": ("structure/slope_kernel.py", "pull"),
    "ports": ("structure/port_kernel.py", ""),
    "time steps": ("time_domain/kernel.py", "integrate"),
}


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
    os.environ["OPENBLAS_NUM_THREADS"] = os.environ["FLEXMODAL_WORKERS"] = "1"
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
        says: object = [list(map(list, found.verdict.effects)), found.gaps.after]
    else:
        outcome = run(identify, campaign, robot)
        says = ["identified", outcome.gap.held_out_after or outcome.gap.after]
    made: dict[str, object] = {
        "start": before, "seconds": time.process_time() - before, "says": says,
    }  # fmt: skip
    if profile:
        made |= where(profile)
    return made


def where(profile: object) -> dict[str, object]:
    """Shares of the time by stage and by compiled kernel, and receptances that were solved for."""
    import pstats

    stats = pstats.Stats(profile)  # type: ignore[arg-type]
    entries = stats.stats  # type: ignore[attr-defined]
    whole = stats.total_tt  # type: ignore[attr-defined]
    stages = {
        stage: sum(
            entry[3]
            for (file, _, name), entry in entries.items()
            if any(piece in file and name == function for piece, function in functions)
        )
        / whole
        for stage, functions in STAGES.items()
    }
    kernels = {
        what: sum(
            entry[2] for (file, _, name), entry in entries.items() if piece in file and name.startswith(start)
        )
        / whole
        for what, (piece, start) in KERNELS.items()
    }
    return {"stages": stages, "kernels": kernels}


def ask(checkout: Path, task: str, folder: Path, *more: str) -> dict[str, object]:
    """One answer of a checkout, by its own environment where it has one."""
    own = checkout / ".venv" / "bin" / "python"
    env = {**os.environ, "PYTHONPATH": str(checkout)}
    command = [str(own) if own.exists() else sys.executable, __file__]
    command += ["--answer", task, str(folder), *more]
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
    parts: list[list[str]] = []
    ratios: dict[str, list[float]] = {task: [] for task in TASKS}
    few: list[float] = []
    many: list[float] = []
    for name, robot, hidden, seed in campaigns:
        folder = simulated(robot, hidden, seed, scratch / name, POSTURES)
        for task in TASKS:
            if name == campaigns[0][0]:  # what is compiled is kept on disk
                in_turn(task, folder, against, 1)
            here, there, same = in_turn(task, folder, against, rounds)
            ratios[task].append(there / here)
            few += [here] if task == "diagnose" else []
            rows.append(row_of(f"{name}: {task}", here, there, same))
        seen = ask(HERE, "diagnose", folder, "--profile")
        shares = [*dict(seen["stages"]).values(), *dict(seen["kernels"]).values()]  # type: ignore[call-overload]
        parts.append([name, *(f"{100 * share:.0f}" for share in shares)])
    for name, robot, hidden, seed in campaigns:  # once, for the other checkout may take many minutes
        folder = simulated(robot, hidden, seed, scratch / f"{name}_many", MANY_POSTURES)
        here, there, same = in_turn("diagnose", folder, against, 1)
        many.append(here)
        rows.append(row_of(f"{name}, {MANY_POSTURES} postures: diagnose", here, there, same))
    point = cost_of_a_point()
    found = ", ".join(f"{task} {statistics.median(some):.1f}" for task, some in ratios.items())
    header = ["campaign", *STAGES, *KERNELS]
    end = [
        f"Median of the diagnoses {statistics.median(few):.1f} s. Median ratio: {found}.",
        f"With {MANY_POSTURES} postures {statistics.median(many):.1f} s. Kernel: {1e6 * point:.2f} µs",
        "for a system of six coordinates on each line, with 17 rows and 30 receptances.",
        "",
        "Where the time of a diagnosis goes, % under the profiler, by stage and by compiled kernel. What the",
        "kernels take is the limit that no code around them could go below.",
        "",
        f"| {' | '.join(header)} |",
        "|---" + "|---:" * (len(header) - 1) + "|",
        *(f"| {' | '.join(row)} |" for row in parts),
    ]
    write(
        "diagnosis_speed",
        "How long a diagnosis and an identification take",
        "By `python benchmarks/diagnosis_speed.py --against DIR`: processor time [s] of one core after "
        f"imports, in another checkout and in this one; interleaved, medians of {rounds}; whether both "
        "answered the same (effects and places, gap to 1 %; of an identification, the held-out gap to 1 %).",
        ["campaign", "before", "now", "× faster", "same answer"],
        rows,
        "\n".join(end),
    )


def row_of(what: str, here: float, there: float, same: bool) -> list[str]:
    """A row of the table, told while the others are still to come."""
    row = [what, f"{there:.2f}", f"{here:.2f}", f"{there / here:.1f}", "yes" if same else "no"]
    print(row, flush=True)
    return row


def cost_of_a_point() -> float:
    """Processor time [s] of the solutions of one system on one line, in the compiled kernel."""
    import time

    import numpy as np

    from flexmodal.structure.solution import Entries, solved
    from flexmodal.structure.stack import Structures
    from flexmodal.structure.structure import Axis

    n, systems, random = 6, 5, np.random.default_rng(0)
    square = random.normal(size=(systems, n, n))
    stiffness = 1e5 * (square @ np.swapaxes(square, 1, 2) + np.eye(n))
    mass = np.broadcast_to(np.eye(n), stiffness.shape).copy()
    rows = random.normal(size=(systems, 15, n)), random.normal(size=(systems, 2, n))
    names = tuple(f"q{k}" for k in range(n))
    still = Structures(names, mass, 1e-4 * stiffness, stiffness, np.zeros_like(mass), *rows)
    table = np.array([(m, u, v) for m in range(systems) for u in range(15) for v in range(2)])
    axis, times = Axis(np.linspace(1, 100, 160), 10.0), []
    for _ in range(50):
        start = time.process_time()
        solved(still, axis, Entries(table, (15, 2)), compiled=True)
        times.append(time.process_time() - start)
    return statistics.median(times) / (systems * len(axis))


def agrees(one: dict[str, object], other: dict[str, object]) -> bool:
    """Whether two answers say the same."""
    here, there = list(one["says"]), list(other["says"])  # type: ignore[call-overload]
    return bool(here[0] == there[0] and abs(here[1] / there[1] - 1) < SAME)


def in_turn(task: str, folder: Path, against: Path | None, rounds: int) -> tuple[float, float, bool]:
    """Median seconds here and there, NaN without another checkout, and whether the answers are the same."""
    here, there, same = [], [], True
    for _ in range(rounds):
        one = ask(HERE, task, folder)
        here.append(float(str(one["seconds"])))
        if against is not None:
            other = ask(against.resolve(), task, folder)
            there.append(float(str(other["seconds"])))
            same = same and agrees(one, other)
    return statistics.median(here), statistics.median(there) if there else float("nan"), same


def simulated(robot: str, hidden: tuple[str, ...], seed: int, folder: Path, postures: int) -> Path:
    """A campaign on disk, of so many postures and otherwise standard."""
    import flexmodal
    from flexmodal.campaign import write_campaign
    from flexmodal.rig import draw_scenario, simulate
    from flexmodal.rig.robot_folder import write_robot

    believed = flexmodal.load(robot)
    points = min(5, len(believed.points))
    names = tuple(one.partition("@")[0] for one in hidden)
    scenario = draw_scenario(believed, seed, count=len(names), effects=names or None, points=points)
    made = simulate(
        believed, postures=postures, points=points, hide=scenario.hide,
        parameter_error=scenario.parameter_error, seed=seed, time=False,
    )  # fmt: skip
    folder.parent.mkdir(parents=True, exist_ok=True)
    write_campaign(made.campaign, folder)
    write_robot(made.robot, folder, made.plan.postures, made.plan.points)
    return folder


if __name__ == "__main__":
    main()
