"""The sealed exam of the diagnosis: simulated campaigns with effects hidden in them.

    python benchmarks/exam.py [--engine rig|mujoco] [--forms own|NAME] [--seed N] [--folder DIR]
        [--postures N] [--workers N] [--most N] [--scheduler ADDRESS]

Goes on where it was stopped; on this machine's cores, or on the workers of a Dask scheduler that see the same
folders. The candidate is a process of its own that is given the campaign's folder; what
is hidden lies in another. Tuned on other seeds; the published exams are those of `PUBLISHED`, which sets of
forms there are says `flexmodal.rig.FORM_SETS`.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tomllib
from dataclasses import replace
from pathlib import Path

from exam_plan import plan
from exam_question import ENGINES, POSTURES, WHICH, Question
from exam_report import report
from spreading import add_options, pieces

PUBLISHED = {
    "rig": 20261128, "mujoco": 20270102, "looked": 20261128, "sealed": 20270142, "unseen": 20270201,
    "later": 20270301, "blind": 20270402, "further": 20270501, "third": 20270601,
    "fourth": 20270701, "fifth": 20270801, "sixth": 20270901, "seventh": 20271001,
}  # fmt: skip
"""Seeds of the tables in docs/tables."""


def ask(question: Question, folder: Path, engine: str, forms: str, within: float | None) -> dict[str, object]:
    """Pose one question, have it answered, and put the truth beside the answer."""
    campaign, truth = folder / "campaigns" / question.name, folder / "truth" / f"{question.name}.toml"
    answer = folder / "answers" / f"{question.name}.json"
    if not answer.exists():
        if not campaign.exists() or not truth.exists():
            shutil.rmtree(campaign, ignore_errors=True)
            truth.unlink(missing_ok=True)
            poser = Path(__file__).parent / "exam_plan.py"
            seed = folder.name.split("-")[-1]
            given = (engine, forms, seed, question.name, str(campaign), str(truth))
            call([sys.executable, str(poser), *given, str(question.postures)])
        candidate = Path(__file__).parent / "exam_candidate.py"
        limit = [] if within is None else [str(within)]
        call([sys.executable, str(candidate), str(campaign), str(answer), *limit])
        shutil.rmtree(campaign)
    found = json.loads(answer.read_text(encoding="utf-8"))
    hidden = tomllib.loads(truth.read_text(encoding="utf-8"))
    return {"question": question, "answer": found, "truth": hidden}


def call(command: list[str]) -> None:
    """Run a process on one thread; its complaint is ours.

    Campaigns are asked side by side, so that each diagnosis works alone unless the environment says other.
    """
    env = {"FLEXMODAL_WORKERS": "1", **os.environ, "OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run(command, env=env, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"{' '.join(command[-3:])}: {done.stderr[-2000:]}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--engine", choices=ENGINES, default="rig", help="who integrates the motion")
    parser.add_argument("--forms", choices=WHICH, default="own", help="physical forms of what is hidden")
    parser.add_argument("--seed", type=int, default=None, help="by default that of the table")
    parser.add_argument("--folder", type=Path, default=Path("exam"))
    parser.add_argument("--within", type=float, default=None, help="seconds for each; by default no limit")
    parser.add_argument("--postures", type=int, default=POSTURES, help="of each campaign")
    parser.add_argument("--most", type=int, default=None, help="only so many questions")
    add_options(parser)
    given = parser.parse_args()
    if given.engine != "rig" and given.forms != "own":
        parser.error("--forms: MuJoCo has its own means; only the rig has other forms")
    kind = given.engine if given.forms == "own" else f"{given.engine}-{given.forms}"
    name = given.engine if given.forms == "own" else given.forms
    seed = PUBLISHED[name] if given.seed is None else given.seed
    usual = given.postures == POSTURES
    folder = given.folder / (f"{kind}-{seed}" if usual else f"{kind}-{given.postures}_postures-{seed}")
    for part in ("campaigns", "truth", "answers"):
        (folder / part).mkdir(parents=True, exist_ok=True)
    every = [replace(one, postures=given.postures) for one in plan(seed, given.engine, given.forms)]
    questions = {question.name: question for question in every[: given.most]}
    if given.one:
        ask(questions[given.one], folder, given.engine, given.forms, given.within)
        return
    options = ["--engine", given.engine, "--forms", given.forms, "--seed", str(seed)]
    options += ["--postures", str(given.postures), "--folder", os.path.abspath(given.folder)]
    options += [] if given.within is None else ["--within", str(given.within)]
    found = {}
    asked = pieces("exam.py", questions, options, scheduler=given.scheduler, workers=given.workers)
    for number, (one, told) in enumerate(asked, start=1):
        if told is not None:  # the answer lies in the folder
            found[one] = ask(questions[one], folder, given.engine, given.forms, given.within)
            print(f"{number}/{len(questions)}", line(found[one]), flush=True)
    done = [found[one] for one in questions if one in found]
    report(done, len(every), seed, name, given.within, published=usual and seed == PUBLISHED[name])


def line(result: dict[str, object]) -> str:
    """One question in a line."""
    question, answer, truth = result["question"], result["answer"], result["truth"]
    hidden = [
        (e["effect"], e["form"], e["where"], round(e.get("times_noise_floor", 0), 1)) for e in truth["effect"]
    ]
    gap = answer["gap"]
    return (
        f"{question.robot} {hidden} -> {answer['effects']} {[round(c, 2) for c in answer['confidence']]} "
        f"gap {gap['before'] / gap['noise_floor']:.2f} -> {gap['after'] / gap['noise_floor']:.2f} × floor, "
        f"{answer['processor_seconds']:.0f} s"
    )


if __name__ == "__main__":
    main()
