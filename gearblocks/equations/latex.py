"""LaTeX for the names of symbols in equations for people."""

from __future__ import annotations

import re

_LETTERS = {
    "half_gap": "b", "damping_ratio": r"\zeta", "radius": "r", "driven_by": r"\omega", "phase": r"\vartheta",
    "teeth": "z", "module": "m", "pressure_angle": r"\alpha", "helix_angle": r"\beta", "r_base": "r", "tau": r"\tau",
    "coeffs": "c", "ripple": r"\epsilon", "contact_ratio": r"\epsilon_\alpha", "ratio": "i", "cos": "a", "sin": "b",
    "k_t": "k", "torque": "T", "torque_variation": r"\varepsilon", "speed": r"\omega",
    "w_rel": r"\Delta\dot{\varphi}", "v_rel": r"\Delta\dot{s}",
}  # fmt: skip


def latex_name(name: str) -> str:
    """LaTeX of a symbol's name: phi_disc' as a dotted letter with an index."""
    base = name.rstrip("'")
    dots = len(name) - len(base)
    match = re.fullmatch(r"([A-Za-z]|phi)(?:_(.+)|(\d+))?", base)
    letter, index = (match[1], match[2] or match[3] or "") if match else (word(base), "")
    for field in sorted(_LETTERS, key=len, reverse=True):
        match = re.fullmatch(rf"{field}(\d*)(?:_(.*))?", base)
        if match:
            letter, index = _LETTERS[field], " ".join(x for x in match.groups() if x)
            break
    if base.startswith("k_t_"):
        return rf"k_{{{word(index)}}}\!\left(t\right)"
    letter = {"phi": r"\varphi", "w": r"\varphi"}.get(letter, letter)
    dots += 1 if base.startswith("w_") and not base.startswith("w_rel") else 0
    if dots:
        letter = {1: rf"\dot{{{letter}}}", 2: rf"\ddot{{{letter}}}", 3: rf"\dddot{{{letter}}}"}[dots]
    return f"{letter}_{{{index if index.isdigit() else word(index)}}}" if index else letter


def word(text: str) -> str:
    """A word upright, its underscores as such."""
    escaped = text.replace("_", r"\_")
    return rf"\mathrm{{{escaped}}}"
