"""The thesis's runs as studies: printed numbers, the same postures in the model, and ours; `make studies`.

In every study with the tool held the best of 10⁴ other random starts is searched for too, to see whether the
default settings found it.
"""

from __future__ import annotations

import sys

from tables import TABLES

from flexmodal.files import whole_file
from flexmodal.optimisation.studies import StudyResult, run_study, shipped_studies

MANY = 10_000


def number(value: float | None) -> str:
    if value is None:
        return "–"
    return "0" if abs(value) < 1e-14 else f"{value:.4g}"


def place(value: float, form: str) -> str:
    return "unbounded" if value == float("inf") else format(value, form)


def main() -> None:
    studies = shipped_studies().values()
    parts = [posture_table(studies), sweep_table(studies), frequency_table(studies)]
    missed = parts[0][1]
    text = "\n".join(table for table, _ in parts)
    with whole_file(TABLES / "studies.md", overwrite=True) as scratch:
        scratch.write_text(text, encoding="utf-8")
    print(text)
    sys.exit(1 if missed else 0)


def table(title: str, lead: str, header: list[str], rows: list[list[str]], says: dict[str, list[str]]) -> str:
    lines = [title, "", lead, "", "| " + " | ".join(header) + " |"]
    lines.append("|" + "|".join(["---"] + ["---:"] * (len(header) - 1)) + "|")
    lines += ["| " + " | ".join(row) + " |" for row in rows]
    lines += ["", *(f"- {', '.join(names)}: {sentence}" for sentence, names in says.items()), ""]
    return "\n".join(lines)


def posture_table(studies) -> tuple[str, list[str]]:
    rows, says, missed = [], {}, []
    for study in studies:
        if study.kind != "posture":
            continue
        found = run_study(study)
        many = run_study(study, starts=MANY, seed=1) if study.hold else None
        missed += faults(found, many)
        outcome = found.outcome
        rows.append(
            [
                study.name,
                f"({study.hold[0]:g}, {study.hold[1]:g})" if study.hold else "free",
                "ξ_K" if study.objective == "stiffness" else f"{study.frequency:g} Hz",
                number(study.printed_start),
                number(found.start),
                number(study.printed_final),
                number(found.printed),
                number(found.best),
                number(many.best) if many else "–",
                f"{found.better:.3g}" if found.best > 1e-14 else "∞",
                f"{outcome.best.hits} of {outcome.starts}",
                str(outcome.unbounded) if study.objective == "stiffness" else "–",
            ]
        )
        says.setdefault(study.says, []).append(study.name)
    header = [
        "study", "held at [m]", "judged by", "start, printed", "start, model", "final, printed",
        "final posture, model", "ours", f"best of {MANY} starts", "gain", "hits", "ran singular",
    ]  # fmt: skip
    verdict = (
        "In every study ours is at least as good as the printed final posture in the model, and with the "
        "tool held it is the best of the 10⁴ starts."
        if not missed
        else "Missed: " + "; ".join(missed) + "."
    )
    lead = (
        "Made by `make studies`; `flexmodal studies NAME` runs one. |receptance| along z in m/N, stiffness "
        "measure ξ_K in N/m. *Printed* is the thesis's number, *model* the same posture in the card "
        "`six_link`, *ours* the search with its default settings, which stop when five starts have ended in "
        "the best, or one in a zero; *gain* compares ours with the printed final posture, both in the "
        f"model. {verdict}"
    )
    return table("# Studies\n\n## Postures of the six-link arm", lead, header, rows, says), missed


def faults(found: StudyResult, many: StudyResult | None) -> list[str]:
    """What would not be as the page says."""
    sign = -1 if found.study.objective == "stiffness" else 1
    tolerance = 1e-6 * abs(found.best) + 1e-14
    missed = []
    if found.printed is not None and sign * found.best > sign * found.printed + tolerance:
        missed.append(f"{found.study.name} is worse than the printed posture")
    if many is not None and sign * found.best > sign * many.best + tolerance:
        missed.append(f"{found.study.name}: {MANY} starts find {many.best:.4g}")
    return missed


def sweep_table(studies) -> tuple[str, None]:
    rows, says = [], {}
    for study in studies:
        if study.kind == "sweep":
            found = run_study(study)
            rows.append(
                [
                    study.name,
                    *(number(value) for value in study.printed_ends),
                    *(number(value) for value in found.ends),
                    *(number(value) for value in found.pole_sum),
                    "–" if study.printed_best is None else f"{study.printed_best * 57.29578:.0f}°",
                    f"{found.at * 57.29578:.1f}°",
                ]
            )
            says.setdefault(study.says, []).append(study.name)
    header = [
        "study", "45°, printed", "135°, printed", "45°, model", "135°, model", "45°, sum over poles",
        "135°, sum over poles", "best, printed", "best, model",
    ]  # fmt: skip
    lead = (
        "|receptance| of the tool along z [m/N] at both ends of the sweep, |Σ 1/(iω − λ)| over the model's "
        "poles [s/rad], which is what the thesis prints above 46 Hz, and the best angle."
    )
    return table("## Configurations of the Fanuc (section 3.2)", lead, header, rows, says), None


def frequency_table(studies) -> tuple[str, None]:
    rows, says = [], {}
    for study in studies:
        if study.kind == "frequency":
            found = run_study(study)
            rows.append(
                [
                    study.name,
                    ", ".join(f"{value:g}" for value in study.starts),
                    ", ".join(
                        "unbounded" if value == float("inf") else f"{value:g}" for value in study.printed_ends
                    ),
                    ", ".join(
                        "unbounded" if value == float("inf") else f"{value:.1f}" for value in found.ends
                    ),
                    ", ".join(f"{value:.2f}" for value in found.minima),
                    ", ".join(f"{peak.frequency:.2f}" for peak in found.tuning.maxima),
                    "; ".join(found.hops) or "–",
                ]
            )
            says.setdefault(study.says, []).append(study.name)
    header = [
        "study", "from [Hz]", "to, printed [Hz]", "downhill in the model [Hz]", "all minima [Hz]",
        "all maxima [Hz]", "steps over a maximum at a gain of 20 Hz²",
    ]  # fmt: skip
    lead = "Where the slope leads from the thesis's starting frequencies, and all minima from 0 to 200 Hz."
    return table("## Operating frequency of the Fanuc (Table 3.6)", lead, header, rows, says), None


if __name__ == "__main__":
    main()
