"""Striking: all the blows of one posture, as the analyser records them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from threading import Lock

import numpy as np
from jaxtyping import Float

from flexmodal.campaign import CampaignPoint, CampaignPosture, Trial
from flexmodal.rig.analyser import Analyser
from flexmodal.rig.blow import Strike, strike
from flexmodal.rig.effects import Stand
from flexmodal.rig.integration.linear import Outputs, records
from flexmodal.rig.integration.nonlinear import fine_records
from flexmodal.rig.plant.build import Hidden, build, sensors
from flexmodal.rig.plant.plant import Plant
from flexmodal.rig.sensing import Sensor

FORCE_NOISE = 0.3
"""Noise of the force cell over its record, relative to that of the accelerometers over theirs."""
QUIET_CHANNEL = 0.1
"""Part of the noise that does not follow a channel's own record but all of them: the amplifier's."""


@dataclass(frozen=True)
class Conduct:
    """How the tester works."""

    noise: float = 0.01
    """White noise of each channel: standard deviation over the root mean square of its record."""
    scatter: float = 1.0
    """Multiple of the usual scatter of the blows; 0 strikes the same blow each time."""
    seed: int = 0


@dataclass(frozen=True, eq=False)
class Struck:
    """Records of one posture."""

    force: Float[np.ndarray, "trial reference point average sample"]
    """[N]"""
    response: Float[np.ndarray, "trial reference point average axis sample"]
    """[m/s²]"""


def strike_posture(
    stand: Stand,
    posture: CampaignPosture,
    hidden: Sequence[Hidden],
    conduct: Conduct,
    *,
    trials: Sequence[Trial] | None = None,
    advance: Callable[[], None] = lambda: None,
) -> Struck:
    """Simulate every blow of one posture: the accelerometer moves from point to point.

    Args:
        stand: robot, true parameters and plan.
        posture: where it stands.
        hidden: what is put in.
        conduct: noise, scatter and seed; the blows are the same whatever is hidden.
        trials: some of the plan's, or all.
        advance: called once for each point.
    """
    plan = stand.plan
    chosen = plan.trials if trials is None else trials
    linear = all(effect.linear for effect, _ in hidden)
    mounted = sensors(stand, hidden, posture)
    shared = None if any(s.weighs for s in mounted.values()) else build(stand, posture, hidden)
    averages = max(trial.averages for trial in chosen)
    shape = (len(chosen), len(plan.references), len(plan.points), averages)
    force = np.zeros((*shape, plan.analyser.samples))
    response = np.zeros((*shape, len(plan.axes), plan.analyser.samples))
    if shared is not None and linear:
        groups = [(shared, list(plan.points))]
    else:
        groups = [
            (shared or build(stand, posture, hidden, (point.name, mounted[point.name])), [point])
            for point in plan.points
        ]
    place = 0
    for plant, points in groups:
        strikes = [_strikes(stand, posture, point, chosen, averages, conduct) for point in points]
        f, y = _record(stand, plant, points, mounted, strikes, linear)
        for number in range(len(points)):
            force[:, :, place] = f[number].reshape(len(chosen), len(plan.references), averages, -1)
            response[:, :, place] = y[number].reshape(*shape[:2], averages, len(plan.axes), -1)
            place += 1
            advance()
    if conduct.noise > 0:
        for number, trial in enumerate(chosen):
            random = np.random.default_rng([conduct.seed, 2, posture.id, trial.id])
            _add_noise(force[number], response[number], conduct.noise, random)
    return Struck(force, response)


def _strikes(
    stand: Stand, posture: CampaignPosture, point: CampaignPoint, trials: Sequence[Trial], averages: int,
    conduct: Conduct,
) -> list[tuple[Strike, tuple[int, int]]]:  # fmt: skip
    """Blows by trial, reference and average; each drawn from a stream of its own."""
    analyser = stand.plan.analyser
    blows = []
    for trial in trials:
        for reference in stand.plan.references:
            random = np.random.default_rng(
                [conduct.seed, 1, posture.id, point.id, trial.id, reference[0], reference[1] + 3]
            )
            for _ in range(averages):
                blow = strike(
                    trial.force_peak, trial.tip, analyser.trigger, analyser.interval, conduct.scatter, random
                )
                blows.append((blow, reference))
    return blows


def reference_rows(
    stand: Stand, plant: Plant, strikes: Sequence[tuple[Strike | None, tuple[int, int]]]
) -> Float[np.ndarray, "blow dof"]:
    """Rows along which the blows push, where and as they truly fell.

    Args:
        stand: the true robot and its plan.
        plant: in its posture.
        strikes: each with the point and direction it was aimed at; None for one that went where it was aimed.
    """
    rows = []
    for blow, (number, direction) in strikes:
        point = stand.plan.point(number)
        place, way = np.array(point.xyz), point.way(direction, plant.orientation(point.link))
        if blow is not None:
            place, way = place + blow.offset, blow.tilt @ way
        rows.append(plant.row(point.link, place, way))
    return np.array(rows)


def response_rows(
    stand: Stand, plant: Plant, point: CampaignPoint, sensor: Sensor
) -> Float[np.ndarray, "axis dof"]:
    """Rows along which a sensor truly measures.

    Args:
        stand: the true robot and its plan.
        plant: in its posture.
        point: that carries the sensor.
        sensor: as it truly is.
    """
    axes, place = plant.orientation(point.link), np.array(point.xyz) + sensor.offset
    return np.array(
        [
            plant.row(point.link, place, sensor.direction(axes, point.way(axis, axes)))
            for axis in stand.plan.axes
        ]
    )


def _record(
    stand: Stand,
    plant: Plant,
    points: Sequence[CampaignPoint],
    mounted: Mapping[str, Sensor],
    strikes: Sequence[Sequence[tuple[Strike, tuple[int, int]]]],
    linear: bool,
) -> tuple[np.ndarray, np.ndarray]:
    """Force [point, blow, sample] and response [point, blow, axis, sample] of points that share a plant."""
    analyser = stand.plan.analyser
    flat = [blow for some in strikes for blow in some]
    blows, each = [blow for blow, _ in flat], len(strikes[0])
    pushed = reference_rows(stand, plant, flat)
    rows = np.repeat([response_rows(stand, plant, p, mounted[p.name]) for p in points], each, axis=0)
    column = plant.input_column(pushed)
    direct = np.einsum("bd,bcd->bc", np.linalg.solve(plant.mass, pushed.T).T, rows)
    delay = np.repeat([mounted[point.name].delay for point in points], each)
    outputs = Outputs(plant.output_row(rows), direct, delay)
    if linear:
        y = records(plant.state_matrix, column, outputs, blows, analyser)
    else:
        sensor = mounted[points[0].name]
        repeats = len(stand.plan.postures) * len(stand.plan.points)
        fine = fine_records(plant, column, outputs, rows[0], blows, analyser, repeats=repeats)
        np.clip(fine, -sensor.range, sensor.range, out=fine)
        y = analyser.sampled(fine, analyser.weights(sensor.delay), 0, analyser.samples)
    gain = np.repeat([mounted[point.name].gain for point in points], each)
    y = y * gain[:, None, None]
    for number, point in enumerate(points):
        mine = slice(number * each, (number + 1) * each)
        y[mine] = mounted[point.name].filtered(y[mine], analyser.rate)
    f = force_records(blows, analyser)
    return f.reshape(len(points), each, -1), y.reshape(len(points), each, len(stand.plan.axes), -1)


def force_records(blows: Sequence[Strike], analyser: Analyser) -> Float[np.ndarray, "blow sample"]:
    """What the force channel records, through the same filter as the others [N].

    Args:
        blows: pulses of the hammer.
        analyser: filter and samples.
    """
    last = max(blow.start + blow.duration for blow in blows)
    grid = int(np.ceil(last / analyser.step)) + 1
    times = np.arange(grid) * analyser.step
    fine = np.array([blow.force(times) for blow in blows])
    count = min(analyser.samples, -(-(grid + analyser.reach) // analyser.oversampling) + 1)
    out = np.zeros((len(blows), analyser.samples))
    out[:, :count] = analyser.sampled(fine, analyser.weights(), 0, count)
    return out


def _add_noise(force: np.ndarray, response: np.ndarray, level: float, random: np.random.Generator) -> None:
    own = np.sqrt(np.mean(response**2, axis=-1, keepdims=True))
    everywhere = np.sqrt(np.mean(response**2))
    response += level * np.hypot(own, QUIET_CHANNEL * everywhere) * random.standard_normal(response.shape)
    cell = FORCE_NOISE * level * np.sqrt(np.mean(force**2, axis=-1, keepdims=True))
    force += cell * random.standard_normal(force.shape)


def h1(struck: Struck) -> tuple[np.ndarray, np.ndarray]:
    """H1 = G_fy/G_ff and coherence, [trial, reference, point, axis, line], from the blows of each trial."""
    f = np.fft.rfft(struck.force, axis=-1)[..., None, :]
    y = np.fft.rfft(struck.response, axis=-1)
    cross = np.sum(np.conj(f) * y, axis=3)
    power, moved = np.sum(np.abs(f) ** 2, axis=3), np.sum(np.abs(y) ** 2, axis=3)
    with np.errstate(divide="ignore", invalid="ignore"):
        coherence = np.abs(cross) ** 2 / (power * moved)
    return cross / power, np.nan_to_num(coherence)


def each_posture(
    stand: Stand,
    hidden: Sequence[Hidden],
    conduct: Conduct,
    workers: int = 1,
    advance: Callable[[], None] = lambda: None,
) -> Iterator[tuple[CampaignPosture, Struck]]:
    """Strike the postures of the plan, in their order; as many side by side as there are workers.

    Whatever is drawn is drawn from a stream of its own for each posture, so that it does not matter who
    strikes it when. Threads do: the long loops leave the interpreter alone.

    Args:
        stand: the true robot and its plan.
        hidden: effects put in.
        conduct: noise, scatter and seed.
        workers: postures struck side by side.
        advance: called after each posture.
    """
    postures = stand.plan.postures
    if workers == 1:
        for posture in postures:
            yield posture, strike_posture(stand, posture, hidden, conduct, advance=advance)
        return
    lock = Lock()

    def tell() -> None:
        with lock:
            advance()

    def strike_one(posture: CampaignPosture) -> Struck:
        return strike_posture(stand, posture, hidden, conduct, advance=tell)

    with ThreadPoolExecutor(min(workers, len(postures))) as pool:
        yield from zip(postures, pool.map(strike_one, postures), strict=True)
