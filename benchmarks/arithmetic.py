"""The same verdict whatever the arithmetic: campaigns diagnosed under several kinds of it, side by side.

    python benchmarks/arithmetic.py [--seed N] [--questions N] [--folder DIR] [--workers N]

Every campaign is diagnosed by the command line in a process of its own: with OpenBLAS's kernels for other
processors, with NumPy's vector instructions off, without numba, and with measured FRFs changed by one part in
10⁹. Names, places, explained or not and exit status have to be the same, gaps the same within 1 %, parameters
within 1 % or a tenth of their standard error, confidences within 0.01. Ends with status 1 where they are not.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

import numpy as np
from exam_plan import plan
from exam_question import Question, pose

from flexmodal.campaign import Campaign, read_campaign, write_campaign

ROOT = Path(__file__).resolve().parents[1]
SEED = 20261205
WITHIN = 0.01
OF_ERROR = 0.1
PERTURBED = 1e-9
COMMAND = "import sys{off}; from flexmodal.cli.main import main; main()"
OFF = "; sys.modules['numba'] = None"


@dataclass(frozen=True)
class Arithmetic:
    """One way to compute."""

    name: str
    environment: dict[str, str] = field(default_factory=dict)
    numba: bool = True
    perturbed: bool = False


def kinds() -> list[Arithmetic]:
    """The first is what the others are compared with; kernels that this processor cannot run are left out."""
    from numpy._core._multiarray_umath import __cpu_features__ as features

    cores = {"Haswell": "AVX2", "Nehalem": "SSE42", "SkylakeX": "AVX512F"}
    blas = [
        Arithmetic(name, {"OPENBLAS_CORETYPE": name}) for name, needs in cores.items() if features.get(needs)
    ]
    return [
        *blas,
        Arithmetic("NumPy without vectors", {"NPY_DISABLE_CPU_FEATURES": "X86_V3 X86_V4"}),
        Arithmetic("without numba", numba=False),
        Arithmetic("FRFs changed by 1e-9", perturbed=True),
    ]


@dataclass(frozen=True)
class Case:
    """One campaign."""

    name: str
    plain: Path
    changed: Path
    """The same with its FRFs changed a little."""
    options: tuple[str, ...] = ()


def answered(case: Case, folder: Path, kind: Arithmetic) -> dict[str, object]:
    """A campaign's answer under one kind of arithmetic."""
    campaign = case.changed if kind.perturbed else case.plain
    return answer(campaign, folder / f"{case.plain.name}-{kind.name.replace(' ', '-')}", kind, case.options)


def answer(campaign: Path, out: Path, kind: Arithmetic, more: Sequence[str]) -> dict[str, object]:
    """One diagnosis, as its exit status and its JSON."""
    command = [sys.executable, "-c", COMMAND.format(off="" if kind.numba else OFF), "diagnose"]
    command += [str(campaign), "--out", str(out), "--force", "--quiet", *more]
    env = {**os.environ, "OPENBLAS_NUM_THREADS": "1", **kind.environment}
    done = subprocess.run(command, env=env, cwd=ROOT, capture_output=True, text=True, check=False)
    file = out / "diagnosis.json"
    if not file.exists():
        raise RuntimeError(f"{campaign.name}, {kind.name}: {done.stderr[-2000:]}")
    return {"status": done.returncode, **json.loads(file.read_text(encoding="utf-8"))}


def differences(one: dict, other: dict) -> list[str]:
    """What two answers disagree about."""
    found = [
        f"{what}: {a} / {b}"
        for what, a, b in (
            ("status", one["status"], other["status"]),
            ("effects", one["verdict"]["effects"], other["verdict"]["effects"]),
            ("explained", one["verdict"]["explained"], other["verdict"]["explained"]),
            ("steps", *([(s["effect"], s["where"]) for s in some["steps"]] for some in (one, other))),
        )
        if a != b
    ]
    for name, value in one["gap"].items():
        found += _apart(f"gap {name}", value, other["gap"][name], 0.0)
    for a, b in zip(one["steps"], other["steps"], strict=False):
        found += _apart(f"{a['effect']} confidence", a["confidence"], b["confidence"], 0.0, WITHIN)
        for name in a["parameters"].keys() & b["parameters"].keys():
            error = a.get("uncertainty", {}).get(name) or 0.0
            found += _apart(f"{a['effect']} {name}", a["parameters"][name], b["parameters"][name], error)
    return found


def _apart(what: str, a: float | None, b: float | None, error: float, least: float = 0.0) -> list[str]:
    if a is None or b is None:
        return [] if a == b else [f"{what}: {a} / {b}"]
    far = abs(a - b) > max(WITHIN * abs(a), OF_ERROR * error, least)
    return [f"{what}: {a:.6g} / {b:.6g}"] if far else []


def perturbed(campaign: Campaign, seed: int) -> Campaign:
    """The same with every measured FRF value off by about one part in 10⁹."""
    assert campaign.frfs is not None
    noise = np.random.default_rng(seed).normal(size=campaign.frfs.value.shape)
    return replace(campaign, frfs=replace(campaign.frfs, value=campaign.frfs.value * (1 + PERTURBED * noise)))


def prepared(question: Question, folder: Path, seed: int) -> tuple[Path, Path]:
    """Folders of a campaign and of the same changed a little."""
    plain, changed = folder / question.name, folder / f"{question.name}-changed"
    if not changed.exists():
        shutil.rmtree(plain, ignore_errors=True)
        pose(question, plain, folder / f"{question.name}.toml")
        write_campaign(perturbed(read_campaign(plain), seed), changed)
        shutil.copytree(plain / "robot", changed / "robot")
    return plain, changed


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--questions", type=int, default=8)
    parser.add_argument("--folder", type=Path, default=Path("exam/arithmetic"))
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    given = parser.parse_args()
    folder = given.folder.resolve()
    (folder / "answers").mkdir(parents=True, exist_ok=True)
    cases = []
    for question in plan(given.seed)[: given.questions]:
        plain, changed = prepared(question, folder, given.seed)
        cases.append(Case(f"{question.robot} {'+'.join(question.effects) or 'nothing'}", plain, changed))
    thesis = ROOT / "robots" / "fanuc_s360" / "campaigns" / "thesis"
    told = ("--robot", "fanuc_s360_rigid_link", "--effects", "link_flexibility@link_2")
    cases.append(Case("the thesis's modes, told link 2", thesis, thesis, told))
    ways = kinds()
    print("compared with", ways[0].name, flush=True)
    wrong = 0
    with ThreadPoolExecutor(given.workers) as pool:
        for case in cases:
            found = list(pool.map(partial(answered, case, folder / "answers"), ways))
            apart = [differences(found[0], one) for one in found[1:]]
            wrong += sum(map(bool, apart))
            print(f"{case.name}: {found[0]['verdict']['effects']}", flush=True)
            for kind, some in zip(ways[1:], apart, strict=True):
                print(f"  {kind.name}: {'; '.join(some) if some else 'the same'}", flush=True)
    print(f"{len(cases)} campaigns under {len(ways)} kinds of arithmetic: {wrong} differ")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
