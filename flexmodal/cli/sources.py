"""Receptances predicted from a campaign in place of the card's own, as options of several commands."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from flexmodal.cli.measured import campaign_at, refuse_export, say_findings
from flexmodal.cli.options import SOURCE, Command, poor_option, trust_of, trust_option
from flexmodal.cli.printing import progress, say
from flexmodal.errors import Fault, InvalidRequest

if TYPE_CHECKING:
    from flexmodal.campaign import Campaign
    from flexmodal.model import PosedRobot, Robot
    from flexmodal.model.receptance_source import Pair
    from flexmodal.prediction import PredictedReceptances

METHODS = ("hybrid", "physics", "process", "mean", "nearest")
FAR = 1.5
"""Multiple of the distance between the struck postures from which an answer is called far from them."""


@dataclass(frozen=True)
class Sourcing:
    """What the options say."""

    campaign: Path | None
    predict_by: str | None
    trust: tuple[str, ...]
    poor_card: bool

    def source(self, arm: Robot, *, quiet: bool) -> PredictedReceptances | None:
        """The prediction asked for, its worth said on standard error; None where the card is to serve.

        Args:
            arm: the robot.
            quiet: no progress bar.
        """
        if self.campaign is None:
            given = {"--predict-by": self.predict_by, "--trust": self.trust, "--poor-card": self.poor_card}
            named = [name for name, value in given.items() if value]
            if named:
                raise InvalidRequest(Fault(SOURCE, " and ".join(named), "no --campaign", "--campaign DIR"))
            return None
        from flexmodal.prediction import PredictedReceptances, build_prediction

        measured = campaign_at(self.campaign)
        refuse_export(measured)
        say_findings(measured, arm)
        with leaving_out(measured, quiet=quiet) as advance:
            problem = build_prediction(
                measured, arm, trust=trusted(self.trust, poor=self.poor_card), advance=advance
            )
        found = PredictedReceptances(problem, self.predict_by or "")
        say(f"receptances {found.verdict}", err=True)
        return found


def source_options(command: Command) -> Command:
    """`--campaign` and what goes with it, given to the command as one `Sourcing`."""

    @wraps(command)
    def gathered(**given: Any) -> Any:
        own = {field.name: given.pop(field.name) for field in fields(Sourcing)}
        return command(sourcing=Sourcing(**own), **given)

    wrapped: Any = gathered
    for decorate in (
        poor_option,
        trust_option,
        click.option(
            "--predict-by",
            type=click.Choice(METHODS),
            help="With --campaign: instead of the method that predicts best what was left out.",
        ),
        click.option(
            "--campaign",
            type=click.Path(path_type=Path),
            metavar="DIR",
            help="Receptances as flexmodal predict gives them from what was measured there.",
        ),
    ):
        wrapped = decorate(wrapped)
    return wrapped


def no_source(command: Command) -> Command:
    """`--campaign` of a command that has no use for it: refused with what to do in its place."""

    def refuse(context: click.Context, option: click.Parameter, value: str | None) -> None:
        if value is not None:
            name = context.info_name
            allowed = (
                f"lobes, optimise or atlas with it; or flexmodal {name} FOLDER, the robot that identify or "
                "diagnose wrote from this campaign"
            )
            raise InvalidRequest(Fault(SOURCE, "--campaign", f"with {name}", allowed))

    decorate = click.option("--campaign", hidden=True, expose_value=False, callback=refuse)
    return decorate(command)


def trusted(texts: tuple[str, ...], *, poor: bool) -> dict[str, float]:
    """How far the card may be off.

    Args:
        texts: of `--trust`.
        poor: whether little is known.
    """
    from flexmodal.identification.poor import POOR

    return {**(POOR if poor else {}), **trust_of(texts)}


def leaving_out(measured: Campaign, *, quiet: bool) -> Any:
    """A bar over a fit and the postures that are left out of it.

    Args:
        measured: the campaign.
        quiet: no bar.
    """
    import numpy as np

    count = 0 if measured.frfs is None else len(np.unique(measured.frfs.posture))
    return progress(1 + (count or len(measured.postures)), "leaving out", quiet=quiet)


def band_json(
    source: PredictedReceptances, posed: PosedRobot, pairs: list[Pair], frequency: Any
) -> dict[str, Any]:
    """Where an answer comes from, and how far it may be off.

    Args:
        source: of the receptances.
        posed: the answer.
        pairs: that were judged.
        frequency: likewise [Hz].
    """
    import numpy as np

    found = source.band(posed, pairs, frequency)
    return {
        "campaign": source.problem.campaign.title,
        "method": source.method,
        "data_alone": source.is_data_alone,
        "verdict": source.verdict,
        "factor": float(np.exp(found.log_size.max())),
        "remote": found.remote,
        "beyond": list(found.beyond),
    }


def band_says(value: float, unit: str, told: dict[str, Any]) -> list[str]:
    """The same in sentences.

    Args:
        value: that was found.
        unit: its unit.
        told: by `band_json`.
    """
    factor = told["factor"]
    says = [
        f"predicted by {told['method']}; with its 95 % band {value / factor:.3g} to {value * factor:.3g} "
        f"{unit} there"
    ]
    if told["data_alone"]:
        says.append("data alone: physics has no part in it, away from the struck postures nothing holds it")
    if told["beyond"]:
        says.append(f"outside what was struck: {', '.join(told['beyond'])}; strike a posture there")
    if told["remote"] > FAR:
        says.append(f"{told['remote']:.1f} times as far from the struck postures as these are apart")
    return says
