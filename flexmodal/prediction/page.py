"""A prediction as one self-contained HTML page."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from flexmodal.prediction.frf_prediction import BESIDE, CHOSEN_ANEW, SHUFFLED, FrfPrediction
from flexmodal.prediction.methods import METHODS
from flexmodal.prediction.plot import draw_left_out, draw_prediction
from flexmodal.report import Facts, Picture, Section, Table, Text, columns, page_text, write_page
from flexmodal.report.words import noises

HEADER = ("method", "typical gap", "× the noise", "over all", "worst posture", "what it is")
KEYS = {CHOSEN_ANEW: "anew", SHUFFLED: "shuffled"}
"""What rows below the methods are called in `LeftOut.times`."""
NOTE = (
    "Every posture was left out in turn, of the fit of the physics too, and predicted from the others. The "
    "typical gap, by which the method is chosen, is the geometric mean over postures; over all is the root "
    "mean square, which one posture can decide. "
    "Chosen anew: the method chosen without the posture that it is judged by, which is what to expect of a "
    "new one. Angles shuffled: a control that has seen every posture, under another's angles; where it fits "
    "as well as with the right ones, these data do not tell the postures apart. A gap of 0.1 means that on a "
    "typical line the prediction is 10 % off in size or 6° in phase."
)


def write_prediction_page(prediction: FrfPrediction, path: Path, *, overwrite: bool = False) -> None:
    """Write the page; it needs no network.

    Args:
        prediction: of one posture.
        path: the file; written whole or not at all.
        overwrite: replace an existing file.

    Raises:
        OutputExists: the file exists.
    """
    rows = method_cells(prediction)
    chosen = frozenset(k for k, row in enumerate(rows) if row[0] == prediction.method)
    verdict = prediction.verdict[:1].upper() + prediction.verdict[1:]
    picture = Picture(
        partial(draw_prediction, prediction),
        f"Size of {len(prediction.frfs)} predicted receptances over frequency, with the 95 % band",
        "The band is made of the errors on postures that were left out.",
    )
    posture = ", ".join(f"{name} = {value:.4g}" for name, value in prediction.posture.items())
    sections = [
        Section(
            "Postures left out",
            [
                Table(columns(HEADER, words=HEADER[-2:]), rows, chosen=chosen),
                Text(NOTE, note=True),
                Picture(partial(draw_left_out, prediction), "Gap of each method on each posture left out"),
            ],
        ),
        Section(
            "Where it comes from",
            [
                Facts(
                    {
                        "robot": prediction.robot,
                        "campaign": prediction.campaign,
                        "posture [rad, m]": posture,
                        "postures struck": str(len(prediction.left_out.postures)),
                    }
                )
            ],
        ),
    ]
    title = f"{prediction.robot}: FRFs of a posture that nobody struck"
    write_page(path, page_text(title, [f"{verdict}.", picture], sections), overwrite=overwrite)


def method_cells(prediction: FrfPrediction) -> list[tuple[str, ...]]:
    """Rows of text under `HEADER`.

    Args:
        prediction: with what was left out.
    """
    left = prediction.left_out
    names = left.names
    cells: list[tuple[str, ...]] = []
    for name, usual, total, each in prediction.rows:
        worst = max(range(len(names)), key=lambda k, own=each: own[k])  # type: ignore[misc]
        cells.append(
            (
                name,
                f"{usual:.2g}",
                noises(left.typical_times(KEYS.get(name, name))),
                f"{total:.2g}",
                f"{names[worst]}: {each[worst]:.2g}",
                {**METHODS, **BESIDE}[name],
            )
        )
    return cells
