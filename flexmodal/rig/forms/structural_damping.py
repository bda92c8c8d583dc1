"""Other laws of loss in the joints: all of them rows of Maxwell elements, hence causal and passive.

Each is scaled so that the real part is the joint's stiffness at the middle of the band, on a logarithmic
scale.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from flexmodal.rig.effects.effect import Effect, Parameters, Site, Stand, drawing, within
from flexmodal.rig.effects.structural_damping import EFFECT as OWN
from flexmodal.rig.forms.maxwell_rows import (
    Series,
    biot,
    cole_cole,
    fitted,
    fractional,
    power_law,
    two_peaks,
    zener,
)
from flexmodal.rig.plant.assembly import PlantAssembly

MOST_LOSS = 0.6


def _spread(site: Site, joint: int) -> float:
    """Factor of one joint's loss: from one joint to the next the phase turns by the golden angle."""
    return float(np.exp(site["spread"] * np.sin(site["phase"] + 2.399963 * joint)))


def acting(series: Callable[[Site, int], Series]) -> Callable[[PlantAssembly, Site], None]:
    """What a law of loss does in every joint.

    Args:
        series: the law of a site, in the joint of a number.
    """

    def act(assembly: PlantAssembly, site: Site) -> None:
        for number, joint in enumerate(site.stand.robot.joints):
            k, b = site.stand.true.stiffness[joint], site.stand.true.damping[joint]
            made, row = series(site, number), assembly.stretch(joint)
            assembly.add_spring(row, (made.static - 1) * k, (site["viscous"] - 1) * b + made.damper * k)
            assembly.add_relaxation(row, made.strengths * k, made.times)

    return act


_draw = drawing(loss_factor=(0.03, 0.12), viscous=(0.2, 1.0))
"""The card's own damping is there in part: who measures a loss factor has no damper beside it."""


def _draw_zener(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    low, high = stand.plan.band
    peak = np.exp(random.uniform(np.log(max(2 * low, 0.02 * high)), np.log(0.4 * high)))
    return {**_draw(stand, where, random), "frequency": float(peak)}


def _draw_biot(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    low, high = stand.plan.band
    onset = np.exp(random.uniform(np.log(2 * low), np.log(0.3 * high)))
    return {**_draw(stand, where, random), "onset": float(onset)}


def _scaled(parameters: Parameters, s: float) -> dict[str, float]:
    """The loss grows with the severity; below 1 the card's damping comes back."""
    viscous = 1 - (1 - parameters["viscous"]) * min(s, 1.0)
    return {**parameters, "loss_factor": parameters["loss_factor"] * s, "viscous": viscous}


def _form(
    form: str, says: str, source: str, series: Callable[[Site, int], Series],
    units: dict[str, str], draws: dict[str, tuple[float, float]], spans: dict[str, tuple[float, float]],
) -> Effect:  # fmt: skip
    return replace(
        OWN,
        form=form,
        says=says,
        source=source,
        units={**OWN.units, **units},
        draw=drawing(_draw, **draws),
        scaled=_scaled,
        most=lambda parameters: MOST_LOSS / max(parameters["loss_factor"], 1e-9),
        check=within(loss_factor=(0.0, MOST_LOSS), viscous=(0.0, np.inf), **spans),
        act=acting(series),
    )


POWER_LAW = _form(
    "power_law",
    "a loss factor that goes as a power of frequency",
    "Jones, Handbook of Viscoelastic Vibration Damping, Wiley 2001, chapter 2",
    lambda site, joint: power_law(site["loss_factor"], site["exponent"], site.stand.plan.band),
    {"exponent": "of frequency"}, {"exponent": (-0.25, 0.25)}, {"exponent": (-0.5, 0.5)},
)  # fmt: skip
ZENER = replace(
    _form(
        "zener", "the standard linear solid: loss that peaks at one frequency",
        "Zener, Elasticity and Anelasticity of Metals, University of Chicago Press 1948, part two",
        lambda site, joint: zener(site["loss_factor"], site["frequency"], site.stand.plan.band),
        {"frequency": "Hz, where the loss peaks"}, {}, {"frequency": (1e-3, 1e6)},
    ),
    draw=_draw_zener,
)  # fmt: skip
PRONY = _form(
    "prony",
    "three Maxwell elements fitted to a constant loss factor, which ripples",
    "Park and Schapery, Int. J. Solids and Structures 36 (1999) 1653, on Prony series",
    lambda site, joint: fitted(
        lambda omega: np.full(len(omega), site["loss_factor"]), site.stand.plan.band, 3, 1.0
    ),
    {}, {}, {},
)  # fmt: skip
FRACTIONAL = _form(
    "fractional",
    "a fractional derivative of order α beside the spring",
    "Bagley and Torvik, Journal of Rheology 27 (1983) 201; kernel: Montseny, ESAIM Proc. 5 (1998) 159",
    lambda site, joint: fractional(site["loss_factor"], site["order"], site.stand.plan.band),
    {"order": "α"}, {"order": (0.15, 0.45)}, {"order": (0.05, 0.7)},
)  # fmt: skip
BY_JOINT = _form(
    "by_joint",
    "a constant loss factor, each joint its own",
    "Ewins, Modal Testing, 2nd ed., section 2.4: a hysteretic damping matrix that is not proportional",
    lambda site, joint: fitted(
        lambda omega: np.full(len(omega), min(site["loss_factor"] * _spread(site, joint), 1.0)),
        site.stand.plan.band, 9, 4.0,
    ),
    {"spread": "of the logarithm of a joint's loss factor", "phase": "rad"},
    {"spread": (0.5, 1.2), "phase": (0.0, 2 * np.pi)}, {"spread": (0.0, 3.0)},
)  # fmt: skip

TWO_PEAKS = _form(
    "two_peaks",
    "two relaxations far apart, each with its own peak of loss",
    "Nowick and Berry, Anelastic Relaxation in Crystalline Solids, Academic Press 1972",
    lambda site, joint: two_peaks(
        site["loss_factor"], site["low"], site["apart"], site["second"], site.stand.plan.band
    ),
    {
        "low": "first peak, as part of the band's logarithm", "apart": "second peak, likewise from there",
        "second": "strength over the first",
    },
    {"low": (0.05, 0.35), "apart": (0.4, 0.6), "second": (0.4, 2.0)},
    {"low": (-1.0, 2.0), "apart": (0.0, 2.0), "second": (0.0, 20.0)},
)  # fmt: skip
GEARED = _form(
    "geared",
    "a constant loss factor in some joints, none in the others",
    "Ewins, Modal Testing, 2nd ed., section 2.4, as by_joint; some joints have gears and others none",
    lambda site, joint: fitted(
        lambda omega: np.full(
            len(omega), site["loss_factor"] if np.sin(site["phase"] + 2.399963 * joint) > 0 else 1e-4
        ),
        site.stand.plan.band, 9, 4.0,
    ),
    {"phase": "rad, says which"}, {"phase": (0.0, 2 * np.pi)}, {},
)  # fmt: skip
COLE_COLE = replace(
    _form(
        "cole_cole", "a broad peak of loss: relaxation in a spread of times",
        "Cole and Cole, J. Chemical Physics 9 (1941) 341; Pritz, J. Sound and Vibration 265 (2003) 935",
        lambda site, joint: cole_cole(
            site["loss_factor"], site["frequency"], site["order"], site.stand.plan.band
        ),
        {"frequency": "Hz, of the peak", "order": "α"}, {}, {"frequency": (1e-3, 1e6), "order": (0.1, 1.0)},
    ),
    draw=drawing(_draw_zener, order=(0.4, 0.8)),
)  # fmt: skip
BIOT = replace(
    _form(
        "biot", "a loss factor that sets in at one frequency and stays",
        "Biot, Proc. 3rd U.S. National Congress of Applied Mechanics (1958) 1; Makris, J. Engineering "
        "Mechanics 123 (1997) 1209",
        lambda site, joint: biot(site["loss_factor"], site["onset"], site.stand.plan.band),
        {"onset": "Hz, where the loss sets in"}, {}, {"onset": (1e-3, 1e6)},
    ),
    draw=_draw_biot,
)  # fmt: skip

FORMS = (POWER_LAW, ZENER, PRONY, FRACTIONAL, BY_JOINT, TWO_PEAKS, GEARED, COLE_COLE, BIOT)
