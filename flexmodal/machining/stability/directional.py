"""Directional matrices of a milling cut: from the deflection of the tip to the force on it.

The force per axial depth on the tip, in the frame of the cut, is `W(φ) [r(t) − r(t − T)]`: the deflection now
against that of the tooth before. With the tooth's cutting edge along e, the outward normal n of the surface
it cuts and its path along v,

    v = (cos φ, −sin φ, 0)                              path of the tooth
    n = (sin φ sin κ, cos φ sin κ, −cos κ)              chip thickness is n · Δr
    e = (sin φ cos κ, cos φ cos κ, sin κ)               along the edge, to the spindle

one tooth at φ gives `−(K_t v + K_r n + K_a e) nᵀ / sin κ` while it is in the cut. κ = 90° is the end mill of
Altintas and Budak (Annals of the CIRP 44, 1995, 357), other κ the face mill of Altintas (JSME International
Journal C 44, 2001, 717). Everything is a trigonometric polynomial of degree 2 in φ, so its Fourier
coefficients over a tooth period are closed forms.
"""

from __future__ import annotations

import numpy as np
from jaxtyping import Complex, Float

from flexmodal.machining.cut import Cut

_DEGREE = 2
_ORDERS = np.arange(-_DEGREE, _DEGREE + 1)


def edge_vectors(
    cut: Cut, angle: Float[np.ndarray, " angle"]
) -> tuple[Float[np.ndarray, "angle 3"], Float[np.ndarray, "angle 3"], Float[np.ndarray, "angle 3"]]:
    """v, n and e of a tooth at each angle [rad].

    Args:
        cut: the cut.
        angle: of the edge [rad].
    """
    sine, cosine, none = np.sin(angle), np.cos(angle), np.zeros_like(angle)
    sk, ck = np.sin(cut.cutter.approach), np.cos(cut.cutter.approach)
    if ck < 1e-12:
        ck = 0.0
    path = np.stack([cosine, -sine, none], axis=-1)
    normal = np.stack([sine * sk, cosine * sk, none - ck], axis=-1)
    edge = np.stack([sine * ck, cosine * ck, none + sk], axis=-1)
    return path, normal, edge


def tooth_matrix(cut: Cut, angle: Float[np.ndarray, " angle"]) -> Float[np.ndarray, "angle 3 3"]:
    """Force per depth and per deflection of one tooth that is in the cut [N/m²].

    Args:
        cut: the cut.
        angle: of the tooth [rad].
    """
    return -_push(cut, angle, cut.force.specific)[:, :, None] * edge_vectors(cut, angle)[1][:, None, :]


def average(cut: Cut) -> Float[np.ndarray, "3 3"]:
    """W₀, the mean of W over a tooth period [N/m²]."""
    return harmonics(cut, np.array([0]))[0].real


def harmonics(cut: Cut, orders: np.ndarray, depth: float = 0.0) -> Complex[np.ndarray, "order 3 3"]:
    """Fourier coefficients W_k over a tooth period, W(t) = Σ W_k exp(2πi k t / T) [N/m²].

    Args:
        cut: the cut.
        orders: k.
        depth: axial depth over which a helix smears the force [m].
    """
    return _series(cut, tooth_matrix(cut, _samples()), orders, depth)


def static_force_harmonics(cut: Cut, orders: np.ndarray, depth: float) -> Complex[np.ndarray, "order 3"]:
    """Fourier coefficients over a tooth period of the force of the undisturbed cut on the tip [N].

    Needs `feed_per_tooth`; chip thickness is feed × sin φ × sin κ, edge forces act all through the cut.

    Args:
        cut: the cut.
        orders: of the tooth-passing frequency.
        depth: axial depth [m].
    """
    angle = _samples()
    feed = cut.engagement.feed_per_tooth or 0.0
    thickness = (feed * np.sin(angle) * np.sin(cut.cutter.approach))[:, None]
    force = -_push(cut, angle, cut.force.specific) * thickness - _push(cut, angle, cut.force.edge)
    return depth * _series(cut, force, orders, depth)


def at(cut: Cut, angle: Float[np.ndarray, " angle"], depth: float = 0.0) -> Float[np.ndarray, "angle 3 3"]:
    """W of the whole cutter when its first tooth's tip stands at `angle` [N/m²].

    With a helix, the mean over the depth: higher up the edge lags by 2 z tan(helix) / diameter.

    Args:
        cut: the cut.
        angle: of the first tooth [rad].
        depth: axial depth [m].
    """
    lag = helix_lag(cut, depth)
    if lag == 0:
        inside = (_turned(cut, angle) >= cut.engagement.entry) & (_turned(cut, angle) <= cut.engagement.exit)
        each = tooth_matrix(cut, _turned(cut, angle).ravel()).reshape(*inside.shape, 3, 3)
        return np.sum(each * inside[..., None, None], axis=0)
    return window_mean(cut, angle - lag, lag)


def window_mean(cut: Cut, start: Float[np.ndarray, " angle"], width: float) -> Float[np.ndarray, "angle 3 3"]:
    """Mean of the straight cutter's W from each start angle on over a width [rad], exactly.

    Args:
        cut: the cut.
        start: where the window begins [rad].
        width: of the window [rad].
    """
    coefficients = np.fft.fft(tooth_matrix(cut, _samples()), axis=0) / len(_samples())
    total = np.zeros((len(start), 3, 3))
    first = np.floor((start.min() - cut.engagement.exit) / (2 * np.pi)) - 1
    last = np.ceil((start.max() + width + 2 * np.pi - cut.engagement.entry) / (2 * np.pi)) + 1
    for tooth in range(cut.cutter.teeth):
        begin = start + 2 * np.pi * tooth / cut.cutter.teeth
        for turn in 2 * np.pi * np.arange(first, last + 1):
            low = np.maximum(begin, cut.engagement.entry + turn)
            high = np.minimum(begin + width, cut.engagement.exit + turn)
            inside = high > low
            if np.any(inside):
                total[inside] += _integral(coefficients, low[inside], high[inside])
    return total / width


def helix_lag(cut: Cut, depth: float) -> float:
    """How far the edge lags at the top of the cut behind its tip [rad].

    Args:
        cut: the cut.
        depth: axial depth [m].
    """
    return 2 * depth * float(np.tan(cut.cutter.helix)) / cut.cutter.diameter


def chip_axes(cut: Cut) -> int:
    """How many of x, y, z change the chip: x and y of an end mill, all three of a face mill."""
    return 2 if np.cos(cut.cutter.approach) < 1e-12 else 3


def _push(cut: Cut, angle: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Force of the tooth on the work per depth: the components along v, n, e over sin κ."""
    vectors = edge_vectors(cut, angle)
    total = sum(part * vector for part, vector in zip(force, vectors, strict=True))
    return np.asarray(total) / np.sin(cut.cutter.approach)


def _samples() -> np.ndarray:
    """Angles that determine a trigonometric polynomial of degree 2."""
    return 2 * np.pi * np.arange(2 * _DEGREE + 1) / (2 * _DEGREE + 1)


def _turned(cut: Cut, angle: np.ndarray) -> np.ndarray:
    """Angle of every tooth, between 0 and a turn."""
    pitch = 2 * np.pi * np.arange(cut.cutter.teeth) / cut.cutter.teeth
    return np.mod(angle[None, :] + pitch[:, None], 2 * np.pi)


def _series(cut: Cut, sampled: np.ndarray, orders: np.ndarray, depth: float) -> np.ndarray:
    """N/2π ∫ f(φ) exp(−ikNφ) dφ from entry to exit, times what a helix leaves of it."""
    coefficients = np.fft.fft(sampled, axis=0) / len(sampled)
    begin, end = cut.engagement.entry, cut.engagement.exit
    rate = _ORDERS[None, :] - cut.cutter.teeth * orders[:, None]
    middle, half = (begin + end) / 2, (end - begin) / 2
    integral = 2 * half * np.exp(1j * rate * middle) * np.sinc(rate * half / np.pi)
    smear = cut.cutter.teeth * orders * helix_lag(cut, depth) / 2
    integral *= (cut.cutter.teeth / (2 * np.pi) * np.exp(-1j * smear) * np.sinc(smear / np.pi))[:, None]
    return np.tensordot(integral, coefficients[_ORDERS], axes=1)


def _integral(coefficients: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """∫ of the trigonometric polynomial between the limits."""
    middle, half = (low + high) / 2, (high - low) / 2
    parts = 2 * half * np.exp(1j * _ORDERS[:, None] * middle) * np.sinc(_ORDERS[:, None] * half / np.pi)
    return np.tensordot(parts.T, coefficients[_ORDERS], axes=1).real
