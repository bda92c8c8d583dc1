"""Tables of the report of a diagnosis from modes."""

from __future__ import annotations

import numpy as np

from flexmodal.diagnosis.findings import Findings, ModesSeen
from flexmodal.diagnosis.names import NONE, UNSTRUCTURED
from flexmodal.diagnosis.report.modal_pictures import RETUNED, short
from flexmodal.identification.evidence.likelihood.errors import Errors, errors, figures
from flexmodal.identification.evidence.likelihood.laplace import ModalFit
from flexmodal.report import Cell, Column, Table
from flexmodal.report.words import fixed, percent, size

COMPARISON = (
    Column("explanation", words=True), Column("adds"), Column("modes without a partner"),
    Column("evidence", "nat"), Column("under other priors", "nat"), Column("held out", "nat"),
    Column("probability", words=True),
)  # fmt: skip
SUMMARY = (
    Column("model", words=True),
    *(
        Column(kind, group=group)
        for group in ("fitted", "held out")
        for kind in ("without a partner", "frequency", "damping", "mean MAC", "gap")
    ),
)
SHAPES = (
    Column("mode", words=True), Column("measured between postures"), Column("predicted between postures"),
    Column("one prediction with the other"), Column("predicted with measured"), Column("as measured", "nat"),
    Column("if careful", "nat"),
)  # fmt: skip


def summary_rows(found: ModesSeen, name: str) -> list[list[str]]:
    """Re-tuned, with what was added, the two baselines: fitted, and each posture held out."""
    rows = [
        _figures(
            "re-tuned, nothing added",
            errors(found.before),
            None if found.held_before is None else found.held_before.errors,
        )
    ]
    if found.after.model.key[0] not in (NONE, UNSTRUCTURED):
        rows.append(
            _figures(name, errors(found.after), None if found.held_after is None else found.held_after.errors)
        )
    if found.free is not None:
        rows.append(
            _figures(
                "one more mode with no structure",
                errors(found.free),
                None if found.held_free is None else found.held_free.errors,
            )
        )
    rows.append(_figures("the mean of the other postures", None, found.mean))
    return rows


def _figures(name: str, fitted: Errors | None, held: Errors | None) -> list[str]:
    cells = [name]
    for table in (fitted, held):
        if table is None:
            cells += ["–"] * 5
            continue
        f = figures(table)
        cells += [str(f.missing), f"{100 * f.frequency:.2f} %", f"{100 * f.damping:.0f} %", fixed(f.mac, 2),
                  size(f.gap)]  # fmt: skip
    return cells


def comparison_rows(found: Findings) -> list[list[str | Cell]]:
    """Everything that was compared, under `COMPARISON`, the most probable first."""
    comparison, rows = found.comparison, list[list[str | Cell]]()
    base = len(comparison.models[0].model.space)
    gain = comparison.table - comparison.table[0]
    nothing = comparison.models[0].held
    for k in comparison.order:
        one = comparison.models[k]
        held = None if one.held is None or nothing is None else one.held.score - nothing.score
        rows.append([
            Cell("nothing added" if k == 0 else short(one.key), tag="tie" if one.key in found.tied else ""),
            str(len(one.model.space) - base),
            str(sum(partner < 0 for partner in one.fit.pairs)),
            fixed(gain[k, 0], 1),
            f"{fixed(gain[k].min(), 0)} … {fixed(gain[k].max(), 0)}",
            fixed(held, 1, "+"),
            Cell(percent(comparison.probability[k]), bar=float(comparison.probability[k])),
        ])  # fmt: skip
    return rows


def shape_rows(found: Findings) -> list[list[str]]:
    """Shape by shape, under `SHAPES`: what was measured, what two explanations predict."""
    return [
        [f"{s.frequency:.3g} Hz", fixed(s.measured, 2), f"{fixed(s.model[0], 2)}, {fixed(s.model[1], 2)}",
         fixed(s.alike, 2), f"{fixed(s.met[0], 2)}, {fixed(s.met[1], 2)}", fixed(s.says, 1, "+"),
         f"{s.clean:.0f}"]
        for s in found.shapes
    ]  # fmt: skip


def mode_table(found: ModesSeen, name: str) -> Table:
    """Every measured mode beside the models.

    Args:
        found: the modes.
        name: of the second model; `RETUNED` where nothing was added, and there is none.
    """
    models = {RETUNED: found.before, name: found.after}
    names = ("measured [Hz]", *models, "held out", "mean of the others")
    heads = [Column("posture", words=True), *(Column(one, group="natural frequency") for one in names)]
    heads += [Column(one, group="damping ratio") for one in ("measured", *models)]
    rows = []
    for k, mode in enumerate(found.measured.modes):
        held = None if found.held_after is None else found.held_after.frequency[k]
        mean = mode.frequency * (1 + found.mean[k, 0]) if found.mean[k, 0] != 1 else None
        rows.append([
            found.measured.postures[mode.posture].name,
            f"{mode.frequency:.2f} ± {mode.frequency * mode.frequency_error:.2f}",
            *(_frequency(one, k) for one in models.values()), fixed(held, 2), fixed(mean, 2),
            fixed(mode.damping_ratio, 3), *(_damping(one, k) for one in models.values()),
        ])  # fmt: skip
    return Table(heads, rows)


def _frequency(fit: ModalFit, k: int) -> str:
    seen = fit.forecasts[fit.measured.modes[k].posture]
    return f"{np.exp(seen.log_frequency[fit.pairs[k]]):.2f}" if fit.pairs[k] >= 0 else "–"


def _damping(fit: ModalFit, k: int) -> str:
    seen = fit.forecasts[fit.measured.modes[k].posture]
    return f"{np.exp(seen.log_damping[fit.pairs[k]]):.3f}" if fit.pairs[k] >= 0 else "–"
