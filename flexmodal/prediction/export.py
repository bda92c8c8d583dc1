"""A prediction as CSV, as a universal file, and as the object that `flexmodal predict --json` prints."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np

from flexmodal.campaign import write_frf
from flexmodal.errors import Fault, InvalidRequest
from flexmodal.files import whole_file
from flexmodal.frf import Frf
from flexmodal.frf.export import COLUMNS as FRF_COLUMNS
from flexmodal.prediction.frf_prediction import FrfPrediction
from flexmodal.prediction.methods import METHODS
from flexmodal.report.parts import finite

COLUMNS = (*FRF_COLUMNS, "low", "high", "phase_half_width")
UNIT = "m/N"


def write_csv(prediction: FrfPrediction, path: Path, *, overwrite: bool = False) -> None:
    """One row for each line and pair of places, with the 95 % band; the header names the columns.

    Args:
        prediction: what to write.
        path: the file; written whole or not at all.
        overwrite: replace an existing file.

    Raises:
        OutputExists: the file exists.
    """
    with whole_file(path, overwrite=overwrite) as scratch, scratch.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        for one in prediction.frfs:
            names = (str(one.response), str(one.reference), "receptance", UNIT)
            parts = (one.value.real, one.value.imag, one.low, one.high, one.phase)
            for frequency, *numbers in zip(prediction.frequency, *parts, strict=True):
                told = [repr(float(number)) for number in numbers]
                writer.writerow([repr(float(frequency)), *names, *told])


def write_uff(prediction: FrfPrediction, path: Path, *, overwrite: bool = False) -> None:
    """The receptances as datasets 58; a universal file has no place for a band.

    Args:
        prediction: what to write.
        path: the file; written whole or not at all.
        overwrite: replace an existing file.

    Raises:
        InvalidRequest: not every response was measured for every force.
        OutputExists: the file exists.
    """
    points = dict.fromkeys(d.point for one in prediction.frfs for d in (one.response, one.reference))
    nodes = {name: number for number, name in enumerate(points, start=1)}
    write_frf(as_frf(prediction), path, nodes, title=f"predicted: {prediction.robot}", overwrite=overwrite)


def as_frf(prediction: FrfPrediction) -> Frf:
    """The receptances as a matrix of responses and forces, as every other room takes them.

    Args:
        prediction: of every response for every force.

    Raises:
        InvalidRequest: not every response was measured for every force.
    """
    responses = list(dict.fromkeys(one.response for one in prediction.frfs))
    references = list(dict.fromkeys(one.reference for one in prediction.frfs))
    known = {(one.response, one.reference): one.value for one in prediction.frfs}
    missing = [f"{r} per {f}" for r in responses for f in references if (r, f) not in known]
    if missing:
        allowed = "every response for every force; a .csv or .json file holds any"
        raise InvalidRequest(Fault("call", "out", f"no {', '.join(missing[:5])}", allowed))
    value = np.array([[known[r, f] for f in references] for r in responses])
    return Frf(
        frequency=prediction.frequency,
        value=np.ascontiguousarray(np.moveaxis(value, 2, 0)),
        response=tuple(responses),
        reference=tuple(references),
        form="receptance",
    )


def as_json(prediction: FrfPrediction) -> dict[str, Any]:
    """Receptances with their band, the method, and what every method makes of postures left out.

    Args:
        prediction: what to show.
    """
    left = prediction.left_out
    names = [left.panel.observations.postures[number].name for number in left.postures]
    rows = {
        name: {
            "gap": finite(total),
            "typical": finite(usual),
            "postures": [finite(float(one)) for one in each],
        }
        for name, usual, total, each in prediction.rows
    }
    return {
        "robot": prediction.robot,
        "campaign": prediction.campaign,
        "posture": dict(prediction.posture),
        "method": prediction.method,
        "data_alone": prediction.is_data_alone,
        "beyond": list(prediction.beyond),
        "verdict": prediction.verdict,
        "noise_floor": finite(left.noise_floor),
        "share": left.share,
        "mix": left.mix,
        "beside": left.beside,
        "left_out": {"postures": names, "methods": rows},
        "methods": dict(METHODS),
        "form": "receptance",
        "unit": UNIT,
        "ways": {name: list(way) for name, way in prediction.ways.items()},
        "frequency": prediction.frequency.tolist(),
        "frfs": [
            {
                "response": str(one.response),
                "reference": str(one.reference),
                "re": one.value.real.tolist(),
                "im": one.value.imag.tolist(),
                "low": one.low.tolist(),
                "high": one.high.tolist(),
                "phase_half_width": one.phase.tolist(),
            }
            for one in prediction.frfs
        ],
    }
