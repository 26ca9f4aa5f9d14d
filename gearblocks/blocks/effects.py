"""Effects of meshes and other compliant elements: excitation, friction, hysteresis; those of contact from `backlash`."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import zip_longest
from typing import Any

import numpy as np

from gearblocks.blocks.backlash import Backlash, HuntCrossley
from gearblocks.language.block import Effect, field_values
from gearblocks.language.fields import State, effect, option, param, signal
from gearblocks.language.signals import Signal, Table, Value, constant_value

__all__ = [
    "Backlash",
    "Fourier",
    "Harmonic",
    "HuntCrossley",
    "Hysteresis",
    "MeshLaw",
    "Profile",
    "Square",
    "Superposition",
    "ToothFriction",
]


_COSINE, _SINE = ("cosine coefficient of order {n}",), ("sine coefficient of order {n}",)


class Fourier(Effect):
    """Relative variation 1 + sum_j cos[j] cos(j theta) + sin[j] sin(j theta), j = 1, 2, ...

    theta is the mesh phase: of the teeth when driven_by="angle" (the law then derives from a potential and keeps the
    energy), or the integral of a frequency in rad/s (the papers' form, which feeds energy in and out); plus `phase`.

    Example:
        stiffness = gb.Fourier(cos=(0.2, 0.05), sin=(0.1,))
        law = gb.MeshLaw(k=1e8, c=500.0, stiffness_variation=stiffness)  # or a field of gb.GearMesh
    """

    cos: tuple[Value, ...] = param("cosine coefficients of orders 1, 2, ...", default=(), many=True, each=_COSINE)
    sin: tuple[Value, ...] = param("sine coefficients of orders 1, 2, ...", default=(), many=True, each=_SINE)
    driven_by: Signal = signal("'angle', or the frequency of the excitation", "rad/s", default="angle")
    phase: Value | None = param("phase added to theta", "rad", default=None)
    angle = State("integrated phase", "rad", symbol="theta")

    def value(self, s: Any, theta: Any) -> Any:
        """The sum alone, without the 1."""
        import sympy as sp

        orders = [(a, sp.cos, j) for j, a in enumerate(s.cos, 1)] + [(b, sp.sin, j) for j, b in enumerate(s.sin, 1)]
        return sp.Add(*(a * f(j * theta) for a, f, j in orders))

    def least(self) -> float:
        """The least value of the sum over a cycle, at the present values of Parameters."""
        a, b = ([constant_value(x) for x in row] for row in (self.cos, self.sin))
        order = max(len(a), len(b))
        slopes = np.zeros(2 * order + 1, dtype=complex)  # i times the derivative, a polynomial in exp(i theta)
        total = np.zeros(2 * order + 1, dtype=complex)
        for j, (real, imaginary) in enumerate(zip_longest(a, b, fillvalue=0.0), 1):
            total[order + j], total[order - j] = complex(real, -imaginary) / 2, complex(real, imaginary) / 2
            slopes[order + j], slopes[order - j] = j * total[order + j], -j * total[order - j]
        grid = 2 * np.pi * np.arange(64 * order + 1) / (64 * order + 1)
        theta = np.concatenate([grid, np.angle(np.roots(slopes[::-1]))]) if np.isfinite(slopes).all() else grid
        waves = np.exp(1j * np.outer(theta, np.arange(-order, order + 1)))
        return float((waves @ total).real.min()) if order else 0.0

    def amplitudes(self) -> float:
        """The sum of the sizes of all coefficients, which the sum of the waves never passes."""
        return sum(abs(constant_value(x)) for x in (*self.cos, *self.sin))


class Harmonic(Fourier):
    """Transmission error e = sum_j cos[j] cos(j theta) + sin[j] sin(j theta) in m; theta as for `Fourier`.

    Example:
        error = gb.Harmonic(sin=("5 um",))
        law = gb.MeshLaw(k=1e8, c=500.0, transmission_error=error)  # or a field of gb.GearMesh
    """

    cos: tuple[Value, ...] = param(
        "cosine coefficients of orders 1, 2, ...", "m", default=(), many=True, each=_COSINE, of_deflection=True
    )
    sin: tuple[Value, ...] = param(
        "sine coefficients of orders 1, 2, ...", "m", default=(), many=True, each=_SINE, of_deflection=True
    )


class Profile(Effect):
    """A Table over one cycle: a deviation relative to k (1: twice k), or a transmission error in m.

    table: x in cycles from 0 to 1, periodic. Driven like `Fourier`; its joints are located. Where an effect is wanted,
    a bare Table stands for Profile(table=...).

    Example:
        measured = gb.Table([0.0, 0.4, 0.5, 1.0], [0.1, 0.1, -0.1, 0.1], "cubic", periodic=True)
        stiffness = gb.Profile(table=measured)
        law = gb.MeshLaw(k=1e8, c=500.0, stiffness_variation=stiffness)  # or a field of gb.GearMesh
    """

    table: Table = option("points over one cycle, x from 0 to 1, periodic")
    driven_by: Signal = signal("'angle', or the frequency of the excitation", "rad/s", default="angle")
    phase: Value | None = param("phase added to theta", "rad", default=None)
    angle = State("integrated phase", "rad", symbol="theta")

    def problems(self) -> Iterator[str]:
        """A table that is no closed cycle, and steps over the angle."""
        if not isinstance(self.table, Table):
            yield f"table = {self.table!r:.80} must be a gb.Table over one cycle"
        elif not self.table.periodic or self.table.x[0] != 0 or self.table.x[-1] != 1:
            begin, end = (float(self.table.x[i]) for i in (0, -1))
            from_zero = "x" if begin == 0 else f"(x - {begin:g})"
            way = (
                f": write {from_zero} / {end - begin:.10g} for its x = {begin:g} .. {end:g}"
                if (begin, end) != (0, 1)
                else ""
            )
            yield f"the table must be periodic=True with x from 0 to 1 (cycles){way}"
        elif self.table.kind == "step" and self.driven_by == "angle":
            yield "a step table jumps, so it has no potential over the angle; give driven_by a frequency in rad/s"

    def value(self, s: Any, theta: Any) -> Any:
        """The table at the phase."""
        import sympy as sp

        return s.local("table", cycles=theta / (2 * sp.pi))

    def least(self) -> float:
        """The least value over a cycle."""
        x = np.linspace(0.0, 1.0, 64 * len(self.table.x) + 1)
        return float(min(np.min(self.table.y), np.min(self.table.values(x))))


def as_profile(value: Any) -> Any:
    """A bare Table as a Profile; everything else as it is."""
    return Profile(table=value) if isinstance(value, Table) else value


class Superposition(Effect):
    """Sum of two transmission errors, e = first + second, each with a phase of its own: that of the teeth and, driven by the
    frequency of a shaft, its run-out. `transmission_error=(a, b, c)` stands for a sum of sums.

    Example:
        teeth, run_out = gb.Harmonic(cos=(5e-6,)), gb.Harmonic(cos=(2e-5,), driven_by="300 rpm")
        error = gb.Superposition(first=teeth, second=run_out)  # as transmission_error=(teeth, run_out)
    """

    first: Harmonic | Profile | Superposition | None = effect("first error", default=None)
    second: Harmonic | Profile | Superposition | None = effect("second error", default=None)

    def problems(self) -> Iterator[str]:
        """A part that is missing, and what is wrong in the parts."""
        for name in ("first", "second"):
            part = self.__dict__[name]
            if part is None:
                yield f"transmission_error: the {name} of two errors is missing; give both, or the other one alone"
            elif isinstance(part, Effect):
                yield from part.problems()


def as_error(value: Any) -> Any:
    """A bare Table as a Profile, several errors as their sum; everything else as it is."""
    if isinstance(value, (tuple, list)) and value:
        first, *others = map(as_error, value)
        return Superposition(first=first, second=as_error(others)) if others else first
    return as_profile(value)


class Square(Effect):
    """Stiffness that alternates between one and two tooth pairs, mean 1.

    The upper value holds for the share contact_ratio - 1 of a cycle from theta = 0; upper - lower = 2 ripple.
    The jumps are located. Driven like `Fourier`; by angle it has no potential (jumps), so only a frequency is taken.

    Example:
        stiffness = gb.Square(ripple=0.3, contact_ratio=1.6, driven_by="500 rad/s")
        law = gb.MeshLaw(k=1e8, c=500.0, stiffness_variation=stiffness)  # or a field of gb.GearMesh
    """

    ripple: Value = param("half of the jump, relative to the mean", ge=0)
    contact_ratio: Value = param("transverse contact ratio, between 1 and 2", gt=1, lt=2, symbol="epsilon")
    driven_by: Signal = signal("the frequency of the excitation", "rad/s")
    phase: Value | None = param("phase added to theta", "rad", default=None)
    angle = State("integrated phase", "rad", symbol="theta")

    def problems(self) -> Iterator[str]:
        """A Square driven by the angle is refused."""
        if self.driven_by == "angle":
            yield "a Square variation jumps, so it has no potential over the angle; give driven_by a frequency in rad/s"

    def value(self, s: Any, theta: Any) -> Any:
        """The deviation from 1."""
        import sympy as sp

        share = s.contact_ratio - 1
        upper = sp.cos(theta - sp.pi * share) > sp.cos(sp.pi * share)
        return sp.Piecewise((2 * s.ripple * (1 - share), upper), (-2 * s.ripple * share, True))

    def least(self) -> float:
        """The lower value, at the present values of Parameters."""
        return -2 * constant_value(self.ripple) * (constant_value(self.contact_ratio) - 1)


class ToothFriction(Effect):
    """Coulomb friction of the teeth, mu times the mesh force.

    direction="geometry": friction across the line of action, with the lever arms of the contact. A pair enters at theta = 0
    at the start of the path of contact and travels one base pitch p_b per mesh cycle, xi = -g_f + p_b theta/(2 pi) from the
    pitch point. The one or two pairs in contact share N equally (Vaishya and Singh 2003, J. Mech. Des. 125, 634-643,
    doi 10.1115/1.1564063): together they are one equivalent pair with averaged arms. With rho_1 = r1 tan(a_w) + xi and
    rho_2 = r2 tan(a_w) - xi (internal: -r2 tan(a_w) - xi), speeds relative to the carrier,

        v = rho_1 w_1 + rho_2 w_2,    F = mu abs(N) sign(v) (its share),    torques -F rho_1, -F rho_2, F (rho_1 + rho_2)

    v changes sign at the pitch point (up to the vibration); the power -F v is never positive. The gears turn: at rest
    F jumps from one sign to the other and holds nothing, and the same at the pitch point where the pair vibrates hard
    enough to stick there: the run then stops and names the mesh. [transition]: sign(v) becomes
    v/sqrt(v^2 + transition^2), which passes through both. flank: the loaded one; with "coast" the pairs enter as theta
    falls (gear 1 turns backwards and drives). Valid for transverse contact ratios from 1 to 2; a helical pair counts by
    its transverse section. driven_by and phase as for `Fourier`.

    direction="square_wave": N (1 + mu wave) along the line of action on both bodies, wave = +1 or -1 from a signal (the
    form of papers; it may feed power in, which the ledger counts as supplied).

    Example:
        rubbing = gb.ToothFriction(mu=0.06, transition="10 mm/s")
        law = gb.MeshLaw(k=1e8, c=500.0, friction=rubbing)  # or a field of gb.GearMesh
    """

    mu: Value = param("coefficient of friction", ge=0)
    direction: str = option("'geometry' or 'square_wave'", default="geometry")
    wave: Signal | None = signal("direction of sliding, +1 or -1, for 'square_wave'", default=None, symbol="lambda")
    driven_by: Signal = signal("'angle', or the mesh frequency", "rad/s", default="angle")
    phase: Value | None = param("phase added to theta", "rad", default=None)
    flank: str = option("loaded flank: 'drive' or 'coast'", default="drive")
    transition: Value | None = param("sliding speed where friction takes hold", "m/s", default=None, gt=0, symbol="v_0")
    angle = State("integrated phase", "rad", symbol="theta")

    def problems(self) -> Iterator[str]:
        """Directions that do not exist, and a missing wave."""
        if self.direction not in ("geometry", "square_wave"):
            yield f"friction.direction = {self.direction!r} must be 'geometry' or 'square_wave'"
        if self.flank not in ("drive", "coast"):
            yield f"friction.flank = {self.flank!r} must be 'drive' or 'coast'"
        if (self.direction == "square_wave") != (self.wave is not None):
            yield "friction: direction='square_wave' and wave=... (a signal of +1 and -1) belong together"


class Hysteresis(Effect):
    """Inner friction of a shaft: a dry slider beside its spring, which slips at the torque `friction`.

    Alone, the slider joins both ends: the twist stays where it is until the rest of the torque exceeds friction. With
    stiffness it sits at the end of a spring of its own (the element of Jenkins, Brit. J. Appl. Phys. 13, 1962, 30-32, and of
    Iwan, J. Appl. Mech. 33, 1966, 893-900): beside a spring k the shaft has k + stiffness while the slider holds, and k
    while it slips. A cycle of the twist between -x and x loses 4 friction (x - friction/stiffness), without stiffness
    4 friction x, whatever the speed.

    Example:
        shaft = gb.Shaft(k=2e3, hysteresis=gb.Hysteresis(friction=1.5, stiffness=500.0))
    """

    friction: Value = param("torque at which the slider slips", "N m", gt=0)
    stiffness: Value | None = param("stiffness in series with the slider", "N m/rad", default=None, gt=0)
    force = State("torque of the slider", "N m", symbol="T_h")


class MeshLaw(Effect):
    """Law of the meshes of a composite: compliance and the effects that rest on it; the fields of GearMesh.

    Example:
        law = gb.MeshLaw(k="300 MN/m", damping_ratio=0.05, backlash=gb.Backlash(half_gap="20 um"))
        gear = gb.PlanetaryGear(
            z_sun=42, z_planet=18, z_ring=78, module=2e-3, pressure_angle=0.35, planet_inertia=1e-4, sun_mesh=law, ring_mesh=law
        )
    """

    face_width: Value | None = param("common face width", "m", default=None, gt=0, usual=5.0)
    profile_shift: tuple[Value, Value] | None = param(
        "profile shifts (x1, x2) over the module",
        default=None,
        many=True,
        each=("profile shift of gear 1 over the module", "profile shift of gear 2 over the module"),
    )
    addendum: Value | None = param("addendum over the module; absent: 1", default=None, gt=0)
    k: Value | None = param("mean stiffness along the line of action", "N/m", default=None, gt=0)
    stiffness: str | None = option("'iso6336': the stiffness of the standard", default=None)
    c: Value | None = param("damping along the line of action", "N s/m", default=None, ge=0)
    damping_ratio: Value | None = param("damping ratio on the bodies beside", default=None, ge=0)
    stiffness_variation: Fourier | Square | Profile | None = effect("variation of k", default=None, convert=as_profile)
    backlash: Backlash | None = effect("dead zone", default=None)
    contact_damping: str | HuntCrossley = option("damping and gap: as for GearMesh", default="clipped")
    transmission_error: Harmonic | Profile | Superposition | tuple[Harmonic | Profile, ...] | None = effect(
        "no-load transmission error, or several that add up", default=None, convert=as_error
    )
    friction: ToothFriction | None = effect("friction of the teeth", default=None)

    def values(self) -> dict[str, Any]:
        """The fields by name, as a GearMesh takes them."""
        return field_values(self)

    def shifted(self, phase: float) -> MeshLaw:
        """The law with every excitation over the mesh cycle ahead by a phase [rad]."""
        if phase == 0:
            return self
        moved = {}
        for name, value in self.values().items():
            if isinstance(value, Effect) and not _is_wave(value):
                moved[name] = _shifted(value, phase)
        return self.changed(**moved)  # type: ignore[no-any-return]


def _shifted(excitation: Effect, phase: float) -> Any:
    """An excitation, or every part of a sum, ahead by a phase; other effects as they are."""
    if isinstance(excitation, Superposition):
        return excitation.changed(**{name: _shifted(part, phase) for name, part in field_values(excitation).items()})
    if "phase" not in type(excitation).fields:
        return excitation
    given = excitation.__dict__["phase"]
    return excitation.changed(phase=phase if given is None else given + phase)


def _is_wave(value: Effect) -> bool:
    """Friction with a signal of its own, which no mesh phase moves."""
    return isinstance(value, ToothFriction) and value.direction == "square_wave"
