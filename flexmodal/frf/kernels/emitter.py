"""Writes straight-line code for complex algebra, real and imaginary parts apart.

A compiler turns a loop over independent lanes into vector instructions when its body is straight-line code on
real scalars. Nobody wants to write, or read, that body for six joints by hand; so the algebra is written
once, on `Number` objects, and each operation appends one line of Python. A number whose imaginary part is
known to be zero carries none, and costs half or a quarter.
"""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Number:
    """A scalar of the code to be: the names of its parts; no imaginary part where that is always zero."""

    re: str
    im: str | None = None


@dataclass
class Emitter:
    """Collects lines of code and counts what they cost."""

    lines: list[str] = field(default_factory=list)
    flops: int = 0
    """Additions, multiplications and divisions written so far; a fused multiply-add counts two."""
    _count: int = 0

    def scalar(self, expression: str) -> str:
        """One real assignment; returns the name it got."""
        name = f"t{self._count}"
        self._count += 1
        self.lines.append(f"{name} = {expression}")
        self.flops += sum(expression.count(f" {sign} ") for sign in "+-*/")
        return name

    def real(self, expression: str) -> Number:
        """A real number from an expression."""
        return Number(self.scalar(expression))

    def times(self, a: Number, b: Number) -> Number:
        """The product a·b."""
        if a.im is None and b.im is None:
            return self.real(f"{a.re} * {b.re}")
        if a.im is None:
            a, b = b, a
        if b.im is None:
            return Number(self.scalar(f"{a.re} * {b.re}"), self.scalar(f"{a.im} * {b.re}"))
        return Number(
            self.scalar(f"{a.re} * {b.re} - {a.im} * {b.im}"),
            self.scalar(f"{a.re} * {b.im} + {a.im} * {b.re}"),
        )

    def plus_times(self, c: Number | None, a: Number, b: Number) -> Number:
        """Sum c + a·b, in the order that fuses into multiply-adds; c may be none, for 0."""
        return self.times(a, b) if c is None else self._fused(c, a, b, "+", "-")

    def minus_times(self, c: Number, a: Number, b: Number) -> Number:
        """Difference c − a·b, likewise."""
        return self._fused(c, a, b, "-", "+")

    def _fused(self, c: Number, a: Number, b: Number, sign: str, other: str) -> Number:
        if a.im is None:
            a, b = b, a
        if a.im is None:
            return Number(self.scalar(f"{c.re} {sign} {a.re} * {b.re}"), c.im)
        start = ("" if sign == "+" else "-") if c.im is None else f"{c.im} {sign} "
        if b.im is None:
            return Number(
                self.scalar(f"{c.re} {sign} {a.re} * {b.re}"), self.scalar(f"{start}{a.im} * {b.re}")
            )
        return Number(
            self.scalar(f"{c.re} {sign} {a.re} * {b.re} {other} {a.im} * {b.im}"),
            self.scalar(f"{start}{a.re} * {b.im} {sign} {a.im} * {b.re}"),
        )

    def inverse(self, a: Number) -> tuple[Number, str]:
        """1/a and the name of |a|²."""
        assert a.im is not None
        square = self.scalar(f"{a.re} * {a.re} + {a.im} * {a.im}")
        over = self.scalar(f"1.0 / {square}")
        return Number(self.scalar(f"{a.re} * {over}"), self.scalar(f"-{a.im} * {over}")), square
