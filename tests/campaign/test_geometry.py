"""Nodes, trace lines and modes of universal files: what was put in comes out, in every dialect."""

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from flexmodal.campaign import check_campaign, draft_map, read_campaign, read_geometry, write_campaign
from flexmodal.cli.import_ import import_
from flexmodal.ema import fit
from flexmodal.errors import InvalidCampaign

SAMPLE = Path(__file__).parents[1] / "data" / "dialects" / "geometry.unv"
PLACES = {1: (0.0, 0.0, 0.0), 2: (0.4, 0.0, 0.05), 3: (0.8, 0.0, 0.05)}
SHAPES = {1: (0.1, 0.5, 1.0), 2: (0.3, 0.9, -0.8)}
MASS = 2.0


def dataset(kind, *lines):
    return "".join(f"{line}\n" for line in ("    -1", f"{kind:6d}", *lines, "    -1"))


def written(folder, *parts):
    file = folder / "export.uff"
    file.write_text("".join(parts))
    return file


def as_it_is(text):
    return text


def carriage_returns(text):
    return text.replace("\n", "\r\n")


def d_exponents(text):
    """In the datasets of nodes; 58 knows E alone."""
    head, tail = text.split("    58", 1)
    return (
        head.replace("E+", "D+").replace("E-", "d-").replace("e+", "D+").replace("e-", "D-") + "    58" + tail
    )


def narrow(text):
    """Nodes parted by single blanks, as some exporters do."""
    lines = text.split("\n")
    return "\n".join(" ".join(line.split()) if 2 <= k <= 4 else line for k, line in enumerate(lines))


def newer(text):
    """Dataset 2411, of two lines a node, for dataset 15."""
    rows = [line.split() for line in text.split("\n")[2:5]]
    lines = [part for row in rows for part in ("".join(f"{one:>10}" for one in row[:4]), "  ".join(row[4:]))]
    return dataset(2411, *lines) + "\n".join(text.split("\n")[6:])


@pytest.mark.parametrize("change", [as_it_is, carriage_returns, d_exponents, narrow, newer])
def test_nodes_lines_modes_and_frfs(tmp_path, change):
    file = tmp_path / "export.unv"
    file.write_bytes(change(SAMPLE.read_text()).encode())
    geometry = read_geometry(file)
    assert geometry.lines == ((1, 2, 3),)
    assert set(geometry.nodes) == set(PLACES)
    for node, place in PLACES.items():
        assert geometry.nodes[node] == pytest.approx(place)
    found = read_campaign(file)
    assert {point.id: point.xyz for point in found.points} == dict(geometry.nodes)
    assert len(found.frfs) == 2
    assert found.trace_lines == ((1, 2, 3),)
    assert found.modes.natural_frequency.tolist() == [9.0] * 3 + [24.0] * 3
    assert found.modes.damping_ratio.tolist() == [0.03] * 3 + [0.02] * 3
    assert check_campaign(file).is_sound
    (warning,) = found.warnings
    assert "no campaign.toml" in warning


def test_modal_mass_gives_the_residues_that_the_frfs_have():
    """Two routes: shapes over the modal mass, and a fit of the FRFs beside them."""
    found = read_campaign(SAMPLE)
    table = found.modes
    for number, shape in SHAPES.items():
        rows = np.flatnonzero(table.mode == number)
        struck = int(np.argmax(np.abs(shape)))
        assert set(table.reference[rows].tolist()) == {struck + 1}
        np.testing.assert_allclose(table.amplitude[rows], np.array(shape) * shape[struck] / MASS, rtol=1e-5)
    for one in fit(found, per="posture"):
        for number, mode in enumerate(one.modes, start=1):
            rows = np.flatnonzero(table.mode == number)
            scale = 4j * np.pi * mode.frequency * np.sqrt(1 - mode.damping_ratio**2)
            for place, residue in zip(one.places, mode.residue, strict=True):
                shape = SHAPES[number]
                own = shape[place.response[0] - 1] * shape[place.reference[0] - 1] / MASS
                assert residue * scale == pytest.approx(own, rel=1e-6)
            assert rows.size == 3


def complex_mode(eigenvalue, modal_a, values):
    lines = ["NONE"] * 5 + [f"{1:10d}{3:10d}{2:10d}{8:10d}{5:10d}{3:10d}", f"{2:10d}{6:10d}{0:10d}{1:10d}"]
    parts = (eigenvalue.real, eigenvalue.imag, modal_a.real, modal_a.imag, 0.0, 0.0)
    lines.append("".join(f"{part:13.5e}" for part in parts))
    for node, value in values.items():
        lines += [f"{node:10d}", "".join(f"{part:13.5e}" for part in (0, 0, 0, 0, value.real, value.imag))]
    return dataset(55, *lines)


def test_a_complex_mode_has_its_frequency_damping_and_modal_a(tmp_path):
    eigenvalue, a, values = -3.0 + 60.0j, 5.0 + 40.0j, {4: 1.0 + 0.2j, 7: -0.5j}
    found = read_campaign(written(tmp_path, complex_mode(eigenvalue, a, values)))
    table = found.modes
    assert found.frfs is None
    assert table.natural_frequency[0] == pytest.approx(abs(eigenvalue) / (2 * np.pi), rel=1e-6)
    assert table.damping_ratio[0] == pytest.approx(3.0 / abs(eigenvalue), rel=1e-6)
    expected = 2j * 60.0 * np.array(list(values.values())) * values[4] / a
    np.testing.assert_allclose(table.amplitude, expected, rtol=1e-5)
    assert table.posture.tolist() == [1, 1]  # load case 0 is the only one


def test_a_pen_that_is_lifted_cuts_a_line(tmp_path):
    nodes = dataset(15, *(f"{n:10d}{0:10d}{0:10d}{8:10d}{n:13.5E}{0:13.5E}{0:13.5E}" for n in range(1, 10)))
    along = [1, 2, 0, 4, 5, 6, 7, 8, 0, 9]
    lines = ["".join(f"{n:10d}" for n in along[:8]), "".join(f"{n:10d}" for n in along[8:])]
    drawn = dataset(82, f"{1:10d}{len(along):10d}{0:10d}", "NONE", *lines)
    assert read_geometry(written(tmp_path, nodes, drawn)).lines == ((1, 2), (4, 5, 6, 7, 8))


NODE = f"{1:10d}{0:10d}{0:10d}{8:10d}" + f"{0.5:13.5E}" * 3


NODES = dataset(15, NODE)
MODE = {"eigenvalue": -1 + 9j, "modal_a": 1j, "values": {1: 1j}}


def line(declared, *nodes):
    return dataset(82, f"{1:10d}{declared:10d}{0:10d}", "NONE", "".join(f"{n:10d}" for n in nodes))


@pytest.mark.parametrize(
    ("parts", "says"),
    [
        ([dataset(15, NODE[:-13])], "dataset 1 (15, nodes): found fields that cannot be read"),
        ([dataset(15, NODE[:-13] + "     nan")], "dataset 1 (15, nodes): found fields that cannot be read"),
        ([NODES, NODES.replace("5.0", "6.0")], "dataset 2 (15, nodes): found node 1 at another place"),
        ([dataset(15, "0" + NODE[10:])], "found node 0; allowed: whole numbers from 1"),
        ([NODES, line(2, 1, 5)], "dataset 2 (82, trace line): found node 5; allowed: nodes of"),
        ([NODES, line(3, 1, 1)], "dataset 2 (82, trace line): found 2 nodes; allowed: 3"),
        ([complex_mode(0j, 1j, {1: 1j})], "dataset 1 (55, shape): found a natural frequency of 0 Hz"),
        ([complex_mode(**MODE) * 2], "dataset 2 (55, shape): found mode 1 of load case 0 again"),
        ([complex_mode(**{**MODE, "values": {}})], "dataset 1 (55, shape): found fields that cannot be read"),
    ],
)
def test_faults_name_the_dataset(tmp_path, parts, says):
    with pytest.raises(InvalidCampaign) as raised:
        read_campaign(written(tmp_path, *parts))
    assert says in str(raised.value)


def test_what_cannot_be_kept_is_said(tmp_path):
    turned = NODE.replace(f"{0:10d}{8:10d}", f"{3:10d}{8:10d}")
    file = written(tmp_path, dataset(15, turned), complex_mode(-1 + 9j, 0j, {1: 1j}))
    said = " ".join(read_campaign(file).warnings)
    assert "node 1: directions are along a coordinate system of the file" in said
    assert "without modal mass or modal a" in said


def test_a_shape_across_leaves_frequency_and_damping(tmp_path):
    up = f"{0:13.5e}" * 4 + f"{1:13.5e}" + f"{0:13.5e}"
    mode = complex_mode(-1 + 9j, 1j, {1: 1.0 + 0j})
    assert up in mode
    found = read_campaign(written(tmp_path, mode.replace(up, f"{1:13.5e}" + f"{0:13.5e}" * 5)))
    assert "not along z: frequencies and damping alone" in " ".join(found.warnings)
    assert np.all(np.isnan(found.modes.amplitude.real))
    assert found.modes.natural_frequency[0] == pytest.approx(abs(-1 + 9j) / (2 * np.pi), rel=1e-6)


def test_output_only_data_are_told_what_is_missing(campaign, tmp_path):
    """A file of the responses of blows, the force left out; and a table of them."""
    write_campaign(campaign, tmp_path / "c", binary=False)
    whole = (tmp_path / "c" / "time.uff").read_text().split("    -1\n    58")
    responses = [one for one in whole[1:] if f"{13:10d}" not in one]
    assert 0 < len(responses) < len(whole) - 1
    file = written(tmp_path, *("    -1\n    58" + one for one in responses))
    with pytest.raises(InvalidCampaign, match="responses without a force: output-only data; allowed"):
        read_campaign(file)
    table = tmp_path / "responses.csv"
    table.write_text("time [s],acc 1 [m/s²]\n" + "".join(f"{k / 100},{k % 7}\n" for k in range(50)))
    with pytest.raises(InvalidCampaign, match=r"output-only data \(columns 'time \[s\]'"):
        draft_map(table)


def test_import_makes_a_folder_to_fill_in(tmp_path):
    ran = CliRunner().invoke(import_, [str(SAMPLE), "--out", str(tmp_path / "bar")])
    assert ran.exit_code == 0, ran.output
    assert "2 FRFs, 6 rows of modes, 3 nodes with a place, 1 trace lines" in ran.output
    assert "the link of every point" in ran.output
    one, other = read_campaign(SAMPLE), read_campaign(tmp_path / "bar")
    np.testing.assert_array_equal(one.frfs.value, other.frfs.value)
    np.testing.assert_allclose(one.modes.amplitude, other.modes.amplitude)
    assert one.points == other.points
