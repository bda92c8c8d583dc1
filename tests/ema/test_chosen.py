"""A file of chosen modes: repeated exactly, refused with everything that is wrong in it, tied to its data."""

from __future__ import annotations

import contextlib
import io
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from flexmodal.campaign import Campaign, read_campaign
from flexmodal.cli.main import main
from flexmodal.ema import Measured, fit_choice, read_choice, records_of
from flexmodal.ema.chosen import fingerprint_of, fit_poles
from flexmodal.ema.of_campaign import known_variance
from flexmodal.ema.records import by_posture
from flexmodal.errors import InvalidRequest

from .truth import real_modes

BEAM = Path(__file__).parents[1] / "data" / "real" / "free_free_beam"
BAND = (10.0, 990.0)
POLES = ((51.52, 0.0005), (142.18, 0.00035), (278.67, 0.000186), (460.4, 0.000192))


@pytest.fixture(scope="module")
def beam() -> Campaign:
    return read_campaign(BEAM)


def fingerprint(campaign: Campaign) -> tuple[float, ...]:
    records = records_of(campaign)
    ((_, _, whole),) = by_posture(records, "average", known_variance(records))
    return fingerprint_of(whole.within(*BAND))


def text_of(mark: tuple[float, ...]) -> str:
    modes = "".join(f"\n[[posture.mode]]\nfrequency = {f!r}\ndamping_ratio = {z!r}\n" for f, z in POLES)
    head = f'format = 1\ntitle = "beam"\nresiduals = "complex"\nband = {list(BAND)}\n'
    return f"{head}\n[[posture]]\nid = 1\nfingerprint = {list(mark)}\n{modes}"


def ran(*arguments: object) -> tuple[int, str, str]:
    out, said = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(said), pytest.raises(SystemExit) as end:
        main([str(one) for one in arguments])
    return int(end.value.code or 0), out.getvalue(), said.getvalue()


def test_the_command_repeats_the_choice(beam: Campaign, tmp_path: Path) -> None:
    path = tmp_path / "choice.toml"
    path.write_text(text_of(fingerprint(beam)), encoding="utf-8")
    status, out, _ = ran("fit", BEAM, "--choice", path, "--json")
    assert status == 0
    rows = json.loads(out)["modes"]
    assert {(row["frequency"], row["damping_ratio"]) for row in rows} == set(POLES)
    assert len(rows) == 3 * len(POLES)
    assert ran("fit", BEAM, "--choice", path, "--json")[1] == out
    (one,) = fit_choice(beam, read_choice(path))
    there = np.array([complex(*row["residue"]) for row in rows]).reshape(len(POLES), 3)
    np.testing.assert_array_equal(one.modes.residue.T, there)
    assert all(row["uncertainty"]["frequency_95"] == [row["frequency"]] * 2 for row in rows)


def test_residues_are_those_of_the_truth_and_of_the_other_route() -> None:
    """Exact data give the true residues; the normal equations of least squares agree with the
    factorisation."""
    truth = real_modes([30.0, 51.0, 58.0], [0.01, 0.02, 0.03], np.array([[1.0, 0.5, -0.7], [0.4, 1.0, 0.8]]))
    axis = np.linspace(5.0, 100.0, 300)
    data = Measured(axis, truth.frf(axis, "inertance"), "inertance")
    poles = list(zip(truth.frequency.tolist(), truth.damping.tolist(), strict=True))
    for residuals in ("none", "real", "complex"):
        found = fit_poles(data, poles, residuals)  # type: ignore[arg-type]
        np.testing.assert_allclose(found.residue, truth.residue, rtol=1e-9)
        assert found.misfit < 1e-10


def test_every_fault_is_told_at_once(tmp_path: Path) -> None:
    path = tmp_path / "choice.toml"
    bad = text_of((1.0,) * 7).replace("ratio = 0.0005", "ratio = 1.5").replace("51.52", "-3.0")
    path.write_text(bad.replace("format = 1", "format = 2\ncolour = 3"), encoding="utf-8")
    status, out, said = ran("fit", BEAM, "--choice", path, "--json")
    assert (status, out) == (2, "")
    for word in ("format", "colour", "posture[0].mode[0].frequency", "posture[0].mode[0].damping_ratio"):
        assert word in said
    assert "Traceback" not in said
    assert str(path) in said


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("frequency = 51.52", "frequency = 5.0"), ("mode[0].frequency", "inside the band")),
        (
            ("frequency = 142.18\ndamping_ratio = 0.00035", "frequency = 51.52\ndamping_ratio = 0.0005"),
            ("each mode once",),
        ),
        (("band = [10.0, 990.0]", "band = [990.0, 10.0]"), ("band", "low below high")),
        (("[[posture]]", "[[posture]"), ("not TOML",)),
        (('residuals = "complex"', 'residuals = "some"'), ("residuals", "none, real or complex")),
        (("id = 1", "id = 7"), ("posture 7", "of the data: 1")),
    ],
)
def test_what_is_wrong_is_named(
    beam: Campaign, tmp_path: Path, change: tuple[str, str], words: tuple[str, ...]
) -> None:
    path = tmp_path / "choice.toml"
    text = text_of(fingerprint(beam))
    assert change[0] in text
    path.write_text(text.replace(*change), encoding="utf-8")
    status, out, said = ran("fit", BEAM, "--choice", path)
    assert (status, out) == (2, "")
    for word in words:
        assert word in said


def test_a_choice_for_other_data_is_refused(beam: Campaign, tmp_path: Path) -> None:
    path = tmp_path / "choice.toml"
    path.write_text(text_of(fingerprint(beam)), encoding="utf-8")
    assert beam.frfs is not None
    for factor, refused in ((1 + 1e-13, False), (1 + 1e-6, True), (-1.0, True)):
        value = beam.frfs.value.copy()
        value[1] *= factor
        other = replace(beam, frfs=replace(beam.frfs, value=value))
        if refused:
            with pytest.raises(InvalidRequest, match=r"posture\[0\].fingerprint.*other data"):
                fit_choice(other, read_choice(path))
        else:
            assert len(fit_choice(other, read_choice(path))) == 1
    plate = BEAM.parent / "mssp_plate_sweep"
    status, _, said = ran("fit", plate, "--choice", path)
    assert status == 2
    assert "fingerprint" in said


def test_options_that_the_file_decides_are_refused_beside_it(beam: Campaign, tmp_path: Path) -> None:
    path = tmp_path / "choice.toml"
    path.write_text(text_of(fingerprint(beam)), encoding="utf-8")
    status, _, said = ran("fit", BEAM, "--choice", path, "--at", "51", "--per", "frf")
    assert status == 2
    assert "--at" in said
    assert "--per" in said
    status, _, said = ran("fit", BEAM, "--choice", tmp_path / "none.toml")
    assert status == 2
    assert "no such file" in said
