"""Datasets 58 of a file that belong to a campaign: ids known, directions among six, units SI."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from flexmodal.campaign.consistency import DIRECTIONS
from flexmodal.campaign.description.tested import NO_ROBOT, Tested
from flexmodal.campaign.uff.codes import EXPONENTS, FORCE, FRF, FUNCTIONS, QUANTITY_OF, TIME_RESPONSE, WORDS
from flexmodal.campaign.uff.header import Character, Header
from flexmodal.campaign.uff.scan import SHAPE, scan_uff
from flexmodal.campaign.uff.units import UNITS, says
from flexmodal.campaign.uff.values import UffRecord, read_values
from flexmodal.text.words import FaultList, listing


@dataclass(frozen=True, eq=False)
class Labelled:
    """A record whose posture, trial and points are known."""

    key: str
    """Its name in faults: `dataset 3`."""
    posture: int
    trial: int
    record: UffRecord

    @property
    def header(self) -> Header:
        """The header of the record."""
        return self.record.header

    @property
    def pair(self) -> tuple[int, int, int, int]:
        """Response and reference, point and direction each."""
        return (*self.header.response, *self.header.reference)


def read_records(
    file: Path, tested: Tested, wanted: Iterable[int], faults: FaultList, warnings: list[str]
) -> list[Labelled]:
    """Read the records of a file whose function type is wanted.

    Args:
        file: a UFF file.
        tested: what was tested.
        wanted: function types; others are left out with a warning.
        faults: where faults go.
        warnings: where warnings go.
    """
    content = scan_uff(file, faults)
    warnings += content.warnings
    modes = sum(one.kind == SHAPE for one in content.others)
    if modes and tested.robot != NO_ROBOT:
        said = f"{modes} dataset{'s' * (modes > 1)} 55 left out"
        warnings.append(f"{file}: {said}: the modes of a campaign are in modes.csv")
    named = _Naming(tested, faults, {})
    found: list[Labelled] = []
    left: dict[int, int] = {}
    odd: dict[str, list[int]] = {}
    with tempfile.TemporaryDirectory(prefix="flexmodal-") as folder:
        for dataset in content.datasets:
            header, key = dataset.header, f"dataset {dataset.number}"
            if header.function not in wanted:
                left[header.function] = left.get(header.function, 0) + 1
                continue
            ids, before = named.ids(header, dataset.number), len(faults.faults)
            _check_characters(header, key, faults, odd, dataset.number)
            record = read_values(dataset, Path(folder), faults)
            if ids is not None and record is not None and len(faults.faults) == before:
                found.append(Labelled(key, *ids, record))
    named.report()
    for kind, count in left.items():
        name = FUNCTIONS.get(kind, "function") + f" (type {kind})"
        warnings.append(f"{file}: {count} record{'s' * (count > 1)} left out: {name}")
    warnings += [f"{file}: {_numbers(numbers)}: {what}" for what, numbers in odd.items()]
    warnings += named.warnings(file)
    return found


@dataclass(frozen=True)
class _Naming:
    """Ids of records against those of the campaign; what is unknown is reported once each."""

    tested: Tested
    faults: FaultList
    unknown: dict[tuple[str, str, str], list[int]]

    @cached_property
    def points(self) -> frozenset[int]:
        """Ids of the campaign's."""
        return frozenset(point.id for point in self.tested.points)

    def ids(self, header: Header, number: int) -> tuple[int, int] | None:
        """Posture and trial of a record, or None where something in it is unknown.

        Args:
            header: of the record.
            number: which record of the file, for the faults.
        """
        posture = self._one("load case", header.load_case, [p.id for p in self.tested.postures], number)
        trial = self._one("version number", header.version, [t.id for t in self.tested.trials], number)
        sound = posture is not None and trial is not None
        for name, (node, direction) in (("response", header.response), ("reference", header.reference)):
            if node not in self.points:
                known = listing(str(point.id) for point in self.tested.points)
                self._note(f"{name} node", str(node), f"a point: {known}", number)
                sound = False
            if direction not in DIRECTIONS:
                self._note(f"{name} direction", str(direction), "±1 ±2 ±3 for ±x ±y ±z", number)
                sound = False
        return (posture, trial) if sound and posture is not None and trial is not None else None

    def _one(self, what: str, value: int, known: list[int], number: int) -> int | None:
        """The id; a record that leaves it at 0 belongs to the only one there is."""
        if value in known:
            return value
        if value == 0 and len(known) == 1:
            self._note(what, "0", "", number)
            return known[0]
        kind = "posture" if what == "load case" else "trial"
        self._note(what, str(value), f"the id of a {kind}: {listing(map(str, known))}", number)
        return None

    def _note(self, what: str, found: str, allowed: str, number: int) -> None:
        self.unknown.setdefault((what, found, allowed), []).append(number)

    def report(self) -> None:
        for (what, found, allowed), numbers in self.unknown.items():
            if allowed:
                self.faults.add(f"{_numbers(numbers)}: {what}", found, allowed)

    def warnings(self, file: Path) -> list[str]:
        return [
            f"{file}: {_numbers(numbers)}: {what} 0, taken for the only one of the campaign"
            for (what, _, allowed), numbers in self.unknown.items()
            if not allowed
        ]


def _numbers(numbers: list[int]) -> str:
    if len(numbers) == 1:
        return f"dataset {numbers[0]}"
    more = f" and {len(numbers) - 5} more" if len(numbers) > 5 else ""
    return f"datasets {', '.join(map(str, numbers[:5]))}{more}"


def _check_characters(
    header: Header, key: str, faults: FaultList, odd: dict[str, list[int]], number: int
) -> None:
    """Units from the record: data types, exponents and labels have to say the same, and SI."""
    parts: list[tuple[Character, tuple[int, ...], str]] = [
        (header.abscissa, (17,) if header.function == TIME_RESPONSE else (18,), "abscissa")
    ]
    if header.function == FRF:
        parts += [
            (header.numerator, tuple(QUANTITY_OF), "ordinate numerator"),
            (header.denominator, (FORCE,), "ordinate denominator"),
        ]
    elif header.function == TIME_RESPONSE:
        parts += [(header.numerator, (*QUANTITY_OF, FORCE), "ordinate numerator")]
    for character, codes, name in parts:
        unknown_axis = name == "abscissa" and character.code in (0, 1)
        code = codes[0] if unknown_axis else character.code
        if character.code not in codes and not unknown_axis:
            allowed = " or ".join(f"{code} {WORDS.get(code, '')}".strip() for code in codes)
            faults.add(f"{key}: {name} data type", str(character.code), allowed)
        if not says(character.unit, code):
            allowed = f"SI units: {UNITS[code][0]} for data type {code}, or no label"
            faults.add(f"{key}: unit of the {name}", repr(character.unit), allowed)
        _note_exponents(character, odd, number)


def _note_exponents(character: Character, odd: dict[str, list[int]], number: int) -> None:
    expected = EXPONENTS.get(character.code)
    length, force, temperature = character.exponents
    if expected and (length, force, temperature) not in ((0, 0, 0), (*expected, 0)):
        kind = f"type {character.code} ({WORDS.get(character.code, 'unknown')})"
        what = f"unit exponents {length} {force} {temperature} of {kind} are passed over"
        odd.setdefault(what, []).append(number)
