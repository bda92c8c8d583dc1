"""The documentation's site as it looks on a desk and on a telephone: docs/pictures/site.png.

Drawn from site/ as chromium shows it, the telephone's page in a frame of its width; run by `make pictures`,
after `make docs`.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from PIL import Image
from welcome_pictures import ROOT, save, screenshot

SITE = ROOT / "site"
DESK, TELEPHONE = (1280, 1100), (390, 844)
HEIGHT = 760


def on_a_telephone(page: Path, folder: Path) -> Image.Image:
    """A page in a frame as wide as a telephone: browsers without a screen make no window that narrow."""
    width, height = TELEPHONE
    frame = folder / f"{page.stem}_frame.html"
    style = f'width="{width}" height="{height}" style="border:0"'
    frame.write_text(
        f'<body style="margin:0"><iframe src="{page.as_uri()}" {style}></iframe>', encoding="utf-8"
    )
    return screenshot(frame, (500, height)).crop((0, 0, width, height))


def main() -> int:
    """Both side by side, as high as each other."""
    if not (SITE / "index.html").exists():
        print("site/ is not there: make docs", file=sys.stderr)
        return 1
    with tempfile.TemporaryDirectory() as scratch:
        desk = Path(scratch) / "desk.html"  # the picture comes beside the page: not into site/
        desk.write_text(f'<meta http-equiv="refresh" content="0; url={(SITE / "index.html").as_uri()}">')
        shown = [screenshot(desk, DESK), on_a_telephone(SITE / "tutorials" / "posture.html", Path(scratch))]
    scaled = [one.resize((round(one.width * HEIGHT / one.height), HEIGHT)) for one in shown]
    whole = Image.new("RGB", (sum(one.width for one in scaled) + 40, HEIGHT), "#c4c8cc")
    whole.paste(scaled[0], (0, 0))
    whole.paste(scaled[1], (scaled[0].width + 40, 0))
    save(whole, "site.png")
    return 0


if __name__ == "__main__":
    sys.exit(main())
