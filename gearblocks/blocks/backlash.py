"""Backlash: dead zones g(x) with exact corners, as polynomials, smooth, or of many teeth; damping of impacts."""

from __future__ import annotations

from collections.abc import Iterator
from math import isfinite
from typing import Any

from gearblocks.geometry.backlash_fit import polynomial_fit
from gearblocks.geometry.spline_teeth import segments
from gearblocks.language.block import Effect
from gearblocks.language.contributions import Contribution, Switch
from gearblocks.language.fields import State, option, param
from gearblocks.language.signals import Value


class Backlash(Effect):
    """Dead zone of half width `half_gap` about zero deflection, in the unit of the deflection (m, or rad in a
    NonCircularGear).

        g(x) = x - b (x > b),  0 (abs(x) <= b),  x + b (x < -b)            b = half_gap: HALF the backlash

    law="exact" (default): the corners are exact and located.
    law="polynomial": g(x) = b sum c_j (x/b)^(2j - 1), j = 1, 2, ...; either coefficients=(c_1, c_2, ...), or degree: the
    plain least-squares fit over +-interval half gaps on a step of 0.01. It holds inside of the interval alone (leaving it
    is an event) and has false rest points inside the gap; papers use it. Damping then acts everywhere ("always").
    law="smooth": g(x) = x + (sqrt((x - b)^2 + w^2) - sqrt((x + b)^2 + w^2))/2 with w = width, smooth everywhere and
    rising; at most w/2 away from the corners' law (at the corners), w^2/(4 abs(x - b)) far from them. With clipped damping
    the ledger needs max_step of about w over the speed: where damping cancels the spring, nothing else asks for short steps.
    gaps=(b_1, ..., b_n) in place of half_gap: a gap of every tooth on the drive side, [coast_gaps] on the coast side
    (default: the same). Each tooth carries 1/n of k: g(x) = (sum of max(x - b_j, 0) - sum of max(-x - c_j, 0))/n.

    Example:
        gap = gb.Backlash(half_gap="30 um")
        pair = gb.GearMesh(teeth=(20, 30), external=True, module=2e-3, pressure_angle=0.35, k=1e8, c=500.0, backlash=gap)
    """

    half_gap: Value | None = param("half of the backlash", "m", default=None, ge=0, usual=1.0, of_deflection=True)
    law: str = option("form of the dead zone: 'exact', 'polynomial' or 'smooth'", default="exact")
    coefficients: tuple[Value, ...] | None = param(
        "coefficients of x, x^3, x^5, ... in half gaps",
        default=None,
        many=True,
        each=("coefficient of x^{odd} in half gaps",),
        symbol="g",
    )
    degree: int | None = option("degree of the fitted polynomial", default=None)
    interval: float = option("half width of the fit in half gaps", default=2.0)
    width: Value | None = param("rounding of the corners", "m", default=None, gt=0, of_deflection=True, symbol="delta")
    gaps: tuple[float, ...] | None = option("gap of each tooth on the drive side", "m", default=None, many=True)
    coast_gaps: tuple[float, ...] | None = option("gap of each tooth on the coast side", "m", default=None, many=True)

    def problems(self) -> Iterator[str]:
        """Unknown laws, and values that belong to another one."""
        if self.law not in ("exact", "polynomial", "smooth"):
            yield f"backlash.law = {self.law!r} is not available; give 'exact', 'polynomial' or 'smooth'"
        needs = {"coefficients": "polynomial", "degree": "polynomial", "width": "smooth"}
        for name, law in needs.items():
            if getattr(self, name) is not None and self.law != law:
                yield f"backlash.{name} belongs to law='{law}', but law = {self.law!r}"
        if (self.half_gap is None) == (self.gaps is None):
            yield "backlash: give either half_gap or gaps=(...), one of every tooth"
        if self.law == "smooth" and self.width is None:
            yield "backlash: law='smooth' needs width, the rounding of the corners"
        if self.law == "polynomial":
            yield from self._polynomial_problems()
        yield from self._gap_problems()

    def _polynomial_problems(self) -> Iterator[str]:
        if (self.coefficients is None) == (self.degree is None):
            yield "backlash: law='polynomial' needs either coefficients=(c1, c3, ...) or degree"
        if self.degree is not None and (type(self.degree) is not int or self.degree not in range(1, 32, 2)):
            yield f"backlash.degree = {self.degree!r} must be an odd whole number from 1 to 31"
        interval = self.interval
        if type(interval) not in (int, float) or not isfinite(interval) or not 1 < interval <= 100:
            yield f"backlash.interval = {interval!r} half gaps must be a number > 1 and <= 100"
        if self.half_gap == 0:
            yield "backlash.half_gap = 0: a polynomial over half gaps needs half_gap > 0"

    def _gap_problems(self) -> Iterator[str]:
        if self.gaps is None and self.coast_gaps is not None:
            yield "backlash.coast_gaps needs gaps, those of the drive side"
        if self.gaps is not None and self.law != "exact":
            yield f"backlash.gaps are exact corners; law = {self.law!r} needs half_gap"
        for name in ("gaps", "coast_gaps"):
            values = getattr(self, name)
            numbers = isinstance(values, tuple) and all(type(b) in (int, float) and 0 <= b <= 1e9 for b in values)
            if values is not None and not (numbers and values):
                yield f"backlash.{name} = {values!r:.80} must be a row of numbers >= 0 in m"
        if self.gaps is not None and self.coast_gaps is not None and len(self.gaps) != len(self.coast_gaps):
            yield f"backlash: {len(self.gaps)} gaps and {len(self.coast_gaps)} coast_gaps; give one of every tooth"

    # -- the law ------------------------------------------------------------------------------------------------------

    def deflection(self, s: Any, x: Any) -> Any:
        """g(x), the part of the deflection that loads the teeth."""
        import sympy as sp

        from gearblocks.laws.functions import DeadZone

        b = s.half_gap
        if self.gaps is not None:
            if s.reading:
                ahead = sp.Add(*(sp.Max(x - v, 0) for v in self.gaps))
                return (ahead - sp.Add(*(sp.Max(-x - v, 0) for v in self.coast_gaps or self.gaps))) / len(self.gaps)
            engaged, total, _ = self._rows(s, x)
            return (sp.Integer(1) / len(self.gaps)) * (engaged * x - total)
        if self.law == "polynomial":
            return b * sp.Add(*(c * (x / b) ** p for p, c in self._terms(s)))
        if self.law == "smooth":
            return x * (1 - 2 * b / (sp.sqrt((x - b) ** 2 + s.width**2) + sp.sqrt((x + b) ** 2 + s.width**2)))
        return DeadZone(x, b, 0)

    def potential(self, s: Any, x: Any) -> Any:
        """G(x), the integral of g from zero deflection."""
        import sympy as sp

        from gearblocks.laws.functions import DeadZone

        b = s.half_gap
        if self.gaps is not None:
            if s.reading:
                ahead = sp.Add(*(sp.Max(x - v, 0) ** 2 for v in self.gaps))
                return (ahead + sp.Add(*(sp.Max(-x - v, 0) ** 2 for v in self.coast_gaps or self.gaps))) / (
                    2 * len(self.gaps)
                )
            engaged, total, squares = self._rows(s, x)
            return (sp.Integer(1) / len(self.gaps)) * (engaged * x**2 / 2 - total * x + squares / 2)
        if self.law == "polynomial":
            return b**2 * sp.Add(*(c * (x / b) ** (p + 1) / (p + 1) for p, c in self._terms(s)))
        if self.law == "smooth":
            w = s.width

            def part(u: Any) -> Any:
                return u * sp.sqrt(u**2 + w**2) + w**2 * sp.asinh(u / w)

            return x**2 / 2 + (part(x - b) - part(x + b)) / 4 + part(b) / 2
        return DeadZone(x, b, -1)

    def side(self, s: Any, x: Any) -> Any:
        """-1 coast side, 0 no contact, +1 drive side."""
        import sympy as sp

        from gearblocks.laws.functions import ContactSide

        if self.gaps is None:
            return ContactSide(x, s.half_gap)
        if s.reading:
            return sp.Heaviside(x - min(self.gaps), 1) - sp.Heaviside(-x - min(self.coast_gaps or self.gaps), 1)
        return self._table(s, x, lambda rows: [(r > 0) - (r < 0) for r in rows[0]])

    def pushing_side(self, s: Any, x: Any) -> Any:
        """The sign of g: 0 where there is no contact, for damping that must not pull."""
        import sympy as sp

        return sp.sign(x) if self.law == "smooth" else self.side(s, x)

    def ends(self, s: Any) -> tuple[Any, Any]:
        """Deflections at which contact starts: on the coast side, on the drive side."""
        import sympy as sp

        if self.gaps is None:
            return -s.half_gap, s.half_gap
        return -sp.Float(min(self.coast_gaps or self.gaps), 17), sp.Float(min(self.gaps), 17)

    def engaged(self, s: Any, x: Any) -> Any:
        """Number of teeth that carry load, where each has its gap."""
        import sympy as sp

        assert self.gaps is not None
        if s.reading:
            ahead = sp.Add(*(sp.Heaviside(x - b, 1) for b in self.gaps))
            return ahead + sp.Add(*(sp.Heaviside(-x - b, 1) for b in self.coast_gaps or self.gaps))
        return self._rows(s, x)[0]

    def watches(self, s: Any, x: Any) -> Iterator[Contribution]:
        """Event functions where the law ceases to hold."""
        if self.law == "polynomial":
            yield Switch("beyond the polynomial, drive side", x - self.interval * s.half_gap)
            yield Switch("beyond the polynomial, coast side", -x - self.interval * s.half_gap)

    def _terms(self, s: Any) -> list[tuple[int, Any]]:
        """(power, coefficient) of the polynomial."""
        import sympy as sp

        if self.degree is not None:
            return [(2 * j + 1, sp.Float(c, 17)) for j, c in enumerate(polynomial_fit(self.degree, self.interval))]
        return [(2 * j + 1, c) for j, c in enumerate(s.coefficients)]

    def _rows(self, s: Any, x: Any) -> tuple[Any, Any, Any]:
        """Engaged teeth, the sum of their gaps and that of the squares, as tables over the deflection."""
        return (
            self._table(s, x, lambda rows: [abs(r) for r in rows[0]]),
            self._table(s, x, lambda rows: rows[1]),
            self._table(s, x, lambda rows: rows[2]),
        )

    def _table(self, s: Any, x: Any, pick: Any) -> Any:
        from gearblocks.language.signals import Table

        assert self.gaps is not None
        joints, rows = segments(self.gaps, self.coast_gaps or self.gaps)
        return s.tabled(Table(joints, pick(rows), "step"), x)


class HuntCrossley(Effect):
    """Contact damping that grows with the deflection: N = k g (1 + chi g'), g' the rate into contact, never pulling.

    chi = a/v0 with v0 the approach speed at the start of each contact, held as long as it lasts, and a from the
    restitution e: a (1 + e) = ln((1 + a)/(1 - e a)), so that a free body is thrown back with exactly e v0 (Hunt and Crossley
    1975, J. Appl. Mech. 42, 440-445; their a = 3 (1 - e)/2 is the limit for e near 1). Where N would pull it is 0. Takes
    the place of c; needs a gap with exact corners. A run that begins in contact has no damping until the teeth have
    parted once.

    Example:
        lash = gb.Lash(k=1e4, half_gap=0.01, contact_damping=gb.HuntCrossley(restitution=0.8))
    """

    restitution: Value = param("speed after an impact over the speed before", gt=0, le=1)
    slowness = State("1/v0 of the present contact", "s/m", symbol="gamma")
