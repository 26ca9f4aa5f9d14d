"""Operands of generated statements as values: vector[offset], printed once and never read back.

A role says what a name in a generated function stands for. Expressions report the roles that they read, targets those
that they write; signatures follow from both. Knows nothing of laws and of where the offsets come from.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum
from typing import Any, NamedTuple


class Role(Enum):
    """What a name in a generated function stands for, in the order of signatures; the values are the names in C."""

    PARAMETERS = "par"
    MODES_BEFORE = "before"
    MODES = "mode"
    TIME_TERMS = "time_terms"
    STATES = "y"
    DEPENDENT_COORDINATES = "loop"
    ANGLES = "phi"
    UNWRAPPED_ANGLES = "unwrapped"
    GAINS = "gain"
    VELOCITY_BIASES = "velocity_bias"
    ACCELERATION_BIASES = "acceleration_bias"
    SPEEDS = "w"
    ACCELERATIONS = "alpha"
    TORQUES = "torque"
    TORQUE_RATES = "torque_rate"
    DAMPING_ENTRIES = "damping"
    STIFFNESS_ENTRIES = "stiffness"
    FEEDBACK_SIGNALS = "feedback"
    FLANGE_TORQUES = "flange_tau"
    DIRECTION = "direction"
    DIRECTION_OF_DEPENDENT = "loop_direction"
    TIME = "t"
    INPUTS = "u"
    RATES = "dy"
    EVENT_FUNCTIONS = "s"
    ARGUMENTS = "x"
    FEEDBACK_ENCLOSURES = "signal"
    ENCLOSURES = "enclosure"
    GROUP_TORQUES = "group_torque"
    BOUNDS_OVER_PIECE = "bound"
    FEATURES = "feature"
    OUTPUTS = "out"
    ENERGIES = "energy"
    SCALES = "scale"
    LOWER_LIMITS = "lo"
    UPPER_LIMITS = "hi"
    KINEMATIC_TERMS = "kinematic_terms"
    DIAGONAL = "diag"
    LOWER = "lower"
    UPPER = "upper"
    SIGNAL_SLOPES = "slope"
    SIGNAL_CHANGES = "change"
    GROUP_SPEEDS = "speed"
    TORQUE_CHANGES = "torque_change"
    TORQUE_RATE_CHANGES = "torque_rate_change"
    COEFFICIENTS = "coef"
    ENTRIES = "entry"
    CONSTRAINT_FORCES = "constraint_force"
    FORCE_BOUNDS = "bounds"
    SKEWS = "skew"
    STEP = "g"
    FULL = "full"
    LAST = "last"
    LANE = "i"
    INSTANCE = "e"

    __hash__ = object.__hash__  # there is one object of each; that of Enum is many times as slow before Python 3.12

    def declaration(self, *, written: bool, real: str = "double") -> str:
        """Its C in a signature; real: the type of numbers."""
        if self in _KINDS:
            return f"const {_KINDS[self]} {self.value}"
        kind = "gb_enclosure" if self in _ENCLOSURES else real
        return f"{'' if written else 'const '}{kind} *restrict {self.value}"


_KINDS = {Role.STEP: "double", Role.FULL: "int", Role.LANE: "int", Role.INSTANCE: "int", Role.LAST: "int"}
"""Roles that are one number and no vector."""

_ENCLOSURES = (
    Role.ARGUMENTS, Role.FEEDBACK_ENCLOSURES, Role.ENCLOSURES, Role.GROUP_TORQUES, Role.BOUNDS_OVER_PIECE,
)  # fmt: skip
"""Vectors of enclosures."""

_BY_LANE = (Role.TIME_TERMS, Role.INPUTS)
"""Vectors with GB_LANES numbers for each offset."""

Roles = frozenset[Role]
NONE: Roles = frozenset()


@dataclass(frozen=True, slots=True)
class Index:
    """offset, or offset + e of instance e: a row of a table or the number of a switch."""

    offset: int | str
    instance: bool = False

    @property
    def written(self) -> Roles:
        """No vector: the operation says which."""
        return NONE

    def __str__(self) -> str:
        return f"{self.offset} + e" if self.instance else str(self.offset)


@dataclass(frozen=True, slots=True)
class Operand:
    """vector[offset]; instance: offset + e; lane: of lane i, in vectors that have lanes. STEP and FULL stand alone."""

    role: Role
    offset: int | str = 0
    instance: bool = False
    lane: bool = False

    @property
    def read(self) -> Roles:
        """What a function must be given where this stands."""
        also = {Role.INSTANCE: self.instance, Role.LANE: self.lane}
        return frozenset({self.role, *(role for role, used in also.items() if used)})

    @property
    def written(self) -> Roles:
        """The vector that an assignment changes."""
        return frozenset({self.role})

    def of_lane(self) -> Operand:
        """The same number, of lane i."""
        return replace(self, lane=True)

    def __str__(self) -> str:
        if self.role in _KINDS:
            return self.role.value
        return f"{self.role.value}[{self._index()}]"

    def _index(self) -> str:
        if self.role is Role.TIME:
            return "i"
        at = str(Index(self.offset, self.instance))
        if self.role not in _BY_LANE:
            return at
        wide = f"({at}) * GB_LANES" if self.instance else f"{at} * GB_LANES"
        return f"{wide} + i" if self.lane else wide


@dataclass(frozen=True, slots=True)
class Local:
    """A constant that a function defines for itself."""

    name: str
    read: Roles = NONE
    written: Roles = NONE

    def __str__(self) -> str:
        return self.name


@dataclass(frozen=True, slots=True)
class Choice:
    """(flag ? one : other)[offset]."""

    flag: str
    one: Role
    other: Role
    offset: str

    @property
    def written(self) -> Roles:
        """Both vectors."""
        return frozenset({self.one, self.other})

    def __str__(self) -> str:
        return f"({self.flag} ? {self.one.value} : {self.other.value})[{self.offset}]"


Target = Operand | Local | Choice | Index

_ALSO_READ = {
    "sign": {Role.MODES}, "table": {Role.MODES}, "band": {Role.MODES}, "spread_terms": {Role.COEFFICIENTS},
    "show": {Role.LAST},
}  # fmt: skip
_ALSO_WRITTEN = {
    "sign": {Role.LOWER_LIMITS, Role.UPPER_LIMITS},
    "table": {Role.LOWER_LIMITS, Role.UPPER_LIMITS},
    "band": {Role.LOWER_LIMITS, Role.UPPER_LIMITS},
    "spread": {Role.DIAGONAL, Role.LOWER, Role.UPPER},
    "spread_terms": {Role.DIAGONAL, Role.LOWER, Role.UPPER, Role.ENTRIES},
}


class Assignment(NamedTuple):
    """A statement to be printed: target op expr.

    op: "=", "+=", "-=", "max" (of the magnitude), "define" (a Local), "show" ("=" of an output; behind the last one that is
    wanted the function ends); of an Index: "sign", "table", "band" (limits of the event function of a switch), "spread",
    "spread_terms" (entries of a matrix).
    full: only where the ledger is wanted. factor: an argument that multiplies. flange: one whose gain does, and which
    the target belongs to. table: C name of the table of op "table".
    """

    target: Target
    op: str
    expr: Any
    full: bool = False
    factor: str = ""
    flange: str | None = None
    table: str = ""
    words: str = ""


@dataclass(frozen=True, slots=True)
class Statement:
    """target op rhs, for the template; op "share": a Local of another C type, `kind`. words: a comment behind it."""

    target: Target
    op: str
    rhs: str
    full: bool = False
    table: str = ""
    words: str = ""
    kind: str = ""

    @property
    def read(self) -> Roles:
        """What it reads besides the names in its right side."""
        indices = self.target.read - self.target.written if isinstance(self.target, Operand) else NONE
        return indices | _ALSO_READ.get(self.op, NONE) | ({Role.FULL} if self.full else NONE)

    @property
    def written(self) -> Roles:
        """What it changes."""
        return self.target.written | _ALSO_WRITTEN.get(self.op, NONE)
