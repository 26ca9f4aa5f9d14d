"""sympy expressions as presentation MathML, which browsers show without help."""

from __future__ import annotations

from html import escape
from typing import Any

from sympy.printing.mathml import MathMLPresentationPrinter


class _Printer(MathMLPresentationPrinter):  # type: ignore[misc, unused-ignore]
    """Presentation MathML with piecewise laws as cases and dotted names as subscripts."""

    def __init__(self, names: dict[Any, str]) -> None:
        super().__init__({"symbol_names": {}, "mul_symbol": "None"})
        self.given = names

    def _print_Symbol(self, symbol: Any, style: str = "plain") -> Any:
        words = self.given.get(symbol)
        if words is not None:
            return self._name(words)
        return self._name(symbol.name) if "." in symbol.name else super()._print_Symbol(symbol, style)

    def _name(self, dotted: str) -> Any:
        owner, _, last = dotted.rpartition(".")
        node = self.dom.createElement("msub" if owner else "mi")
        if not owner:
            node.appendChild(self.dom.createTextNode(dotted))
            return node
        for tag, words in (("mi", last.replace("_", " ")), ("mtext", owner)):
            part = self.dom.createElement(tag)
            part.appendChild(self.dom.createTextNode(words))
            node.appendChild(part)
        return node

    def _print_Piecewise(self, expr: Any) -> Any:
        table = self.dom.createElement("mtable")
        table.setAttribute("columnalign", "left left")
        for value, condition in expr.args:
            row = self.dom.createElement("mtr")
            row.appendChild(self._cell(self._print(value)))
            row.appendChild(self._cell(self._text("otherwise") if condition == True else self._print(condition)))  # noqa: E712
            table.appendChild(row)
        group = self.dom.createElement("mrow")
        brace = self.dom.createElement("mo")
        brace.appendChild(self.dom.createTextNode("{"))
        group.appendChild(brace)
        group.appendChild(table)
        return group

    def _cell(self, content: Any) -> Any:
        cell = self.dom.createElement("mtd")
        cell.setAttribute("style", "text-align: left; padding: 0.1em 0.6em")
        cell.appendChild(content)
        return cell

    def _text(self, words: str) -> Any:
        node = self.dom.createElement("mtext")
        node.appendChild(self.dom.createTextNode(words))
        return node


def mathml(expr: Any, names: dict[Any, str] | None = None, *, block: bool = True) -> str:
    """A <math> element that shows `expr`; `names` gives symbols other names: "mesh.k" is k with the subscript mesh."""
    printer = _Printer(names or {})
    body = printer._print(expr).toxml()
    display = ' display="block"' if block else ""
    return f'<math xmlns="http://www.w3.org/1998/Math/MathML"{display}>{body}</math>'


def code(text: str) -> str:
    """Text as it stands, in a <pre> element."""
    return f"<pre>{escape(text)}</pre>"
