"""A gearbox as a whole: its ratio, its losses, its play and its compliance."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from gearblocks.blocks.lossy_gears import LossyGear
from gearblocks.blocks.springs import Lash
from gearblocks.language.block import Block
from gearblocks.language.contributions import Contribution, Parts
from gearblocks.language.fields import COMPLIANCE, Flange, exact, option, param
from gearblocks.language.heat import HEAT, HeatPort
from gearblocks.language.signals import Value
from gearblocks.language.watches import Watch

_LOSS = ("ratio", "efficiency", "bearing", "loss_table", "heat")
_LASH = ("k", "half_gap", "c", "contact_damping", "heat")


class Gearbox(Block):
    """A gearbox with losses, backlash and compliance: a LossyGear, and behind it a Lash, at b.

        a o---|| lossy
              ||---| |-/\\/\\/---o b        phi_a = ratio (phi_b - twist) about the housing

    Parts: gear, with the outputs torque, torque_a, loss_power and mode of `LossyGear`; lash, with twist and torque of `Lash`;
    so that paths read `box.gear.loss_power` and `box.lash.twist`. Give efficiency=(eta1, eta2) and bearing=(tau1, tau2), or
    loss_table; left out, it loses nothing. k and half_gap are those at b; without k it is rigid. Nothing in it has inertia:
    what turns is connected from outside. The composition of Modelica.Mechanics.Rotational.Components.Gearbox, whose b is
    twice half_gap.

    Example:
        rig = gb.Drivetrain("robot joint")
        motor, arm = rig.add("motor", gb.Inertia(J=1e-3)), rig.add("arm", gb.Inertia(J=2.0))
        box = rig.add("box", gb.Gearbox(ratio=50, efficiency=(0.9, 0.85), half_gap="0.02 deg", k=2e4, c=5.0))
        rig.chain(rig.add("drive", gb.Torque(tau=1.0)), motor, box, arm)
        print(gb.simulate(rig, t_end=0.2)["box.gear.loss_power"][-1])
    """

    a, b = Flange("driving side"), Flange("driven side")
    housing = Flange("housing", ground=True)
    ratio: float = exact("ratio phi_a/phi_b")
    efficiency: tuple[float, float] | None = param(
        "efficiencies (a drives, b drives)",
        default=None,
        many=True,
        le=1,
        belongs_to="loss",
        each=("efficiency where a drives", "efficiency where b drives"),
        positive=(0,),
    )
    bearing: tuple[float, float] | None = param(
        "bearing torques at a (a drives, b drives)",
        "N m",
        default=None,
        many=True,
        ge=0,
        belongs_to="loss",
        each=("bearing torque at a where a drives", "bearing torque at a where b drives"),
        symbol="T_b",
    )
    loss_table: tuple[tuple[float, ...], ...] | None = option(
        "losses by speed: rows of (abs(w_a), eta1, eta2, tau1, tau2)", default=None, many=True, belongs_to="loss"
    )
    k: Value | None = param("torsional stiffness at b", "N m/rad", default=None, gt=0, belongs_to=COMPLIANCE)
    half_gap: Value | None = param("half of the free play at b", "rad", default=None, ge=0, belongs_to="backlash")
    c: Value | None = param("torsional damping at b", "N m s/rad", default=None, ge=0, belongs_to="damping")
    contact_damping: str = option(
        "damping and gap: 'clipped', 'clipped_force' or 'always'", default="clipped", belongs_to="damping"
    )

    heat: HeatPort | None = HEAT

    def problems(self) -> Iterator[str]:
        """Those of its parts, and what needs compliance."""
        for name in ("half_gap", "c"):
            if self.k is None and getattr(self, name) is not None:
                yield f"{name} = {getattr(self, name)!r} needs k, the stiffness behind it"
        yield from self._gear().problems()
        if self.k is not None:
            yield from self._lash().problems()

    def without_effect(self, name: str) -> Block:
        """Without compliance the losses stay."""
        kept = {} if name != COMPLIANCE else {n: getattr(self, n) for n in _LOSS}
        changed = super().without_effect(name).changed(**kept)
        assert isinstance(changed, Block)
        return changed

    def would_show(self, effect: str) -> Iterator[Watch]:
        """That of the lash."""
        for watch in self._lash().would_show(effect) if self.k is not None else ():
            yield Watch(f"lash.{watch.output}", watch.words)

    def parts(self) -> Parts:
        """The gear, and the lash where it gives way."""
        flanges = {"a": ("gear", "a"), "b": ("gear", "b"), "housing": ("gear", "housing")}
        if self.k is None:
            return Parts({"gear": self._gear()}, (), flanges)
        blocks = {"gear": self._gear(), "lash": self._lash()}
        return Parts(blocks, ((("gear", "b"), ("lash", "a")),), flanges | {"b": ("lash", "b")})

    def physics(self, s: Any) -> Iterator[Contribution]:  # noqa: ARG002  its parts have physics
        """None of its own."""
        return iter(())

    def _gear(self) -> LossyGear:
        return LossyGear(**{name: self.__dict__[name] for name in _LOSS})

    def _lash(self) -> Lash:
        return Lash(**{name: self.__dict__[name] for name in _LASH})
