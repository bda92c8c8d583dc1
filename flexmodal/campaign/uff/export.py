"""An analyser's export: a universal file without a campaign.toml, described from its own records."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from pathlib import Path

import numpy as np

from flexmodal.campaign.blow import Blow
from flexmodal.campaign.campaign import Campaign, default_band
from flexmodal.campaign.description.tested import (
    FORCE_TOO,
    NO_ROBOT,
    OUTPUT_ONLY,
    OUTPUT_SPECTRA,
    CampaignPoint,
    CampaignPosture,
    Tested,
)
from flexmodal.campaign.mode_table import ModeTable
from flexmodal.campaign.records import FrfRecords
from flexmodal.campaign.trial import Trial
from flexmodal.campaign.uff.codes import FORCE, FRF, TIME_RESPONSE
from flexmodal.campaign.uff.geometry import Geometry, geometry_of
from flexmodal.campaign.uff.header import Header
from flexmodal.campaign.uff.read_blows import read_time_uff
from flexmodal.campaign.uff.read_frfs import read_frf_uff
from flexmodal.campaign.uff.scan import scan_uff
from flexmodal.campaign.uff.shapes import mode_table, shapes_of
from flexmodal.errors import Fault, InvalidCampaign
from flexmodal.text.words import FaultList

SPECTRA = (2, 3)
"""Auto- and cross-spectra, by their function type."""
UNIVERSAL_SUFFIXES = (".uff", ".unv", ".uf", ".58")


def is_export(path: Path) -> bool:
    """Whether a path is that of a universal file, by its name."""
    return path.suffix.lower() in UNIVERSAL_SUFFIXES and path.is_file()


def read_export(file: Path) -> Campaign:
    """Read a universal file as a campaign: FRFs if it has any, else blows.

    Postures are its load cases, trials its versions (0 is taken for 1 where there is no other), points its
    nodes, at the places of its datasets 15 and 2411 [m]; modes are its datasets 55. What such a file does not
    say stays open: robot, links, angles, tip, and how many blows were averaged, so that coherence cannot be
    turned into noise.

    Raises:
        InvalidCampaign: with every fault.
    """
    faults: list[Fault] = []
    found = FaultList(file, faults)
    warnings = [f"{file}: no campaign.toml; described from the records alone"]
    content = scan_uff(file, found)
    headers = [one.header for one in content.datasets]
    used = [one for one in headers if one.function == FRF]
    has_frfs = bool(used)
    used = used or [one for one in headers if one.function == TIME_RESPONSE]
    geometry, shapes = geometry_of(content, found), shapes_of(content, found, warnings)
    if not used and not shapes and not faults:
        spectra = any(one.function in SPECTRA for one in headers)
        kind = OUTPUT_SPECTRA if spectra else "neither FRFs nor time histories nor modes"
        allowed = "datasets 58 of function type 4 or 1, or modes as datasets 55"
        found.add("", kind, f"{allowed}; {FORCE_TOO}" if spectra else allowed)
    if used and not has_frfs and not any(one.numerator.code == FORCE for one in used) and not faults:
        found.add("", OUTPUT_ONLY, FORCE_TOO)
    if faults:
        raise InvalidCampaign(faults)
    modes = mode_table(shapes, warnings, file)
    tested = _described(file, used, geometry, modes)
    turned = [node for node in geometry.turned if node in {point.id for point in tested.points}]
    if turned:
        named = ", ".join(map(str, turned[:5])) + (", …" if len(turned) > 5 else "")
        warnings.append(
            f"{file}: node {named}: directions are along a coordinate system of the file, which is not read"
        )
    frfs: FrfRecords | None = None
    blows: tuple[Blow, ...] = ()
    if has_frfs:
        frfs = read_frf_uff(file, tested, found, warnings)
    elif used:
        blows = read_time_uff(file, tested, found, warnings)
    if faults:
        raise InvalidCampaign(faults)
    return Campaign(
        title=tested.title,
        robot=tested.robot,
        band=default_band(frfs, blows),
        postures=tested.postures,
        points=tested.points,
        trials=_with_peaks(tested.trials, blows),
        frfs=frfs,
        blows=blows,
        modes=modes,
        path=file.parent,
        warnings=tuple(warnings),
        trace_lines=tested.trace_lines,
    )


def _described(file: Path, headers: list[Header], geometry: Geometry, modes: ModeTable | None) -> Tested:
    """What the records say of postures, points and trials; the reader refuses ids that cannot be."""
    of_modes: set[int] = set() if modes is None else set(modes.posture.tolist())
    cases = sorted({one.load_case for one in headers if one.load_case > 0} | of_modes) or [1]
    versions = sorted({one.version for one in headers if one.version > 0}) or [1]
    known = {node for one in headers for node, _ in (one.response, one.reference) if node > 0}
    nodes = sorted(known | (set() if modes is None else set(modes.response.tolist())))
    return Tested(
        title=file.name,
        robot=NO_ROBOT,
        band=None,
        postures=tuple(CampaignPosture(case, f"load case {case}", {}) for case in cases),
        points=tuple(
            CampaignPoint(node, f"node {node}", "unknown", geometry.nodes.get(node, (0.0, 0.0, 0.0)))
            for node in nodes
        ),
        trials=tuple(Trial(version, 1.0, 1, "unknown") for version in versions),
        trace_lines=through(geometry.lines, set(nodes)),
    )


def through(lines: Iterable[Sequence[int]], points: Collection[int]) -> tuple[tuple[int, ...], ...]:
    """Trace lines as far as something was measured along them: cut at nodes that are no points.

    Args:
        lines: nodes one after the other.
        points: those that are points.
    """
    found: list[tuple[int, ...]] = []
    for line in lines:
        stretch: list[int] = []
        for node in (*line, 0):
            if node in points:
                stretch.append(node)
                continue
            found += [tuple(stretch)] if len(stretch) > 1 else []
            stretch = []
    return tuple(found)


def _with_peaks(trials: tuple[Trial, ...], blows: tuple[Blow, ...]) -> tuple[Trial, ...]:
    """With the median peak of their blows, where there are blows."""
    peaks = {
        trial.id: [float(np.abs(blow.force).max()) for blow in blows if blow.trial == trial.id]
        for trial in trials
    }
    return tuple(
        Trial(trial.id, float(np.median(peaks[trial.id])), 1, trial.tip) if peaks[trial.id] else trial
        for trial in trials
    )
