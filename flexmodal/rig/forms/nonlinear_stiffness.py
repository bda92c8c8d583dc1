"""Other springs that are not straight: cubic, in steps, levelling off, exponential, leaning, with play.

All act beside the joint's own spring; the whole stays a spring that pushes back at every deflection.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from flexmodal.rig.effects.effect import (
    Check,
    Draw,
    Effect,
    Parameters,
    Site,
    Stand,
    each,
    multiplied,
    positive,
    within,
)
from flexmodal.rig.effects.nonlinear_stiffness import EFFECT as OWN
from flexmodal.rig.plant.assembly import PlantAssembly
from flexmodal.rig.plant.plant import HERTZ, PIECEWISE, POLYNOMIAL, SATURATING, SINH, NonlinearElement

_CUT = 3.0
"""Beyond so many of its deflections the exponential spring goes along its tangent."""


def _element(assembly: PlantAssembly, site: Site, kind: int, *numbers: float) -> None:
    assembly.elements.append(NonlinearElement(assembly.stretch(site.where), kind, numbers))


def _stiffness(site: Site) -> float:
    return float(site.stand.true.stiffness[site.where])


def _drawing(change: tuple[float, float], deflection: tuple[float, float]) -> Draw:
    """A change, and a deflection over the joint's peak under the hardest blow."""

    def draw(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
        return {
            "change": float(random.uniform(*change)),
            "deflection": float(random.uniform(*deflection) * stand.deflection[where][1]),
        }

    return draw


def _checking(most: float) -> Check:
    return each(within(change=(0.0, most)), positive("deflection"))


def _act_cubic(assembly: PlantAssembly, site: Site) -> None:
    _element(assembly, site, POLYNOMIAL, 0.0, site["change"] * _stiffness(site) / site["deflection"] ** 2)


def _act_windup(assembly: PlantAssembly, site: Site) -> None:
    """Half of the change at one deflection, half at three of them."""
    step, at = site["change"] * _stiffness(site) / 2, site["deflection"]
    _element(assembly, site, PIECEWISE, step, at, step, 3 * at)


def _act_levelling(assembly: PlantAssembly, site: Site) -> None:
    """A part of the spring, `change` of it, levels off as a hyperbolic tangent."""
    part = site["change"] * _stiffness(site)
    _element(assembly, site, SATURATING, part * site["deflection"], site["deflection"], -part)


def _act_exponential(assembly: PlantAssembly, site: Site) -> None:
    _element(assembly, site, SINH, site["change"] * _stiffness(site), site["deflection"], _CUT)


def _act_play(assembly: PlantAssembly, site: Site) -> None:
    """Softer by `change` within the play, smoothed; of full stiffness beyond it."""
    part = site["change"] * _stiffness(site)
    _element(assembly, site, SATURATING, -part * site["deflection"], site["deflection"], 0.0)


def _act_leaning(assembly: PlantAssembly, site: Site) -> None:
    """A cubic spring about a working point that a load has moved: k₃ (u + u₀)³ without what holds the load.

    Its tangent at the working point is the joint's stiffness: 3 k₃ u₀ u² + k₃ u³ come beside it.
    """
    cubic = site["change"] * _stiffness(site) / site["deflection"] ** 2
    _element(assembly, site, POLYNOMIAL, 3 * cubic * site["load"] * site["deflection"], cubic)


def _act_s_shaped(assembly: PlantAssembly, site: Site) -> None:
    """A part of the spring levels off, and a cubic one comes in at six of its deflections."""
    part, at = site["change"] * _stiffness(site), site["deflection"]
    _element(assembly, site, SATURATING, part * at, at, -part)
    _element(assembly, site, POLYNOMIAL, 0.0, part / (6 * at) ** 2)


def _act_gradual(assembly: PlantAssembly, site: Site) -> None:
    """Softer in the middle over three ranges of deflection, each five times the one before."""
    part = site["change"] * _stiffness(site) / 3
    for at in site["deflection"] * np.array([0.2, 1.0, 5.0]):
        _element(assembly, site, SATURATING, -part * at, at, 0.0)


def _act_rolling(assembly: PlantAssembly, site: Site) -> None:
    """Hertz's power of 1.5 both ways under a preload: softer until one side opens, stiffening beyond."""
    _element(assembly, site, HERTZ, site["change"] * _stiffness(site), site["deflection"])


def _act_stop(assembly: PlantAssembly, site: Site) -> None:
    """A second spring from a deflection on, both ways."""
    step, at = site["change"] * _stiffness(site), site["deflection"]
    _element(assembly, site, PIECEWISE, step, at, 0.0, 3 * at)


def _draw_leaning(stand: Stand, where: str, random: np.random.Generator) -> dict[str, float]:
    sign = 1.0 if random.uniform() < 0.5 else -1.0
    drawn = _drawing((0.2, 0.6), (0.5, 1.0))(stand, where, random)
    return {**drawn, "load": float(sign * random.uniform(0.3, 0.7))}


def _check_leaning(parameters: Parameters) -> str | None:
    """1 + 6 c l u + 3 c u² stays above 0 where 3 c l² < 1."""
    if 3 * parameters["change"] * parameters["load"] ** 2 > 0.95:
        return f"load = {parameters['load']:g} with change = {parameters['change']:g}, which turns unstable"
    return _checking(10.0)(parameters)


def _most(limit: float) -> Callable[[Parameters], float]:
    return lambda parameters: limit / max(abs(parameters["change"]), 1e-9)


def _form(
    form: str, says: str, source: str, act: Callable[[PlantAssembly, Site], None], *,
    change: tuple[float, float], deflection: tuple[float, float], most: float, means: str,
) -> Effect:  # fmt: skip
    return replace(
        OWN,
        form=form,
        says=says,
        source=source,
        units={"change": means, "deflection": "rad"},
        draw=_drawing(change, deflection),
        scaled=multiplied("change"),
        most=_most(most),
        check=_checking(most),
        act=act,
    )


CUBIC = _form(
    "cubic", "a spring with a cubic part, hardening without end",
    "Nayfeh and Mook, Nonlinear Oscillations, Wiley 1979, chapter 4 (Duffing)", _act_cubic,
    change=(0.2, 0.6), deflection=(0.5, 1.0), most=5.0, means="cubic over linear torque at the deflection",
)  # fmt: skip
WIND_UP = _form(
    "wind_up", "stiffness in three steps, as makers of harmonic drives give it",
    "Harmonic Drive AG, Engineering Data, K₁, K₂, K₃ by torque; Tuttle and Seering, IEEE Trans. Robotics and "
    "Automation 12 (1996) 368", _act_windup,
    change=(0.4, 1.2), deflection=(0.1, 0.3), most=6.0, means="last stiffness over the first, less 1",
)  # fmt: skip
LEVELLING = _form(
    "levelling", "a spring that softens: a part of it levels off",
    "softening as in Nayfeh and Mook, Nonlinear Oscillations, Wiley 1979, chapter 4, but bounded",
    _act_levelling,
    change=(0.3, 0.6), deflection=(0.2, 0.5), most=0.85, means="part of the stiffness that levels off",
)  # fmt: skip
EXPONENTIAL = _form(
    "exponential", "a spring whose stiffness grows exponentially",
    "stiffness that grows with the windup: Kircanski and Goldenberg, Int. J. Robotics Research 16 (1997) 214",
    _act_exponential,
    change=(0.3, 0.9), deflection=(0.4, 0.8), most=3.0, means="part of the stiffness that grows so",
)  # fmt: skip
PLAY = _form(
    "play", "softer about the middle: free play, smoothed, with a bearing beside it",
    "Nordin and Gutman, Automatica 38 (2002) 1633, on gears with backlash and their describing functions",
    _act_play,
    change=(0.2, 0.5), deflection=(0.05, 0.3), most=0.85, means="part of the stiffness missing in the middle",
)  # fmt: skip
S_SHAPED = _form(
    "s_shaped", "a spring that softens first and hardens then",
    "the sum of two that Nayfeh and Mook have (Nonlinear Oscillations, Wiley 1979, chapter 4)", _act_s_shaped,
    change=(0.3, 0.6), deflection=(0.1, 0.35), most=0.85, means="part of the stiffness that levels off",
)  # fmt: skip
STOP = _form(
    "stop", "a second spring that comes in at a deflection, both ways",
    "Shaw and Holmes, J. Sound and Vibration 90 (1983) 129, on piecewise linear oscillators", _act_stop,
    change=(0.5, 2.0), deflection=(0.2, 0.5), most=8.0, means="stiffness of the second spring over the first",
)  # fmt: skip
GRADUAL = _form(
    "gradual", "a spring that stiffens slowly, over decades of deflection, as teeth come to bear",
    "Tuttle and Seering (as wind_up), on teeth that come into mesh", _act_gradual,
    change=(0.3, 0.7), deflection=(0.05, 0.3), most=0.85, means="part of the stiffness missing in the middle",
)  # fmt: skip
ROLLING = _form(
    "rolling", "rolling contacts under a preload, which a hard blow takes off one side",
    "Johnson, Contact Mechanics, Cambridge 1985, chapter 4 (Hertz); Rigaud and Perret-Liaudet, J. Sound and "
    "Vibration 265 (2003) 289", _act_rolling,
    change=(0.5, 0.95), deflection=(0.04, 0.25), most=3.0, means="part of the stiffness that is of contacts",
)  # fmt: skip
LEANING: Effect = replace(
    CUBIC,
    form="leaning",
    says="a cubic spring about a point to which a load has moved it",
    source="Kovacic and Brennan, The Duffing Equation, Wiley 2011, chapter 8 (asymmetric)",
    units={**CUBIC.units, "load": "deflections to which the load has moved it"},
    draw=_draw_leaning,
    most=lambda parameters: min(
        4.0 / max(parameters["change"], 1e-9),
        0.9 / max(3 * parameters["change"] * parameters["load"] ** 2, 1e-9),
    ),
    check=_check_leaning,
    act=_act_leaning,
)

FORMS = (CUBIC, WIND_UP, PLAY, LEVELLING, EXPONENTIAL, LEANING, S_SHAPED, STOP, GRADUAL, ROLLING)
