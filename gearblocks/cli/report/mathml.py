"""sympy expressions as presentation MathML, which browsers show without help and without a network."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

from sympy.printing.mathml import MathMLPresentationPrinter

_GREEK = {
    "alpha": "α", "beta": "β", "gamma": "γ", "delta": "δ", "epsilon": "ε", "zeta": "ζ", "eta": "η", "theta": "θ",
    "vartheta": "ϑ", "kappa": "κ", "lambda": "λ", "mu": "μ", "nu": "ν", "rho": "ρ", "sigma": "σ", "tau": "τ",
    "phi": "φ", "varphi": "φ", "psi": "ψ", "omega": "ω", "Omega": "Ω", "varepsilon": "ε",
}  # fmt: skip
_DOTS = {"dot": "\N{DOT ABOVE}", "ddot": "\N{DIAERESIS}", "dddot": "\N{COMBINING THREE DOTS ABOVE}"}
_NAME = re.compile(
    r"(?:\\(?P<dots>d{1,3}ot)\{)?(?:\\(?P<greek>[a-zA-Z]+)|\\mathrm\{(?P<word>[^{}]*)\}|(?P<letter>[A-Za-z]+))\}?"
    r"(?:_\{(?:\\mathrm\{)?(?P<index>[^{}]*)\}?\})?(?P<of_time>(?:\\!)?\\left\(t\\right\))?"
)


class _Printer(MathMLPresentationPrinter):  # type: ignore[misc, unused-ignore]  # sympy carries no types
    """Names as the LaTeX of the train has them, piecewise laws as cases, the dead zone as g."""

    def __init__(self, latex_of: Callable[[Any], str]) -> None:
        super().__init__()
        self._latex_of = latex_of

    def _print_Symbol(self, symbol: Any, style: str = "plain") -> Any:  # noqa: ARG002 - sympy hands it over
        match = _NAME.fullmatch(self._latex_of(symbol))
        if match is None or (match["greek"] and match["greek"] not in _GREEK):
            return self._leaf("mtext", symbol.name)
        word = (match["word"] or "").replace("\\_", " ")
        node = self._leaf("mi", _GREEK.get(match["greek"]) or word or match["letter"])
        if match["dots"]:
            node = self._node("mover", node, self._leaf("mo", _DOTS[match["dots"]]))
        if match["index"]:
            index = match["index"].replace("\\_", "_").replace("_", " ")
            node = self._node("msub", node, self._leaf("mn" if index.isdigit() else "mtext", index))
        return self._of(node, self._leaf("mi", "t")) if match["of_time"] else node

    def _print_DeadZone(self, expr: Any) -> Any:
        name = {-1: "G", 0: "g", 1: "g\N{PRIME}"}.get(int(expr.args[2]), "g\N{DOUBLE PRIME}")
        return self._of(self._leaf("mi", name), self._print(expr.args[0]))

    def _print_ContactSide(self, expr: Any) -> Any:
        return self._of(self._leaf("mi", "side"), self._print(expr.args[0]))

    def _print_Piecewise(self, expr: Any) -> Any:
        rows = []
        for value, condition in expr.args:
            when = self._leaf("mtext", "otherwise") if condition == True else self._print(condition)  # noqa: E712
            rows.append(self._node("mtr", self._cell(self._print(value)), self._cell(when)))
        return self._node("mrow", self._leaf("mo", "{"), self._node("mtable", *rows))

    def _of(self, function: Any, argument: Any) -> Any:
        inside = self._node("mrow", self._leaf("mo", "("), argument, self._leaf("mo", ")"))
        return self._node("mrow", function, inside)

    def _cell(self, content: Any) -> Any:
        cell = self._node("mtd", content)
        cell.setAttribute("style", "text-align: left; padding: 0.15em 0.8em 0.15em 0")
        return cell

    def _node(self, tag: str, *children: Any) -> Any:
        node = self.dom.createElement(tag)
        for child in children:
            node.appendChild(child)
        return node

    def _leaf(self, tag: str, words: str) -> Any:
        return self._node(tag, self.dom.createTextNode(words))


def mathml(expr: Any, latex_of: Callable[[Any], str]) -> str:
    """A <math> element in the line of text that shows `expr`; `latex_of` gives the LaTeX name of a symbol."""
    body = _Printer(latex_of).doprint(expr).replace("<mo>-</mo>", "<mo>\N{MINUS SIGN}</mo>")
    return f'<math xmlns="http://www.w3.org/1998/Math/MathML" displaystyle="true">{body}</math>'
