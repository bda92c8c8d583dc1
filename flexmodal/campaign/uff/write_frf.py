"""FRFs as Universal File Format dataset 58, as every modal-testing package reads them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from flexmodal.campaign.uff.codes import CODE_OF, EXPONENTS, FORCE, FRF
from flexmodal.campaign.uff.write import write_uff
from flexmodal.errors import Fault, InvalidPoint
from flexmodal.files import whole_file
from flexmodal.frf import Frf
from flexmodal.frf.direction import AXES, PointDirection


def write_frf(
    frf: Frf,
    path: Path,
    nodes: Mapping[str, int],
    *,
    posture: int = 1,
    title: str = "",
    overwrite: bool = False,
) -> None:
    """Write every pair of an FRF as one dataset 58, ASCII.

    Args:
        frf: what to write, in SI units.
        path: the file; written whole or not at all.
        nodes: node number of each point.
        posture: load case number.
        title: first identification line, cut to 80 characters.
        overwrite: replace an existing file.

    Raises:
        InvalidPoint: a point without a node number.
        OutputExists: the file exists.
    """
    missing = {d.point for d in (*frf.response, *frf.reference)} - set(nodes)
    if missing:
        raise InvalidPoint(
            Fault(str(path), "nodes", f"no number for {', '.join(sorted(missing))}", "one each")
        )
    records = [
        _record(frf, row, column, nodes, posture, title)
        for column in range(len(frf.reference))
        for row in range(len(frf.response))
    ]
    with whole_file(path, overwrite=overwrite) as scratch:
        write_uff(records, scratch)


def _record(
    frf: Frf, row: int, column: int, nodes: Mapping[str, int], posture: int, title: str
) -> dict[str, Any]:
    response, reference = frf.response[row], frf.reference[column]
    # pyuff asks for a second abscissa even of a single line; flagged even, only the first is written
    axis = frf.frequency if len(frf.frequency) > 1 else np.repeat(frf.frequency, 2)
    steps = np.diff(axis)
    even = bool(np.allclose(steps, steps[0], rtol=1e-9, atol=0))
    numerator = CODE_OF[frf.form]
    return {
        "type": 58,
        "binary": 0,
        "func_type": FRF,
        "load_case_id": posture,
        "ver_num": 1,
        "rsp_node": nodes[response.point],
        "rsp_dir": _direction(response),
        "rsp_ent_name": _plain(response.point, 10),
        "ref_node": nodes[reference.point],
        "ref_dir": _direction(reference),
        "ref_ent_name": _plain(reference.point, 10),
        "id1": _plain(title, 80),
        "id2": _plain(f"{frf.form} {response} per {reference}", 80),
        "data": frf.value[:, row, column],
        "x": axis,
        "ord_data_type": 6,
        "abscissa_spacing": int(even),
        "abscissa_min": float(frf.frequency[0]),
        "abscissa_inc": float(steps[0]) if even else 0.0,
        "abscissa_spec_data_type": 18,
        "abscissa_axis_lab": "Frequency",
        "abscissa_axis_units_lab": "Hz",
        "ordinate_spec_data_type": numerator,
        "orddenom_spec_data_type": FORCE,
        **_lengths("ordinate", numerator),
        **_lengths("orddenom", FORCE),
    }


def _plain(text: str, width: int) -> str:
    """Printable ASCII of one line: anything else would shift the columns of the record."""
    return "".join(sign if " " <= sign <= "~" else "?" for sign in text[:width])


def _direction(direction: PointDirection) -> int:
    """±1 to ±3 along x, y, z; ±4 to ±6 about them."""
    return direction.sign * (AXES.index(direction.axis) + 1)


def _lengths(key: str, code: int) -> dict[str, int]:
    length, force = EXPONENTS[code]
    return {f"{key}_len_unit_exp": length, f"{key}_force_unit_exp": force, f"{key}_temp_unit_exp": 0}
