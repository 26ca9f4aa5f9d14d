"""Effects that meshes and other compliant elements may have: excitation here, those of contact from `gaps`."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from gearblocks.declare import Effect, State, option, param, signal
from gearblocks.gaps import Backlash
from gearblocks.signals import Table, Value

__all__ = ["Backlash", "Fourier", "Harmonic", "Profile", "Square"]


class Fourier(Effect):
    """Relative variation 1 + sum_j cos[j] cos(j theta) + sin[j] sin(j theta), j = 1, 2, ...

    theta is the mesh phase: of the teeth when driven_by="angle" (the law then derives from a potential and keeps the
    energy), or the integral of a frequency in rad/s (the papers' form, which feeds energy in and out); plus `phase`.
    """

    cos: tuple[Value, ...] = param("cosine coefficients of orders 1, 2, ...", default=(), many=True)
    sin: tuple[Value, ...] = param("sine coefficients of orders 1, 2, ...", default=(), many=True)
    driven_by: Any = signal("'angle', or the frequency of the excitation", "rad/s", default="angle")
    phase: Any = param("phase added to theta", "rad", default=None)
    angle = State("integrated phase", "rad")

    def value(self, s: Any, theta: Any) -> Any:
        """The sum alone, without the 1."""
        import sympy as sp

        orders = [(a, sp.cos, j) for j, a in enumerate(s.cos, 1)] + [(b, sp.sin, j) for j, b in enumerate(s.sin, 1)]
        return sp.Add(*(a * f(j * theta) for a, f, j in orders))


class Harmonic(Fourier):
    """Transmission error e = sum_j cos[j] cos(j theta) + sin[j] sin(j theta) in m; theta as for `Fourier`."""

    cos: tuple[Value, ...] = param("cosine coefficients of orders 1, 2, ...", "m", default=(), many=True)
    sin: tuple[Value, ...] = param("sine coefficients of orders 1, 2, ...", "m", default=(), many=True)


class Profile(Effect):
    """A Table over one cycle: a deviation relative to k (1: twice k), or a transmission error in m.

    table: x in cycles from 0 to 1, periodic. Driven like `Fourier`; its joints are located. Where an effect is wanted,
    a bare Table stands for Profile(table=...).
    """

    table: Table = option("points over one cycle, x from 0 to 1, periodic")
    driven_by: Any = signal("'angle', or the frequency of the excitation", "rad/s", default="angle")
    phase: Any = param("phase added to theta", "rad", default=None)
    angle = State("integrated phase", "rad")

    def problems(self) -> Iterator[str]:
        """A table that is no closed cycle, and steps over the angle."""
        if not isinstance(self.table, Table):
            yield f"table = {self.table!r:.80} must be a gb.Table over one cycle"
        elif not self.table.periodic or self.table.x[0] != 0 or self.table.x[-1] != 1:
            yield "the table must be periodic=True with x from 0 to 1 (cycles)"
        elif self.table.kind == "step" and self.driven_by == "angle":
            yield "a step table jumps, so it has no potential over the angle; give driven_by a frequency in rad/s"

    def value(self, s: Any, theta: Any) -> Any:
        """The table at the phase."""
        import sympy as sp

        return s.local("table", cycles=theta / (2 * sp.pi))


def as_profile(value: Any) -> Any:
    """A bare Table as a Profile; everything else as it is."""
    return Profile(table=value) if isinstance(value, Table) else value


class Square(Effect):
    """Stiffness that alternates between one and two tooth pairs, mean 1.

    The upper value holds for the share contact_ratio - 1 of a cycle from theta = 0; upper - lower = 2 ripple.
    The jumps are located. Driven like `Fourier`; by angle it has no potential (jumps), so only a frequency is taken.
    """

    ripple: Value = param("half of the jump, relative to the mean", ge=0)
    contact_ratio: Value = param("transverse contact ratio, between 1 and 2", gt=1, lt=2)
    driven_by: Any = signal("the frequency of the excitation", "rad/s")
    phase: Any = param("phase added to theta", "rad", default=None)
    angle = State("integrated phase", "rad")

    def problems(self) -> Iterator[str]:
        """The angle as a drive."""
        if self.driven_by == "angle":
            yield "a Square variation jumps, so it has no potential over the angle; give driven_by a frequency in rad/s"

    def value(self, s: Any, theta: Any) -> Any:
        """The deviation from 1."""
        import sympy as sp

        share = s.contact_ratio - 1
        upper = sp.cos(theta - sp.pi * share) > sp.cos(sp.pi * share)
        return sp.Piecewise((2 * s.ripple * (1 - share), upper), (-2 * s.ripple * share, True))
