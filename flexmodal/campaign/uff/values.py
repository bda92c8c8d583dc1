"""The values of one dataset 58, read by pyuff and compared with what its header declares."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from flexmodal.campaign.uff.header import Header
from flexmodal.campaign.uff.scan import Dataset
from flexmodal.text.words import FaultList

_HUGE = {True: 1e60, False: 1e30}
"""No measurement in SI units is as large; bytes in the wrong order are. Double, single precision."""
_IDS = b"NONE".ljust(80) + b"\n"


@dataclass(frozen=True, eq=False)
class UffRecord:
    """One dataset 58 with its values."""

    number: int
    header: Header
    abscissa: np.ndarray
    value: np.ndarray


def read_values(dataset: Dataset, folder: Path, faults: FaultList) -> UffRecord | None:
    """Let pyuff read the values, and check that it read what stands there.

    Args:
        dataset: measured against its header already.
        folder: for scratch files.
        faults: where faults go.
    """
    import pyuff

    key, header = f"dataset {dataset.number}", dataset.header
    scratch = folder / f"{dataset.number}.uff"  # a new name each time: file systems flush what is truncated
    scratch.write_bytes(_canonical(dataset))
    try:
        with np.errstate(all="ignore"):
            found = pyuff.UFF(str(scratch)).read_sets()
    except Exception as error:  # pyuff raises nothing narrower
        faults.add(key, f"values that cannot be read ({str(error)[:60]})", "numbers in the declared columns")
        return None
    finally:
        scratch.unlink(missing_ok=True)
    if not isinstance(found, dict) or not _agrees(found, header):
        faults.add(key, "data that read differently from what the header declares", "a sound dataset 58")
        return None
    abscissa, value = np.asarray(found["x"], dtype=float), np.asarray(found["data"])
    if not np.all(np.isfinite(value)):
        line = int(np.argmin(np.isfinite(value)))
        faults.add(key, f"{value[line]} as value {line + 1}", "finite values")
    elif _is_garbled(value, header):
        order = "; is the byte order what the header says?" if dataset.binary else ""
        faults.add(
            key, f"values from {_smallest(value):.1e} to {np.abs(value).max():.1e}", f"SI values{order}"
        )
    elif not np.all(np.isfinite(abscissa)) or np.min(np.diff(abscissa)) <= 0:
        faults.add(key, "an abscissa that does not ascend", "ascending, finite values")
    else:
        return UffRecord(dataset.number, header, abscissa, value)
    return None


def _canonical(dataset: Dataset) -> bytes:
    """The dataset alone, its identification lines blanked: pyuff looks for tags in them too."""
    kind = f"    58{'b' if dataset.binary else ' '}"
    if dataset.binary:
        kind += f"{1 if dataset.little_endian else 2:6d}{2:6d}{11:12d}{len(dataset.data):12d}"
        kind += f"{0:6d}{0:6d}{0:12d}{0:12d}"
    head = b"    -1\n" + kind.ljust(80).encode() + b"\n" + 5 * _IDS
    return head + b"".join(line + b"\n" for line in dataset.header_lines) + dataset.data + b"    -1\n"


def _agrees(found: dict[str, Any], header: Header) -> bool:
    fields = {
        "func_type": header.function,
        "func_id": header.sequence,
        "ver_num": header.version,
        "load_case_id": header.load_case,
        "rsp_node": header.response[0],
        "rsp_dir": header.response[1],
        "ref_node": header.reference[0],
        "ref_dir": header.reference[1],
        "num_pts": header.count,
        "ord_data_type": header.value_type,
        "ordinate_spec_data_type": header.numerator.code,
        "orddenom_spec_data_type": header.denominator.code,
    }
    if any(found.get(name) != value for name, value in fields.items()):
        return False
    return len(found["data"]) == len(found["x"]) == header.count


def _is_garbled(value: np.ndarray, header: Header) -> bool:
    """Values larger than any measurement, or nearly all of them smaller."""
    huge = _HUGE[header.is_double]
    size = np.abs(value[value != 0])
    return size.size > 0 and bool(size.max() > huge or np.median(size) < 1 / huge)


def _smallest(value: np.ndarray) -> float:
    return float(np.abs(value[value != 0]).min())
