"""Read many mutated campaigns: each is read, or refused with sentences; nothing else may happen.

Run by `make fuzz`. Every file follows from the seed and its number, so a finding repeats:
`python benchmarks/fuzz_campaign.py --first NUMBER --count 1`. How many are done is printed as it goes; a run
that was broken off goes on with `--first`.
"""

from __future__ import annotations

import argparse
import random
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

import numpy as np
from mutations import mutated

from flexmodal.campaign import (
    Blow,
    Campaign,
    CampaignPoint,
    CampaignPosture,
    FrfRecords,
    ModeTable,
    Trial,
    import_table,
    read_campaign,
    write_campaign,
)
from flexmodal.errors import FlexmodalError, InvalidInput

SEED = 20_260
SECONDS = 10
"""A file of some kilobytes is read in milliseconds; one that takes as long hangs."""
MEMORY = 600e6
"""What reading may take beyond what the interpreter has at the start [bytes]."""
EXPORT = "export.uff"
"""A universal file without its campaign.toml."""
CHUNK = 500
REPORT = 20
"""Chunks between two lines of progress."""
MAP = """\
format = 1
campaign = "campaign.toml"
table = "table.csv"
abscissa = "f"
[[frf]]
posture = 1
trial = 1
response = [1, 3]
reference = [2, -3]
form = "inertance"
re = "re"
im = "im"
coherence = "g"
"""


def sound_campaign() -> Campaign:
    """Small, with every kind of data."""
    rng = np.random.default_rng(0)
    lines, samples = 9, 16
    frfs = FrfRecords(
        frequency=0.5 * np.arange(lines),
        value=rng.normal(size=(2, lines)) + 1j * rng.normal(size=(2, lines)),
        coherence=rng.uniform(0.5, 1, size=(2, lines)),
        posture=np.array([1, 1]),
        trial=np.array([1, 2]),
        response=np.array([[1, 3], [1, 3]]),
        reference=np.array([[2, -3], [2, -3]]),
        form="inertance",
    )
    axis = np.arange(samples) / 64
    blow = Blow(
        1, 1, 1, (2, -3), axis, rng.normal(size=samples) + 50, ((1, 3),), rng.normal(size=(1, samples))
    )
    whole, real = np.array([1, 1]), np.array([7.4, np.nan])
    modes = ModeTable(whole, whole, whole + 1, whole, real, real / 100, real * (1 + 1j), ("", "a:missing"))
    return Campaign(
        title="fuzz",
        robot="fanuc_s360",
        band=(0.5, 4.0),
        postures=(CampaignPosture(1, "bent", {"q1": 0.5}),),
        points=(CampaignPoint(1, "tip", "hand", (0.1, 0, 0)), CampaignPoint(2, "wrist", "arm", (0, 0, 0))),
        trials=(Trial(1, 100.0, 2, "soft", record_length=1.0), Trial(2, 90.0, 2, "hard", repeat_of=1)),
        frfs=frfs,
        blows=(blow,),
        modes=modes,
    )


def sources(folder: Path) -> dict[str, tuple[bytes, str]]:
    """What is mutated: name to sound content and the file it becomes."""
    found = {}
    for binary in (False, True):
        made = write_campaign(sound_campaign(), folder / f"sound_{binary}", binary=binary)
        for name in ("frf.uff", "time.uff"):
            found[f"{name} {'binary' if binary else 'ASCII'}"] = ((made / name).read_bytes(), name)
            if binary is (name == "frf.uff"):
                found[f"{name} by itself"] = ((made / name).read_bytes(), EXPORT)
    found["campaign.toml"] = ((made / "campaign.toml").read_bytes(), "campaign.toml")
    found["modes.csv"] = ((made / "modes.csv").read_bytes(), "modes.csv")
    table = "f,re,im,g\n" + "".join(f"{0.5 * n},{n},{-n},0.9\n" for n in range(9))
    found["table.csv"] = (table.encode(), "table.csv")
    found["map.toml"] = (MAP.encode(), "map.toml")
    return found


def read_one(name: str, content: bytes, sound: dict[str, tuple[bytes, str]], folder: Path) -> str:
    """Lay the files out, read them, and say what came of it."""
    file = sound[name][1]
    toml = sound["campaign.toml"][0]
    (folder / "campaign.toml").write_bytes(toml)
    reader: Callable[[Path], Campaign] = read_campaign
    if file in ("table.csv", "map.toml"):
        (folder / "map.toml").write_bytes(sound["map.toml"][0])
        (folder / "table.csv").write_bytes(sound["table.csv"][0])
        reader = import_table
    elif file == "campaign.toml":
        (folder / "modes.csv").write_bytes(sound["modes.csv"][0])
    (folder / file).write_bytes(content)
    path = folder / "map.toml" if reader is import_table else folder
    try:
        campaign = reader(folder / EXPORT if file == EXPORT else path)
    except InvalidInput as error:
        if not error.faults or not all(fault.found and fault.allowed for fault in error.faults):
            raise AssertionError(f"a refusal without its evidence: {error}") from error
        return "refused"
    except FlexmodalError:
        return "refused"
    finally:
        for entry in folder.iterdir():
            entry.unlink()
    frfs = campaign.frfs
    if frfs is not None and not np.all(np.isfinite(frfs.value)):
        raise AssertionError("values that are not finite came through")
    return "read"


def run(first: int, count: int) -> tuple[Counter[str], list[str]]:
    """Files number `first` and on, in this process under its guards."""
    spent = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    limit = int(virtual_memory() + MEMORY)
    resource.setrlimit(resource.RLIMIT_AS, (limit, resource.getrlimit(resource.RLIMIT_AS)[1]))
    signal.signal(signal.SIGALRM, out_of_time)
    counts: Counter[str] = Counter()
    failures = []
    scratch = Path(tempfile.mkdtemp(prefix="fuzz-"))
    try:
        sound = sources(scratch)
        names, place = sorted(sound), scratch / "case"
        place.mkdir()
        for number in range(first, first + count):
            rng = random.Random(SEED * 1_000_003 + number)
            name = names[number % len(names)]
            content = mutated(sound[name][0], rng)
            signal.alarm(SECONDS)
            try:
                counts[f"{name}: {read_one(name, content, sound, place)}"] += 1
            except BaseException:
                failures.append(f"file {number} ({name}):\n{traceback.format_exc(limit=-6)}")
            signal.alarm(0)
    finally:
        shutil.rmtree(scratch, ignore_errors=True)
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 - spent
    counts["megabytes grown at most"] = int(grown / 1e6)
    return counts, failures


def virtual_memory() -> int:
    """What this process has mapped now [bytes]."""
    return int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()


def out_of_time(*_: object) -> None:
    raise TimeoutError(f"still reading after {SECONDS} s")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=100_000)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--processes", type=int, default=2)
    options = parser.parse_args()
    started = time.perf_counter()
    total: Counter[str] = Counter()
    failures: list[str] = []
    grown = 0
    firsts = range(options.first, options.first + options.count, CHUNK)
    counts = [min(CHUNK, options.first + options.count - first) for first in firsts]
    with ProcessPoolExecutor(options.processes) as pool:
        for done, (found, failed) in enumerate(pool.map(run, firsts, counts), start=1):
            grown = max(grown, found.pop("megabytes grown at most"))
            total += found
            failures += failed
            if done % REPORT == 0:
                following = options.first + min(done * CHUNK, options.count)
                print(f"files {options.first} to {following - 1}: {len(failures)} failures", flush=True)
    for name, count in sorted(total.items()):
        print(f"{name}: {count}")
    seconds = time.perf_counter() - started
    print(f"{options.count} files in {seconds:.0f} s, at most {grown} MB more, {len(failures)} failures")
    for failure in failures[:20]:
        print(failure)
    return int(bool(failures))


if __name__ == "__main__":
    sys.exit(main())
