"""Pictures one after the other as a film in a file: GIF, or H.264 in MP4."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

from flexmodal.errors import MissingExtra

if TYPE_CHECKING:
    from PIL.Image import Image

FILMS = (".gif", ".mp4")
_COLOURS = 128
_QUALITY = "20"
"""Constant rate factor of x264: 18 can hardly be told from the pictures, 23 is its own choice."""
_LEAST = 10
"""Pictures a second of an MP4 at least; slower ones are repeated, as not every player shows them."""


def refuse_without_encoder(kind: str) -> None:
    """Complain before pictures are taken, not after.

    Args:
        kind: ".gif" or ".mp4".

    Raises:
        MissingExtra: an MP4 without PyAV, or one whose FFmpeg has no encoder of H.264.
    """
    if kind != ".mp4":
        return
    try:
        import av
    except ImportError:
        raise MissingExtra("an .mp4 needs PyAV: pip install 'flexmodal[films]'; a .gif does not") from None
    if "libx264" not in av.codecs_available:
        raise MissingExtra("this PyAV was built without x264, the encoder of an .mp4; a .gif needs none")


def write_film(pictures: Sequence[Image], path: Path, kind: str, *, seconds: float, rounds: int = 1) -> None:
    """Write pictures as a film.

    Args:
        pictures: in order, all of one size.
        path: where to.
        kind: ".gif", which goes round for ever, or ".mp4".
        seconds: that all of them last [s].
        rounds: how often an MP4 shows them.
    """
    if kind == ".gif":
        one, *others = [picture.quantize(_COLOURS) for picture in pictures]
        times = {"duration": round(1000 * seconds / len(pictures)), "loop": 0}
        one.save(path, format="GIF", save_all=True, append_images=others, **times)
        return
    import av

    rate = Fraction(len(pictures) / seconds).limit_denominator(100)
    repeats = max(1, -(-_LEAST // rate))
    with av.open(str(path), "w", format="mp4", options={"movflags": "faststart"}) as film:
        stream = film.add_stream("libx264", rate=rate * repeats, options={"crf": _QUALITY})
        stream.pix_fmt = "yuv420p"  # which every player shows; it wants even sizes
        stream.width, stream.height = (side - side % 2 for side in pictures[0].size)
        for picture in [one for one in pictures for _ in range(repeats)] * rounds:
            film.mux(stream.encode(av.VideoFrame.from_image(picture)))
        film.mux(stream.encode())
