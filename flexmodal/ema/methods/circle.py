"""Circle fit: near a resonance a mobility runs round a circle, quickest at the natural frequency.

For one mode, iω A′/(ω_n² − ω² + 2iζω_nω) lies exactly on a circle of diameter |A′|/(2ζω_n), and its
phase, which is half the angle seen from the centre, obeys tan θ = (ω_n² − ω²)/(2ζω_nω). So the traverse
rate |dθ/d(ω²)| is 1/(2ζω_n²) at ω_n, which is its maximum but for terms of the order ζ² [Hearne
2.41–2.44]. Other modes shift the
circle and hardly bend it, as long as they are far away.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.ema.measured import Measured
from flexmodal.ema.methods.noise import with_variance
from flexmodal.ema.methods.peak import Peak
from flexmodal.ema.methods.residue import from_multiplier, hidden_by_noise
from flexmodal.ema.methods.separable import solve_scaled
from flexmodal.ema.mode import ModeEstimate

FEWEST_POINTS = 6
"""Circle (3), orientation, frequency and damping are six numbers; fewer points would check nothing."""

_REACH = 2.0
"""The arc reaches this many half-bandwidths ζf to either side: 254° of the circle."""


@dataclass(frozen=True, eq=False)
class CircleFit:
    """One resonance of one FRF as a circle, with what checks it."""

    frequency: Float[np.ndarray, " point"]
    """Lines of the arc [Hz]."""
    arc: Complex[np.ndarray, " point"]
    """Measured mobility on them [m/(s·N)]."""
    centre: complex
    radius: float
    angle: Float[np.ndarray, " point"]
    """Seen from the centre, falling with frequency [rad]."""
    orientation: float
    """Angle of the resonance [rad]: that of the residue's multiplier A′."""
    mode: ModeEstimate
    traverse_rate: Float[np.ndarray, " gap"]
    """|dθ/d(ω²)| between neighbouring lines, θ half the angle seen from the centre [s²]."""
    half_power_damping: float | None
    """(ω_b − ω_a)/2ω_n of the points a quarter turn before and behind the resonance; None off the arc."""
    pair_damping: Float[np.ndarray, "before behind"]
    """Damping from every point before the resonance with every one behind it; alike if the mode is alone."""

    @property
    def traverse_damping(self) -> float:
        """1/(2ω_n² max|dθ/d(ω²)|), the rate taken over an eighth of the arc: coarse, and a check only."""
        omega = 2 * np.pi * self.frequency
        span = max(1, len(omega) // 8)
        fall = (self.angle[:-span] - self.angle[span:]) / 2 / (omega[span:] ** 2 - omega[:-span] ** 2)
        return float(1 / (2 * (2 * np.pi * self.mode.frequency) ** 2 * np.max(fall)))

    @property
    def roundness(self) -> float:
        """Root mean square distance from the circle, relative to its radius."""
        return float(np.sqrt(np.mean((np.abs(self.arc - self.centre) - self.radius) ** 2)) / self.radius)


def fit_circle(measured: Measured, peak: Peak) -> CircleFit | str:
    """Fit a circle to one peak of one FRF.

    Args:
        measured: a single FRF.
        peak: where; forced numbers are kept.

    Returns:
        The fit, or a sentence on why there is none.
    """
    mobility = with_variance(measured).to("mobility")
    half = _REACH * max(peak.width / 2, 1e-9)
    low, high = max(peak.low, peak.frequency - half), min(peak.high, peak.frequency + half)
    lines = (mobility.frequency >= low) & (mobility.frequency <= high)
    if np.count_nonzero(lines) < FEWEST_POINTS:
        return f"{np.count_nonzero(lines)} lines on the arc, fewer than {FEWEST_POINTS}; try least squares"
    arc, omega = mobility.value[lines, 0], mobility.omega[lines]
    variance = np.asarray(mobility.variance)[lines, 0]
    circle = _geometric_circle(arc, 1 / variance)
    if circle is None:
        return "the lines do not run round a circle"
    centre, radius = circle
    angle = np.unwrap(np.angle(arc - centre))
    turned = angle[0] - angle[-1]
    if turned < np.pi / 3:
        return f"the arc turns clockwise through {np.degrees(turned):.0f}°, too little for a resonance"
    found = _resonance(omega, angle, 1 / variance, peak)
    if found is None:
        return "the points do not run round the circle as one resonance does"
    orientation, natural, damping = found
    spread = _influence(arc, omega, centre, radius, found, variance, peak)
    multiplier = 4 * damping * natural * radius * np.exp(1j * orientation)
    mode = from_multiplier(natural, damping, multiplier, spread, float(2 * len(arc) - 6), "circle")
    if hidden := hidden_by_noise(mode):
        return hidden
    middle = np.diff(angle) / 2 / np.diff(omega**2)
    before, behind = _sides(omega, angle - orientation, natural)
    return CircleFit(
        frequency=omega / (2 * np.pi),
        arc=arc,
        centre=centre,
        radius=radius,
        angle=angle,
        orientation=orientation,
        mode=mode,
        traverse_rate=np.abs(middle),
        half_power_damping=_half_power(omega, angle - orientation, natural),
        pair_damping=_pairs(before, behind, natural),
    )


def _geometric_circle(arc: np.ndarray, weight: np.ndarray) -> tuple[complex, float] | None:
    """Least squared distances from the circle, by Gauss–Newton from the algebraic fit."""
    scale = float(np.max(np.abs(arc)))
    x, y, share = arc.real / scale, arc.imag / scale, np.sqrt(weight / np.max(weight))
    columns = np.stack([2 * x, 2 * y, np.ones_like(x)], axis=1) * share[:, None]
    solution, _, rank, _ = np.linalg.lstsq(columns, (x**2 + y**2) * share, rcond=1e-10)
    square = solution[2] + solution[0] ** 2 + solution[1] ** 2
    if rank < 3 or not square > 0:
        return None
    centre, radius = complex(solution[0], solution[1]), float(np.sqrt(square))
    for _ in range(30):
        away = arc / scale - centre
        distance = np.abs(away)
        if np.min(distance) <= 0 or not np.isfinite(radius):
            return None
        slopes = np.stack([away.real / distance, away.imag / distance, np.ones_like(distance)], axis=1)
        step = np.linalg.lstsq(slopes * share[:, None], (distance - radius) * share, rcond=1e-12)[0]
        centre, radius = centre + complex(step[0], step[1]), radius + step[2]
        if np.max(np.abs(step)) < 1e-13 * abs(radius):
            break
    if not 0 < radius < 1e3:
        return None
    return centre * scale, float(radius * scale)


def _resonance(
    omega: np.ndarray, angle: np.ndarray, weight: np.ndarray, peak: Peak
) -> tuple[float, float, float] | None:
    """Orientation, natural frequency and damping from the run of the angle, from the quickest gap on."""
    rate = -np.diff(angle) / np.diff(omega**2)
    smooth = np.convolve(rate, np.ones(3) / 3, mode="same") if len(rate) >= 8 else rate
    place = int(np.argmax(smooth))
    natural = float(np.sqrt((omega[place] ** 2 + omega[place + 1] ** 2) / 2))
    if peak.holds_frequency:
        natural = 2 * np.pi * peak.frequency
    damping = (
        peak.start_damping
        if peak.holds_damping
        else float(np.clip(1 / (natural**2 * smooth[place]), 1e-6, 0.9))
    )
    free = np.array([True, not peak.holds_frequency, not peak.holds_damping])
    orientation = float(np.interp(natural, omega, angle))
    share = np.sqrt(weight / np.max(weight))
    best = np.inf
    state, force = np.array([orientation, natural, damping]), 1e-3
    for _ in range(60):
        away, slopes = _angle_slopes(omega, angle, state)
        cost = float(np.sum((share * away) ** 2))
        columns = slopes[:, free] * share[:, None]
        matrix = columns.T @ columns
        step = np.zeros(3)
        step[free] = solve_scaled(
            matrix + force * np.diag(np.diag(matrix)), columns.T @ (share * away)[:, None]
        )[:, 0]
        trial = state + step
        if not (0 < trial[2] < 0.98 and trial[1] > 0):
            force *= 10
            continue
        better = float(np.sum((share * _angle_slopes(omega, angle, trial)[0]) ** 2))
        if better > cost:
            force *= 10
            if force > 1e8:
                break
            continue
        state, force, best = trial, max(force / 10, 1e-12), better
        if cost - better <= 1e-13 * cost + 1e-28:
            break
    if not np.isfinite(best) or not omega[0] * 0.9 <= state[1] <= omega[-1] * 1.1:
        return None
    return float(state[0]), float(state[1]), float(state[2])


def _angle_slopes(omega: np.ndarray, angle: np.ndarray, state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Angle less its model θ₀ − 2 atan((ω² − ω_n²)/(2ζω_nω)), and the model's slopes."""
    orientation, natural, damping = state
    below = 2 * damping * natural * omega
    tangent = (omega**2 - natural**2) / below
    turn = -2 / (1 + tangent**2)
    slope_natural = turn * (-2 * natural / below - tangent / natural)
    slope_damping = turn * (-tangent / damping)
    model = orientation - 2 * np.arctan(tangent)
    return angle - model, np.stack([np.ones_like(omega), slope_natural, slope_damping], axis=1)


def _influence(
    arc: np.ndarray,
    omega: np.ndarray,
    centre: complex,
    radius: float,
    found: tuple[float, float, float],
    variance: np.ndarray,
    peak: Peak,
) -> Float[np.ndarray, "4 4"]:
    """Covariance of natural frequency [rad/s], damping, ln|A′| and phase of A′, to first order in the noise.

    A disturbance of a point has a part along the radius, which moves the circle, and one along the circle,
    which with the moved centre changes the angle.
    """
    unit = np.exp(1j * np.angle(arc - centre))
    slopes = np.stack([unit.real, unit.imag, np.ones(len(arc))], axis=1)
    weight = (1 / variance)[:, None]
    circle = solve_scaled(slopes.T @ (weight * slopes), (weight * slopes).T)  # [centre x, y, radius; point]
    state = np.array(found)
    away, columns = _angle_slopes(omega, np.unwrap(np.angle(arc - centre)), state)
    free = np.array([True, not peak.holds_frequency, not peak.holds_damping])
    part = columns[:, free]
    answer = np.zeros((3, len(arc)))
    answer[free] = solve_scaled(part.T @ (weight * part), (weight * part).T)
    sideways = (
        unit.conj()[:, None] * (circle[0] + 1j * circle[1])[None, :]
    ).imag  # [angle's point, disturbed point]
    radial = np.concatenate([answer @ (-sideways / radius), circle[2:] / radius])
    tangential = np.concatenate([answer / radius, np.zeros((1, len(arc)))])
    # Order: orientation, natural, damping, ln radius; then to natural, damping, ln|A′|, orientation.
    _, natural, damping = found
    turn = np.array([[0, 1, 0, 0], [0, 0, 1, 0], [0, 1 / natural, 1 / damping, 1], [1, 0, 0, 0]])
    radial, tangential = turn @ radial, turn @ tangential
    rest = np.sum(((np.abs(arc - centre) - radius) ** 2 + (radius * away) ** 2) / variance)
    inflate = max(1.0, 2 * rest / max(2 * len(arc) - 6, 1))
    half = variance * inflate / 2
    return (radial * half) @ radial.T + (tangential * half) @ tangential.T


def _sides(omega: np.ndarray, angle: np.ndarray, natural: float) -> tuple[np.ndarray, np.ndarray]:
    """(ω, tan of half the angle from the resonance) of the points before it and behind it."""
    useful = (np.abs(angle) < 0.95 * np.pi) & (np.abs(angle) > 0.02)
    table = np.stack([omega, np.abs(np.tan(angle / 2))], axis=1)
    return table[useful & (omega < natural)], table[useful & (omega > natural)]


def _pairs(before: np.ndarray, behind: np.ndarray, natural: float) -> np.ndarray:
    """ζ = (ω_b² − ω_a²)/(2ω_n(ω_a tan½θ_a + ω_b tan½θ_b)), exact for viscous damping."""
    rise = behind[None, :, 0] ** 2 - before[:, None, 0] ** 2
    turn = before[:, None, 0] * before[:, None, 1] + behind[None, :, 0] * behind[None, :, 1]
    return rise / (2 * natural * turn)


def _half_power(omega: np.ndarray, angle: np.ndarray, natural: float) -> float | None:
    """From the two frequencies where half the angle is ±45°."""
    if angle[0] < np.pi / 2 or angle[-1] > -np.pi / 2 or np.any(np.diff(angle) >= 0):
        return None
    first, last = np.interp([-np.pi / 2, np.pi / 2], -angle, omega)
    return float((last - first) / (2 * natural))
