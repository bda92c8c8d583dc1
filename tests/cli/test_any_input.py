"""Anything handed in is read or refused with sentences, and second readers judge what is accepted."""

import json
import random
import signal
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
FEW = {"max_examples": 40, "deadline": None, "derandomize": True, "database": None}
NUMBERS = st.one_of(
    st.floats(width=64).map(repr),
    st.integers().map(str),
    st.sampled_from(["50deg", "-0", "1e999", "1_0", "٣", ""]),
)
JOINTS = st.sampled_from(["q1", "q2", "q3", "rho", "q9", "", "Q1"])


@pytest.fixture(scope="module")
def fuzz():  # type: ignore[no-untyped-def]
    sys.path.insert(0, str(BENCHMARKS))
    try:
        import fuzz
        import fuzz_campaign
        import fuzz_judges
        import fuzz_targets
    finally:
        sys.path.remove(str(BENCHMARKS))
    fuzz.targets, fuzz.judges, fuzz.campaigns = fuzz_targets, fuzz_judges, fuzz_campaign
    return fuzz


@pytest.mark.parametrize("target", ["urdf", "card", "cut", "toolpath", "posture", "campaign"])
def test_spoilt_inputs(fuzz, target, tmp_path) -> None:  # type: ignore[no-untyped-def]
    ends = set()
    for number in range(1, 60):  # without those that go through a whole command
        if number % 20:
            (place := tmp_path / str(number)).mkdir()
            ends.add(fuzz.one(target, fuzz.SEED, number, place))
    assert {"accepted", "refused"} <= ends


@settings(**FEW)
@given(st.lists(st.tuples(JOINTS, NUMBERS), min_size=1, max_size=4))
def test_postures_in_words(fuzz, parts) -> None:  # type: ignore[no-untyped-def]
    assert fuzz.targets.read_posture(",".join("=".join(part) for part in parts)) in fuzz.targets.ENDS


@settings(**FEW)
@given(
    key=st.sampled_from(
        ["stiffness = 559000.0", "damping = 94.03", "xyz = [0.78, 0.0, 0.0]", "q1 = 0.87266"]
    ),
    value=st.one_of(st.floats(width=64), st.integers(-(2**70), 2**70), st.booleans(), st.text(max_size=5)),
)
def test_values_of_a_card(fuzz, key, value) -> None:  # type: ignore[no-untyped-def]
    name = key.split(" ")[0]
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        for text, file, _ in fuzz.judges.SOUND.values():
            (folder / file).write_bytes(text)
        card = (folder / "robot.toml").read_text(encoding="utf-8")
        word = {float("inf"): "inf", float("-inf"): "-inf"}.get(value, json.dumps(value)).replace(
            "NaN", "nan"
        )
        (folder / "robot.toml").write_text(card.replace(key, f"{name} = {word}", 1), encoding="utf-8")
        assert fuzz.targets.read_file("card", folder) in fuzz.targets.ENDS


@pytest.mark.parametrize(
    ("target", "spoil"),
    [
        ("card", lambda told: told | {"static_receptance": told["static_receptance"] * (1 + 1e-6)}),
        ("card", lambda told: told | {"tool": [told["tool"][0], 0.0, told["tool"][2] + 1e-6]}),
        ("urdf", lambda told: told | {"tool": [float("nan"), 0.0, 0.0]}),
        ("urdf", lambda told: told | {"stiffness": float("inf")}),
    ],
)
def test_a_wrong_answer_is_seen(fuzz, target, spoil, tmp_path) -> None:  # type: ignore[no-untyped-def]
    for text, file, _ in fuzz.judges.SOUND.values():
        (tmp_path / file).write_bytes(text)
    path = tmp_path / fuzz.judges.SOUND[target][1]
    told = fuzz.targets.READERS[target](path)
    fuzz.judges.JUDGES[target](path, told)
    with pytest.raises(fuzz.judges.Misread):
        fuzz.judges.JUDGES[target](path, spoil(told))


def test_an_frf_that_is_not_in_the_file_is_seen(fuzz, tmp_path) -> None:  # type: ignore[no-untyped-def]
    from flexmodal.campaign import read_campaign

    for name in fuzz.campaigns.names():
        if not name.startswith("frf.uff ") or "itself" in name:
            continue
        content, file = fuzz.campaigns.sound()[name]
        (place := tmp_path / name.replace(" ", "_")).mkdir()
        fuzz.campaigns.read_one(name, content, place)
        found = read_campaign(place)
        fuzz.campaigns.judge(name, file, content, found)
        changed = found.frfs.value.copy()
        changed[0, 3] *= 1 + 1e-6
        with pytest.raises(fuzz.judges.Misread):
            fuzz.campaigns.judge(name, file, content, replace(found, frfs=replace(found.frfs, value=changed)))


def test_what_may_not_be_said_is_seen(fuzz) -> None:  # type: ignore[no-untyped-def]
    check = fuzz.targets.check_told
    check(2, "", "flexmodal: a sentence\n")
    for told in (
        (3, "", "x"), (2, "", ""), (2, "", "x" * 2001), (2, "", "Traceback (most"), (0, "\x1b[2J", ""),
        (0, '{"a": NaN}', ""), (2, "", "x\n" * 401),
    ):  # fmt: skip
        with pytest.raises(fuzz.judges.Misread):
            check(*told)


def test_a_process_that_dies_and_one_that_hangs_are_failures(fuzz, monkeypatch, tmp_path) -> None:  # type: ignore[no-untyped-def]
    import os
    import time

    monkeypatch.setattr(fuzz, "SECONDS", 0.2)

    def dies(target, seed, number, folder):  # type: ignore[no-untyped-def]
        if number == 3:
            os._exit(7)
        while number == 5 and target == "urdf":
            time.sleep(0)
        return "accepted"

    monkeypatch.setattr(fuzz, "one", dies)
    found = list(fuzz.carry_out(iter([("card", 0, 5), ("urdf", 4, 3)]), 2))
    by_target = {one["target"]: one for one in found}
    assert "card 3: the process ended with 7" in by_target["card"]["failures"]
    (hung,) = by_target["urdf"]["failures"]
    assert hung.startswith("urdf 5:")
    assert "still at it" in hung
    assert by_target["urdf"]["ends"] == {"accepted": 2}


def test_both_limits_of_time_together_are_one(fuzz) -> None:  # type: ignore[no-untyped-def]
    """On a busy machine that of the clock is met while the other one is told."""
    fuzz._limit(100)
    try:
        with pytest.raises(TimeoutError, match="still at it"):
            fuzz._out_of_time()
        fuzz._out_of_time()
        assert signal.getitimer(signal.ITIMER_PROF)[0] == signal.getitimer(signal.ITIMER_REAL)[0] == 0
    finally:
        fuzz._limit(0)


def test_numbers_repeat(fuzz) -> None:  # type: ignore[no-untyped-def]
    from mutations import mutated

    sound = fuzz.judges.SOUND["card"][0]
    assert mutated(sound, random.Random("a 1")) == mutated(sound, random.Random("a 1"))
    assert len({mutated(sound, random.Random(f"a {n}")) for n in range(50)}) > 45
