"""The tour, as `make demo` runs it."""

import json
import re
import xml.etree.ElementTree as ElementTree

import numpy as np
from PIL import Image


def test_demo(shell, tmp_path):
    ran = shell("demo", "--out", "tour", timeout=300)
    assert (ran.status, ran.err) == (0, "")
    names = ["frf_before_after.png", "frf_before_after.svg", "six_link.html", "ur5.html"]
    assert sorted(path.name for path in (tmp_path / "tour").iterdir()) == ["diagnosis", *names]
    for name in names:
        assert f"wrote {tmp_path / 'tour' / name}\n" in ran.out
    for word in ("Fanuc S-360", "frequency [Hz]", "damping ratio", "Six-link planar arm", "converged"):
        assert word in ran.out
    start, printed, found = (
        float(re.search(rf"{label}\s+(\S+)", ran.out)[1])
        for label in (r"brought to the target", "in this model", "best posture found here")
    )
    assert found <= printed < start
    with Image.open(tmp_path / "tour" / names[0]) as image:
        assert np.mean(np.asarray(image.convert("L")) < 200) > 0.005
    assert ElementTree.parse(tmp_path / "tour" / names[1]).getroot().tag.endswith("svg")
    page = (tmp_path / "tour" / names[2]).read_text(encoding="utf-8")
    assert not re.search(r"(?:src|href)\s*=\s*[\"']?\s*(?:https?:)?//", page)
    verdict = json.loads((tmp_path / "tour" / "diagnosis" / "diagnosis.json").read_text(encoding="utf-8"))
    assert verdict["verdict"]["effects"] == [["link_flexibility", "link_2"]]
    assert re.search(r"found\s+link_flexibility at link_2", ran.out)
    assert f"wrote {tmp_path / 'tour' / 'diagnosis' / 'report.html'}\n" in ran.out
    again = shell("demo", "--out", "tour")
    again.refused(names[0], "--force")
