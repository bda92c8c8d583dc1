"""What a user hands in, spoilt: read or refused with sentences; a second reader judges what was accepted.

`python benchmarks/fuzz.py [TARGET …] [--count N] [--first N]`, run by `make fuzz`, which ends with the
campaigns of `fuzz_campaign`. Each input follows from the seed and its number, so that a finding repeats. What
is judged:

- the call ends with status 0, 1 or 2 within some seconds, in little memory, without a traceback, and what it
  says is shorter than 2 kB a sentence and steers no terminal;
- what it accepts, a second reader accepts too, with the same numbers: `urdf` by yourdfpy and lxml, `card` and
  `cut` by tomllib, `toolpath` by the csv module, `posture` and `arguments` by rules of their
  own; every number that comes out is finite;
- `--guided SECONDS` lets atheris look for inputs by what they reach, where it is installed.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import random
import re
import resource
import shutil
import signal
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from fuzz_campaign import MEMORY, out_of_time, virtual_memory
from fuzz_judges import JUDGES, SOUND, Misread
from mutations import mutated

SEED = 20_261
SECONDS = 20
"""Of processor time; ten times as long by the clock."""
LONGEST = 2000
"""Characters of one sentence."""
MOST_SENTENCES = 400
CHUNK = 200
TARGETS = ("urdf", "card", "cut", "toolpath", "posture", "arguments")
JOINTS = ("q1", "q2", "q3", "rho", "q9", "", "tool", "ΩÅ")
VALUES = (
    "0", "1", "-1", "0.5", "50deg", "-30deg", "1e999", "nan", "inf", "-inf", "1e-320", "1_0", "0x10",
    "²", "1,2", "",
    " ", "1e", "--", "deg", "180deg", "1e308deg", "9" * 400, "\x1b[31m", "\u202e1", "1:2:3", "٣",
    "true", "None",
)  # fmt: skip
WORDS = (
    "fanuc_s360", "six_link", "six_axis", "nobody", "", ".", "/", "/dev/null", "~", "tool:+z",
    "tool:+q", ":", "tool:",
    "configuration_1", "1:20:1", "1:2", "5", "1,5,20", "1:1e9:1e-9", "-1", "0", "nan", "1e999",
    "0.9,0.6", "x,y",
    "second_link_horizontal", "zero-order", "receptance", "best", "\x1b]0;x\x07", "a" * 3000, "q1=1",
    "q1=1:2:3",
)  # fmt: skip
OPTIONS = {
    "frf": ("--posture", "--frequencies", "--response", "--reference", "--form", "--json"),
    "modes": ("--posture", "--json"),
    "measures": ("--posture", "--direction", "--frequency", "--task", "--json"),
    "tune": ("--posture", "--band", "--direction", "--json"),
    "check": ("--json",),
    "robots": ("--json",),
    "lobes": ("--posture", "--cut", "--method", "--speeds", "--json"),
    "optimise": ("--hold", "--family", "--free", "--frequency", "--starts", "--seed", "--json", "--quiet"),
    "path": ("--toolpath", "--line", "--arc", "--feed", "--points", "--frequency", "--json", "--quiet"),
    "atlas": (
        "--grid",
        "--sample",
        "--range",
        "--frequencies",
        "--direction",
        "--quantity",
        "--workers",
        "--json",
    ),
    "lookup": ("--nearest", "--interpolate", "--best", "--frequency", "--near", "--radius", "--json"),
}
FLAGS = {"--json", "--free", "--quiet"}
SMALL = {"--starts": ("1", "2"), "--speeds": ("5", "20"), "--points": ("2", "4"), "--sample": ("1", "20")}
"""Sound values that keep a run short; others are tried as well."""


def run(words: list[str]) -> tuple[int, str, str]:
    """A command in this process."""
    from flexmodal.cli.main import main

    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            main(words)
        except SystemExit as left:
            return int(left.code or 0), out.getvalue(), err.getvalue()
    raise Misread("a command that did not end by its own status")


def check_told(status: int, out: str, err: str, *, quoted: bool = False) -> None:
    """What a command may say.

    Raises:
        Misread: it says too much, or not what it should.
    """
    if status not in (0, 1, 2):
        raise Misread(f"status {status}")
    if "Traceback" in err or "Warning" in err:
        raise Misread(f"a traceback or a warning: {err[-800:]}")
    if status == 2 and not err.strip():
        raise Misread("a refusal without a word")
    lines = err.splitlines()
    if max(map(len, lines), default=0) > LONGEST or len(lines) > MOST_SENTENCES:
        raise Misread(f"{len(lines)} lines, the longest of {max(map(len, lines))} characters")
    steering = [sign for sign in out + err if ord(sign) < 32 and sign not in "\n\t"]
    if steering and not quoted:
        raise Misread(f"{steering[0]!r} goes to the terminal")
    if status == 0 and re.search(r"\b(NaN|Infinity)\b", out):
        raise Misread("NaN or Infinity in JSON")


def spoilt_file(target: str, rng: random.Random, folder: Path) -> str:
    """A spoilt file read by a command, and what came of it."""
    sound, name, words = SOUND[target]
    content = mutated(sound, rng)
    for other, (text, file, _) in SOUND.items():
        if other in ("urdf", "card", "cut", "toolpath"):
            (folder / file).write_bytes(text)
    (folder / name).write_bytes(content)
    status, out, err = run([word.replace("FOLDER", str(folder)) for word in words])
    check_told(status, out, err)
    if status == 0:
        JUDGES[target](folder / name, json.loads(out) if out.startswith("{") else {})
    elif status == 2 and str(folder) not in err and name not in err:
        raise Misread(f"a refusal that does not name the file: {err[:400]}")
    return ("accepted", "answered no", "refused")[status]


def posture(rng: random.Random) -> str:
    """A posture in words, which has its own grammar."""
    from flexmodal import load

    parts = [
        f"{rng.choice(JOINTS)}{rng.choice('====: ')}{rng.choice(VALUES)}"
        for _ in range(rng.choice((1, 1, 2, 3)))
    ]
    text = rng.choice((",", ",", ",", ";", ",,")).join(parts)
    status, out, err = run(["measures", "fanuc_s360", "--posture", text, "--json"])
    check_told(status, out, err)
    if status == 0:
        JUDGES["posture"](text, json.loads(out), load("fanuc_s360"))
    return ("accepted", "answered no", "refused")[status]


def arguments(rng: random.Random, folder: Path) -> str:
    """Options of a command in any order, with values that fit and that do not."""
    command = rng.choice(list(OPTIONS))
    words = [command]
    if command != "robots":
        words.append(rng.choice(WORDS[:3]) if rng.random() < 0.7 else rng.choice(WORDS))
    for option in rng.sample(OPTIONS[command], rng.randrange(len(OPTIONS[command]) + 1)):
        words.append(option)
        if option not in FLAGS:
            sound = SMALL.get(option)
            words.append(rng.choice(sound) if sound and rng.random() < 0.7 else rng.choice(WORDS + VALUES))
    if command == "atlas":
        words += ["--out", str(folder / "a.zarr")]
    status, out, err = run(words)
    check_told(status, out, err, quoted=command == "lookup")
    if status == 0 and "--json" in words:
        JUDGES["arguments"](words, json.loads(out))
    return ("accepted", "answered no", "refused")[status]


def one(target: str, rng: random.Random, folder: Path) -> str:
    """One input of a target."""
    if target == "posture":
        return posture(rng)
    if target == "arguments":
        return arguments(rng, folder)
    return spoilt_file(target, rng, folder)


def some(target: str, first: int, count: int) -> tuple[Counter[str], list[str], int]:
    """Inputs number `first` and on, in this process under its guards."""
    _warm()
    limit = int(virtual_memory() + 4 * MEMORY)
    resource.setrlimit(resource.RLIMIT_AS, (limit, resource.getrlimit(resource.RLIMIT_AS)[1]))
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    signal.signal(signal.SIGALRM, out_of_time)
    signal.signal(signal.SIGPROF, out_of_time)
    counts: Counter[str] = Counter()
    failures = []
    home = Path(tempfile.mkdtemp(prefix="fuzz-"))
    try:
        for number in range(first, first + count):
            rng = random.Random(f"{SEED} {target} {number}")
            folder = home / "case"
            folder.mkdir()
            signal.setitimer(signal.ITIMER_PROF, SECONDS)
            signal.alarm(10 * SECONDS)
            try:
                counts[f"{target}: {one(target, rng, folder)}"] += 1
            except BaseException:
                failures.append(f"{target} {number}:\n{traceback.format_exc(limit=-5)}")
            signal.setitimer(signal.ITIMER_PROF, 0)
            signal.alarm(0)
            shutil.rmtree(folder, ignore_errors=True)
    finally:
        shutil.rmtree(home, ignore_errors=True)
    return counts, failures, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before


def _warm() -> None:
    """What is imported on first use is imported before memory is looked at."""
    run(["measures", "fanuc_s360", "--posture", "q1=1", "--json"])


def guided(target: str, seconds: int) -> None:
    """Let atheris look for inputs by the code they reach; ends with 77 or more where one fails."""
    import atheris

    with atheris.instrument_imports(include=["flexmodal"]):
        _warm()
    folder = Path(tempfile.mkdtemp(prefix="fuzz-"))
    sound, name, words = SOUND[target]
    for text, file, _ in SOUND.values():
        (folder / file).write_bytes(text)
    corpus = folder / "corpus"
    corpus.mkdir()
    (corpus / "sound").write_bytes(sound)

    def test(content: bytes) -> None:
        (folder / name).write_bytes(content)
        status, out, err = run([word.replace("FOLDER", str(folder)) for word in words])
        check_told(status, out, err)
        if status == 0:
            JUDGES[target](folder / name, json.loads(out) if out.startswith("{") else {})

    atheris.Setup(
        [sys.argv[0], f"-max_total_time={seconds}", "-timeout=20", "-max_len=20000", str(corpus)], test
    )
    atheris.Fuzz()


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("targets", nargs="*", help=f"of {', '.join(TARGETS)}; all if none")
    parser.add_argument("--count", type=int, default=20_000, help="of each target")
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--guided", type=int, metavar="SECONDS", help="by atheris, one target")
    options = parser.parse_args()
    chosen = options.targets or list(TARGETS)
    if unknown := set(chosen) - set(TARGETS):
        parser.error(f"no such target: {', '.join(sorted(unknown))}")
    if options.guided:
        guided(chosen[0], options.guided)
        return 0
    started, total, failures, grown = time.perf_counter(), Counter[str](), [], 0
    ends = options.first + options.count
    jobs = [(target, first) for first in range(options.first, ends, CHUNK) for target in chosen]
    asked: list[tuple[str, int, int]] = [(target, first, min(CHUNK, ends - first)) for target, first in jobs]
    call: Callable[..., tuple[Counter[str], list[str], int]] = some
    with ProcessPoolExecutor(options.processes) as pool:
        for done, (found, failed, more) in enumerate(pool.map(call, *zip(*asked, strict=True)), start=1):
            total, grown = total + found, max(grown, more)
            failures += failed
            print("\n".join(failed), end="", flush=True)
            if done % 20 == 0 or failed:
                print(f"{sum(total.values())} inputs, {len(failures)} failures", flush=True)
    for name, count in sorted(total.items()):
        print(f"{name}: {count}")
    seconds = time.perf_counter() - started
    print(
        f"{sum(total.values())} inputs in {seconds:.0f} s, at most {grown / 1e3:.0f} MB "
        f"more, {len(failures)} failures"
    )
    return int(bool(failures))


if __name__ == "__main__":
    sys.exit(main())
