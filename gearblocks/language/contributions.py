"""Contributions: what the `physics` of a block yields, from inertias and forces to switched constraints and the ledger.

Each is one term of M(q) v' = f(t, q, v, u), a constraint, an event function, an output or an energy. A further kind is a class
here, a check (laws/checks.py), a part of the traversal (laws/law.py) and its physics (laws/derivation.py). Knows nothing of
blocks, trains or sympy.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

from gearblocks.errors import arguments_told
from gearblocks.language.tidy import Tidy


@arguments_told
@dataclass(frozen=True, slots=True)
class Body(metaclass=Tidy):
    """An inertia at a flange: J [kg m2], or the mass [kg] of a slider."""

    flange: Any
    J: Any


@arguments_told
@dataclass(frozen=True, slots=True)
class Force(metaclass=Tidy):
    """A generalised force along a deflection: every flange gets the torque -force * d deflection / d phi (virtual work).

    Factors of angles in a deflection are taken as they are, floats too; what is left where floats cancel (1e-14 of their
    sizes, as of three cosines 120 degrees apart) counts as 0. Two deflections that differ by less are the same.
    """

    deflection: Any
    force: Any


@arguments_told
@dataclass(frozen=True, slots=True)
class Potential(metaclass=Tidy):
    """An energy [J] of the flange angles: every flange gets the torque -d energy / d phi."""

    energy: Any


@arguments_told
@dataclass(frozen=True, slots=True)
class Acts(metaclass=Tidy):
    """The torque tau [N m] that the block exerts ON the flange."""

    flange: Any
    tau: Any


@arguments_told
@dataclass(frozen=True, slots=True)
class Tie(metaclass=Tidy):
    """A rigid constraint: `zero` stays 0.

    Linear in the flange angles with exact ratios; or, where it moves with time, with states or not linearly with angles,
    solved for a flange that it contains linearly by itself (phi_b - F(phi_a)). Then it must be smooth twice over.
    inverse: (another flange, a function that returns the relation with that one linearly by itself, phi_a - F^-1(phi_b)),
    for trains in which something else moves or holds the first one.
    rates: (speed, acceleration) of that flange, where they are given beside its angle instead of derived from it.
    """

    zero: Any
    inverse: tuple[Any, Callable[[], Any]] | None = None
    rates: tuple[Any, Any] | None = None


@arguments_told
@dataclass(frozen=True, slots=True)
class Motion(metaclass=Tidy):
    """A prescribed motion by speed: `zero`, linear in the flange speeds with the factors 1 and -1, stays zero. The rest must be
    continuous."""

    zero: Any


@arguments_told
@dataclass(frozen=True, slots=True)
class Start(metaclass=Tidy):
    """The start value of a state of the block, computed from angles, time and parameters at the start."""

    state: Any
    value: Any


@arguments_told
@dataclass(frozen=True, slots=True)
class Rate(metaclass=Tidy):
    """The time derivative of a state of the block."""

    state: Any
    expr: Any


@arguments_told
@dataclass(frozen=True, slots=True)
class Hold(metaclass=Tidy):
    """A state that stays as it is until `when` comes to 1, or to -1, at an event; it then takes `value` of that instant.

    when: an expression of conditions (the side of a contact, say), -1, 0 or 1. inverse_speed: the value is one over a speed.
    It is 0 where there is none: what the switch of `when` reads rested on its limit as the step began, or the speed is rounding
    beside the largest of the train.
    """

    state: Any
    value: Any
    when: Any
    inverse_speed: bool = False


@arguments_told
@dataclass(frozen=True, slots=True)
class Switch(metaclass=Tidy):
    """A named located switch: mode `high` where surface >= 0, else `low`; located only while `when` is not zero.

    Conditions written with Piecewise, Abs, sign, Min, Max or Heaviside are located without one; a Switch gives them a
    name and the values shown in the events. The events name the block and the switch, or the block alone when the name
    is empty (a mode of the block as a whole, such as its contact).
    """

    name: str
    surface: Any
    when: Any = 1
    low: float = 0.0
    high: float = 1.0


@arguments_told
@dataclass(frozen=True, slots=True)
class Stick(metaclass=Tidy):
    """A switched constraint along a slip, linear in the flange speeds with constant factors: dry friction, or a lock.

    A force > 0 drives the slip up: every flange gets the torque force * d slip / d w. While stuck the slip is exactly 0
    and the constraint force stays in [-limit, limit], or in limit = (lower, upper) (sympy.oo: without limit); while it slides,
    the force against the slip is `sliding` (default: limit; a pair: while slip > 0, while slip < 0), which may contain
    sympy.Abs(slip). engaged <= 0: free. An unlimited lock closes on a speed difference by a plastic impact; `impulse`: a
    state of the block that keeps it [N m s]. Loss, events and modes come by themselves, see Symbols.stick.
    """

    name: str
    slip: Any
    limit: Any
    sliding: Any = None
    engaged: Any = 1
    impulse: Any = None


@arguments_told
@dataclass(frozen=True, slots=True)
class Stop(metaclass=Tidy):
    """A unilateral constraint: the gap, linear in the flange angles with constant factors, stays >= 0.

    It closes by an impact with Newton's restitution (rate after = -restitution * rate before) and stays closed while it
    is pressed. impulse: a state of the block that keeps the last impulse [N m s]; impacts: one that counts them.
    """

    name: str
    gap: Any
    restitution: Any
    impulse: Any = None
    impacts: Any = None


@arguments_told
@dataclass(frozen=True, slots=True)
class LossyTie(metaclass=Tidy):
    """A rigid constraint with losses in proportion to its constraint force, and stuck at rest.

    tie: the speed that stays 0, linear in the flange speeds; its force F is Symbols.stick("tie"). slip: the speed along
    which the loss acts. With d = sign(slip) and m = d F + rest the force lost is d (share m + rest), against the slip:
    (share, rest) = `driving` where m >= 0, else `coasting` (both may contain sympy.Abs(slip)). What enters is (1 + share) m;
    where the two leave a gap (rest of `driving` < -d F < rest of `coasting`) nothing enters, where they overlap both hold
    and the present one stays. At rest it is stuck while its force lies between the losses of either direction; see
    Symbols.stick("loss").
    """

    tie: Any
    slip: Any
    driving: Any
    coasting: Any


@arguments_told
@dataclass(frozen=True, slots=True)
class Shows(metaclass=Tidy):
    """An output of the block."""

    name: str
    expr: Any
    unit: str = "1"
    words: str = ""


@arguments_told
@dataclass(frozen=True, slots=True)
class Energy(metaclass=Tidy):
    """Entry of the ledger: stored energy [J] and lost power [W]. What neither explains counts as supplied."""

    stored: Any = None
    loss: Any = None


Contribution: TypeAlias = (
    Body
    | Force
    | Potential
    | Acts
    | Tie
    | Motion
    | Rate
    | Start
    | Hold
    | Switch
    | Stick
    | Stop
    | LossyTie
    | Shows
    | Energy
)


@arguments_told
@dataclass(frozen=True)
class Parts(metaclass=Tidy):
    """Composition of a composite block: blocks by name, links between (name, flange) pairs, and its own flanges."""

    blocks: Mapping[str, Any]
    links: tuple[tuple[tuple[str, str], tuple[str, str]], ...]
    flanges: Mapping[str, tuple[str, str]]
