"""All sixteen kinds of dataset 58, written here by the book, come back as they were."""

import struct
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from flexmodal.campaign import Campaign, read_campaign
from flexmodal.campaign.write_campaign import campaign_toml

LINES = 7


def dataset(
    function: int, values: np.ndarray, axis: np.ndarray, *, double: bool, even: bool, order: str | None
) -> bytes:
    """One dataset by its FORTRAN formats; `order` is the byte order of a binary one."""
    kind = (5 if np.iscomplexobj(values) else 2) + (0 if not double else 1 if np.iscomplexobj(values) else 2)
    step = axis[1] - axis[0] if even else 0.0
    codes = (12, 13) if function == 4 else (0, 0)
    head = [
        "    -1",
        "    58" if order is None else f"    58b{1 if order == '<' else 2:6d}{2:6d}{11:12d}{0:12d}",
    ]
    head += ["NONE"] * 5
    head.append(f"{function:5d}{1:10d}{1:5d}{1:10d} {'tip':10s}{1:10d}{3:4d} {'wrist':10s}{2:10d}{-3:4d}")
    head.append(f"{kind:10d}{len(values):10d}{int(even):10d}{axis[0] * even:13.5e}{step:13.5e}{0.0:13.5e}")
    for code in (18, *codes, 0):
        head.append(f"{code:10d}{0:5d}{0:5d}{0:5d} {'NONE':20s} {'NONE':20s}")
    parts = [] if even else [axis]
    parts += [values.real, values.imag] if np.iscomplexobj(values) else [values]
    numbers = np.column_stack(parts).ravel()
    text = ("\n".join(head) + "\n").encode()
    if order is not None:
        return text + struct.pack(f"{order}{len(numbers)}{'d' if double else 'f'}", *numbers) + b"    -1\n"
    width = 20 if double else 13
    widths = [width] * (4 if double else 6)
    if double and not even:
        widths = [13, 20, 20] if np.iscomplexobj(values) else [13, 20, 13, 20]
    lines, row = [], ""
    for place, number in enumerate(numbers):
        size = widths[place % len(widths)]
        row += f"{number:{size}.{11 if size == 20 else 5}e}"
        if place % len(widths) == len(widths) - 1:
            lines.append(row)
            row = ""
    lines += [row] if row else []
    return text + ("\n".join(lines) + "\n    -1\n").encode()


@pytest.mark.parametrize(
    ("double", "even", "order"), list(product([False, True], [False, True], [None, "<", ">"]))
)
def test_real_and_complex(
    campaign: Campaign, tmp_path: Path, double: bool, even: bool, order: str | None
) -> None:
    rng = np.random.default_rng(0)
    value = rng.normal(size=LINES) + 1j * rng.normal(size=LINES)
    coherence = rng.uniform(0.1, 0.9, size=LINES)
    axis = 0.5 * np.arange(LINES) + (0.0 if even else 0.01 * np.arange(LINES) ** 2)
    style = {"double": double, "even": even, "order": order}
    content = dataset(4, value, axis, **style) + dataset(6, coherence, axis, **style)
    (tmp_path / "campaign.toml").write_text(campaign_toml(campaign), encoding="utf-8")
    (tmp_path / "frf.uff").write_bytes(content)
    frfs = read_campaign(tmp_path).frfs
    assert frfs is not None
    assert frfs.coherence is not None
    # Digits: six in ASCII single, twelve in ASCII double, 24 bits in binary single, all in binary double.
    tolerance = {(False, True): 6e-6, (True, True): 6e-12, (False, False): 1e-7, (True, False): 0.0}
    rtol = tolerance[double, order is None]
    np.testing.assert_allclose(frfs.value[0].real, value.real, rtol=rtol)
    np.testing.assert_allclose(frfs.value[0].imag, value.imag, rtol=rtol)
    np.testing.assert_allclose(frfs.coherence[0], coherence, rtol=rtol)
    np.testing.assert_allclose(frfs.frequency, axis, rtol=max(rtol, 6e-6 if order is None else 0), atol=1e-15)
