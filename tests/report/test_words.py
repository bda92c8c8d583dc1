"""Numbers in words."""

from flexmodal.report.words import error, figure, fixed, percent, size


def test_numbers():
    assert figure(2.0e5, "N·m/rad") == "2 × 10⁵ N·m/rad"
    assert figure(0.00001234) == "1.234 × 10⁻⁵"
    assert figure(-3.14159, "rad") == "−3.142 rad"
    assert figure(float("nan"), "kg") == "– kg"
    assert error(float("inf"), "kg") == "–"
    assert error(None) == "–"
    assert error(0.01234, "kg") == "0.012 kg"
    assert (size(0.05), size(12.0), size(None), size(float("nan"))) == ("0.0500", "12.0", "–", "–")
    assert (fixed(-1.25, 1), fixed(2.0, 1, "+"), fixed(None, 1), fixed(float("inf"), 0)) == (
        "−1.2", "+2.0", "–", "–",
    )  # fmt: skip


def test_parts_of_one_are_never_certain():
    assert (percent(0.999), percent(0.001), percent(0.934)) == ("> 99 %", "< 1 %", "93 %")
