"""Names of symbols as papers have them: a letter, a number, the part of the train it belongs to, dots.

Knows nothing of how a name is shown.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, final

GREEK = {
    "alpha": "α", "beta": "β", "gamma": "γ", "delta": "δ", "epsilon": "ε", "zeta": "ζ", "eta": "η", "theta": "θ",
    "vartheta": "ϑ", "kappa": "κ", "lambda": "λ", "mu": "μ", "nu": "ν", "xi": "ξ", "rho": "ρ", "sigma": "σ", "tau": "τ",
    "phi": "φ", "chi": "χ", "psi": "ψ", "omega": "ω", "Omega": "Ω", "Delta": "Δ",
}  # fmt: skip

_FIELDS = {
    "half_gap": "b", "exponent": "n", "damping_ratio": "ζ", "radius": "r", "wheel_radius": "r", "driven_by": "ω", "phase": "ϑ",
    "teeth": "z", "module": "m", "pressure_angle": "α", "helix_angle": "β", "r_base": "r", "coeffs": "c",
    "ripple": "δ", "ratio": "i", "cos": "a", "sin": "a", "mass": "m", "capacity": "C", "profile_shift": "X",
    "face_width": "B", "efficiency": "η", "stiffness": "k", "friction": "M", "restitution": "e", "addendum": "h",
    "gain": "K", "throttle": "u", "sliding": "C", "w": "ω", "law": "F", "stiffness_variation": "k", "transmission_error": "e",
    "torque_map": "T",
}  # fmt: skip
"""Letters of fields that do not declare their own."""
_ALONG = {"T": "F", "ω": "v", "θ": "x"}
"""Letters of sliders."""
_FROM_ZERO = ("coeffs",)  # rows whose first entry belongs to the power 0
_ODD = ("coefficients",)  # rows of odd powers
_WORDS = {"torque": "T", "torque_variation": "ε", "speed": "ω", "radius": "r", "frequency": "f"}
_DEFINED = {
    "k_t": ("k", ""), "k_iso": ("k", "iso"), "m_e": ("m", "e"), "J_e": ("J", "e"), "sign_g": ("sgn g", ""),
    "side_N": ("sgn N", ""), "g_f": ("g", "f"), "p_b": ("p", "b"), "two_pairs": ("n", "2"),
    "epsilon_alpha": ("ε", "α"),
}  # fmt: skip
_IN_EFFECT = {
    "transmission_error": "e", "friction": "f", "slip": "s", "tyre": "s", "first": "a", "second": "b", "windage": "w",
    "churning": "o",
}  # fmt: skip


INDEX = "i"
"""The index of alike parts (families.py)."""


@final
@dataclass(frozen=True, slots=True)
class Name:
    """letter: one, Greek or Latin, or a word; number: what stands at its foot; owner: part of the train; dots: how often it is
    differentiated in time."""

    letter: str
    number: str = ""
    owner: str = ""
    dots: int = 0

    def rate(self, dots: int = 1) -> Name:
        """The name of its derivative in time."""
        return replace(self, dots=self.dots + dots)

    def difference(self) -> Name:
        """The name of a small deviation of it."""
        return replace(self, letter=f"Δ{self.letter}")

    def change(self) -> Name:
        """The name of a small change of it, as in a partial derivative."""
        return replace(self, letter=f"∂{self.letter}")

    @property
    def is_of_a_case(self) -> bool:
        """Whether it stands for cases that were lifted out of an equation, beside which they are written."""
        return self.letter in ("p", "f") and self.number.isdigit()

    @property
    def is_word(self) -> bool:
        """Whether the letter is a word, which stands upright."""
        return len(self.letter.lstrip("Δ∂")) > 1


def of_shared(name: str) -> Name:
    """A Parameter or an Input, by the name that the user gave it."""
    return Name(_WORDS[name]) if name in _WORDS else plain(name)


def of_field(field: str, owner: str, symbol: str = "", *, slides: bool = False, varies: bool = False) -> Name:
    """A number of a block: `field` with the effect before it and its place in a row. symbol: as its field declares it;
    slides: of a spring between sliders, say; varies: as the mean of what varies."""
    *effects, last = field.split(".")
    match = re.fullmatch(r"(\w+?)(?:\[(\d+)\])?", last)
    word, place = (match[1], match[2]) if match else (last, None)
    own = plain(symbol) if symbol else Name(_FIELDS[word]) if word in _FIELDS else plain(word)
    letter = _ALONG.get(own.letter, own.letter) if slides else own.letter
    number = "" if place is None else str(2 * int(place) + 1 if word in _ODD else int(place) + (word not in _FROM_ZERO))
    if word == "sin":
        number = f"s{number}"
    number = _of_effects(effects) + (own.number or own.owner) + number
    if word == "k" and varies:
        number = "0"
    return Name(letter, number, owner)


def of_state(state: str, owner: str, symbol: str = "", *, slides: bool = False) -> Name:
    """A state of a block: `state` with the effect before it. symbol: as it declares it; slides: of a slider."""
    *effects, last = state.split(".")
    name = plain(symbol or last)
    return Name(
        _ALONG.get(name.letter, name.letter) if slides else name.letter,
        _of_effects(effects) + (name.number or name.owner),
        owner,
    )


def _of_effects(effects: Iterable[str]) -> str:
    """What stands at the foot of a symbol for the effects that it is of."""
    return "".join(_IN_EFFECT.get(effect, "") for effect in effects)


def of_defined(name: str, owner: str, slides: bool = False) -> Name:
    """A symbol that a law defines; slides: of a spring between sliders."""
    base = name.rstrip("'")
    dots = len(name) - len(base)
    base = base.split(".")[-1]
    if slides:
        base = {"theta": "x", "T": "F"}.get(base, base)
    parsed = plain(base)
    letter, number = _DEFINED.get(base) or (parsed.letter, parsed.number or parsed.owner)
    return Name(letter, number, owner, dots)


def of_table(field: str, owner: str, symbol: str = "") -> Name:
    """A table in a field of a block: the capital of the field's letter if it differs from a Latin one, or its word; of an
    effect's own table the effect's. symbol: as its field declares it."""
    *effects, last = field.split(".")
    word, _, place = last.rstrip("]").partition("[")
    if effects and word == "table":
        word, *effects = effects
    own = plain(symbol) if symbol else Name(_FIELDS.get(word, GREEK.get(word, word)))
    letter = own.letter
    capital = letter.upper() if letter.isascii() or letter.upper() in GREEK.values() else letter
    return Name(
        capital if len(letter) == 1 else letter, _of_effects(effects) + (own.number or own.owner) + place, owner
    )


def plain(name: str) -> Name:
    """A name by its spelling: w_1, omega, x2, phi_disc', else a word."""
    base = name.rstrip("'")
    dots = len(name) - len(base)
    match = re.fullmatch(r"([A-Za-z]|" + "|".join(GREEK) + r")(?:_?(\d+))?(?:_(\w+))?", base)
    if match is None:
        return Name(base, "", "", dots)
    return Name(GREEK.get(match[1], match[1]), match[2] or "", match[3] or "", dots)


def with_tables(names: Mapping[Any, Name], tables: Collection[Any]) -> dict[Any, Name]:
    """The names, those of tables that something else has too with "tab" at their foot, where that tells them apart."""
    shared = Counter(names.values())
    marked = {x: replace(names[x], number=f"{names[x].number}tab") for x in tables if shared[names[x]] > 1}
    alike = Counter(marked.values())
    return {**names, **{x: name for x, name in marked.items() if alike[name] == 1}}


def distinct(names: Mapping[Any, Name], *spares: Mapping[Any, str]) -> dict[Any, Name]:
    """The names, where two things would share one each with the words of a spare in place of its letter, of the next where
    these are shared too."""
    found = dict(names)
    for spare in spares:
        shared = Counter(found.values())
        for symbol in [x for x, name in found.items() if shared[name] > 1 and x in spare]:
            found[symbol] = replace(names[symbol], letter=spare[symbol])
    return found


def owners(paths: Iterable[str]) -> dict[str, str]:
    """What stands at the foot of a symbol for each part of the train: the end of its path where the parts that have it, but for
    numbers, are all of one container; without brackets."""
    places = {path: path.split(".") for path in paths}
    containers: dict[tuple[str, ...], set[tuple[str, ...]]] = {}
    for parts in places.values():
        for n in range(len(parts)):
            containers.setdefault(_without_numbers(parts[n:]), set()).add(tuple(parts[:n]))
    found = {}
    for path, parts in places.items():
        ends = (n for n in reversed(range(len(parts))) if len(containers[_without_numbers(parts[n:])]) == 1)
        found[path] = whole(".".join(parts[next(ends, 0) :]))
    return found


def _without_numbers(parts: Iterable[str]) -> tuple[str, ...]:
    return tuple(part.rstrip("[]0123456789") for part in parts)


def whole(path: str) -> str:
    """A path without brackets, in words."""
    return path.replace("[", "").replace("]", "").replace(".", " ")
