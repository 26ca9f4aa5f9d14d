"""Expression trees of signals: built from `time`, parameters, inputs, tables and feedback signals without importing sympy.

They print to text, parse back from text (nothing is evaluated as code) and turn into sympy when asked. A sympy
expression of these leaves is taken as well.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterator
from functools import lru_cache
from typing import Any

from gearblocks.errors import GearblocksError, ParameterError
from gearblocks.language.numpy_calls import numpy_call
from gearblocks.language.refusals import NoWholeNumbers, asked, condition_asked, condition_in, no_condition

FUNCTIONS = (
    "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "exp", "log", "sqrt", "Abs", "sign",
    "Min", "Max", "Heaviside", "Piecewise", "And", "Or", "Not",
)  # fmt: skip
_INFIX = {"+": 1, "*": 2, "**": 4}
_RELATIONS = ("<", "<=", ">", ">=")
_NUMERIC = (*_INFIX, *_RELATIONS)
_LEAVES = ("parameter", "input", "table", "table2", "sense", "time", "local")


class Expr(NoWholeNumbers):
    """One node: an operation and its arguments, or a leaf. Immutable; arithmetic builds new nodes.

    op: "number", "time", "parameter", "input", "table", "table2" (of two quantities), "sense", "local" (a block's own
    quantity), one of + * **, a relation, or a function name.
    """

    __slots__ = ("args", "op")

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **options: Any) -> Any:
        """Arithmetic with numpy scalars, and np.sin(expression) and its like."""
        return numpy_call(as_expr, FUNCTIONS, ufunc, method, inputs)

    def __init__(self, op: str, *args: Any) -> None:
        object.__setattr__(self, "op", op)
        object.__setattr__(self, "args", args)

    op: str
    args: tuple[Any, ...]

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError("an expression cannot be changed")

    def __reduce__(self) -> tuple[Any, ...]:
        return (Expr, (self.op, *self.args))

    def __add__(self, other: Any) -> Any:
        return _binary("+", self, other)

    def __radd__(self, other: Any) -> Any:
        return _binary("+", other, self)

    def __sub__(self, other: Any) -> Any:
        return _binary("+", self, other, lambda o: -o)

    def __rsub__(self, other: Any) -> Any:
        return _binary("+", other, -self)

    def __mul__(self, other: Any) -> Any:
        return _binary("*", self, other)

    def __rmul__(self, other: Any) -> Any:
        return _binary("*", other, self)

    def __truediv__(self, other: Any) -> Any:
        return _binary("*", self, other, lambda o: o**-1)

    def __rtruediv__(self, other: Any) -> Any:
        return _binary("*", other, self**-1)

    def __pow__(self, other: Any) -> Any:
        return _binary("**", self, other)

    def __rpow__(self, other: Any) -> Any:
        return _binary("**", other, self)

    def __neg__(self) -> Expr:
        return Expr("*", number(-1.0), self)

    def __pos__(self) -> Expr:
        return self

    def __abs__(self) -> Expr:
        return Expr("Abs", self)

    def __lt__(self, other: Any) -> Any:
        return _binary("<", self, other)

    def __le__(self, other: Any) -> Any:
        return _binary("<=", self, other)

    def __gt__(self, other: Any) -> Any:
        return _binary(">", self, other)

    def __ge__(self, other: Any) -> Any:
        return _binary(">=", self, other)

    def __and__(self, other: Any) -> Any:
        return joined("And", self, other)

    def __or__(self, other: Any) -> Any:
        return joined("Or", self, other)

    def __invert__(self) -> Expr:
        return Expr("Not", _condition("~", self))

    __rand__, __ror__ = __and__, __or__

    def __bool__(self) -> bool:
        if is_condition(self):
            raise condition_asked(self)
        return super().__bool__()

    def __float__(self) -> float:
        raise ParameterError(
            f"'{self}' is an expression, not a number: use gb.sin, gb.sqrt, gb.piecewise and their like, or sympy's functions"
        )

    def __str__(self) -> str:
        return _text(self, 0)

    def __repr__(self) -> str:
        return f"<expression {self}>"

    def leaves(self) -> Iterator[Expr]:
        """Every leaf that is not a number, depth first, repeated where it is repeated."""
        if self.op in _LEAVES:
            yield self
        for a in self.args:
            if isinstance(a, Expr):
                yield from a.leaves()

    def _sympy_(self) -> Any:
        return to_sympy(self)


def number(x: float) -> Expr:
    """A constant; ParameterError when it is not finite."""
    return Expr("number", finite_number("a number in an expression", x))


def finite_number(what: str, x: Any) -> float:
    """x as a Python float. ParameterError names `what` where x is no number (text, truth, array) or not finite."""
    if isinstance(x, (bool, str, bytes, complex)) or getattr(x, "shape", ()) != () or not hasattr(x, "__float__"):
        raise ParameterError(f"{what} = {x!r:.80} must be a number")
    try:
        value = float(x)
    except (TypeError, ValueError, OverflowError):
        raise ParameterError(f"{what} = {x!r:.80} must be a number") from None
    if not math.isfinite(value):
        raise ParameterError(f"{what} = {x!r} must be a finite number")
    return value


def as_expr(x: Any) -> Expr:
    """A number, leaf, expression or sympy expression as an `Expr`; ParameterError for anything else."""
    if isinstance(x, Expr):
        return x
    if (to_expr := getattr(x, "_expr_", None)) is not None:
        result = to_expr()
        assert isinstance(result, Expr)
        return result
    if is_sympy(x):
        return from_sympy(x)
    if isinstance(x, (bool, str)) or getattr(x, "shape", ()) != () or not hasattr(x, "__float__"):
        ways = "give SI, gb.Parameter(name, value, unit) or gb.sense(name)"
        raise ParameterError(f"{x!r:.80} cannot stand in an expression: {ways}")
    return number(x)


def is_sympy(x: Any) -> bool:
    """Whether x is a sympy object; sympy is not imported for the question."""
    sympy = sys.modules.get("sympy")
    return sympy is not None and isinstance(x, sympy.Basic)


def is_condition(x: Any) -> bool:
    """Whether x is one of <, <=, >, >=, or joins such; a value is none, be it 0 or 1."""
    if is_sympy(x):
        return bool(x.is_Relational or x.is_Boolean)
    return isinstance(x, Expr) and x.op in (*_RELATIONS, "And", "Or", "Not")


def _condition(sign: str, x: Any) -> Any:
    if not is_condition(x):
        raise no_condition(sign, as_expr(x) if hasattr(x, "_expr_") else x)
    return x


def joined(op: str, left: Any, right: Any) -> Any:
    """Two conditions by "And" or "Or"; ParameterError where one is none."""
    return _binary(op, *(_condition("&" if op == "And" else "|", x) for x in (left, right)))


def _binary(op: str, left: Any, right: Any, wrap: Callable[[Any], Any] | None = None) -> Any:
    if op in _NUMERIC and (wrong := [x for x in (left, right) if is_condition(x)]):
        raise condition_in(wrong[0])
    # sympy's Piecewise asks for its own conditions, so those are made where sympy is in use
    if is_sympy(left) or is_sympy(right) or (op in _RELATIONS and "sympy" in sys.modules):
        return _sympy_binary(op, left, right, wrap)
    a, b = as_expr(left), as_expr(right)
    b = wrap(b) if wrap else b
    if op in ("+", "*", "And", "Or"):  # long sums and products are one node, not a chain of them
        before = a.args if a.op == op else (a,)
        return Expr(op, *before, *(b.args if b.op == op and all(x.op != "number" for x in b.args) else (b,)))
    return Expr(op, a, b)


def _sympy_binary(op: str, left: Any, right: Any, wrap: Callable[[Any], Any] | None) -> Any:
    import sympy as sp

    a, b = sp.sympify(left), sp.sympify(right)
    b = wrap(b) if wrap else b
    operations: dict[str, Callable[[], Any]] = {
        "+": lambda: a + b, "*": lambda: a * b, "**": lambda: a**b,
        "<": lambda: a < b, "<=": lambda: a <= b, ">": lambda: a > b, ">=": lambda: a >= b,
        "And": lambda: sp.And(a, b), "Or": lambda: sp.Or(a, b),
    }  # fmt: skip
    return asked(operations[op](), from_sympy, joined)


def function(name: str, *args: Any) -> Expr:
    """A named function of expressions, for example function("sin", 3 * time). The largest of the largest is one node."""
    if wrong := [x for x in args if is_condition(x)]:
        raise condition_in(wrong[0])
    parts = [(a,) if a.op != name or name not in ("Max", "Min") else a.args for a in map(as_expr, args)]
    return Expr(name, *(a for part in parts for a in part))


# -- text ------------------------------------------------------------------------------------------------------------


def _text(e: Expr, outer: int) -> str:
    if e.op == "number":
        value = repr(e.args[0])
        value = value[:-2] if value.endswith(".0") else value
        return f"({value})" if e.args[0] < 0 and outer > 1 else value
    if e.op == "time":
        return "time"
    if e.op in ("parameter", "input", "sense", "local"):
        return f"{e.op}({getattr(e.args[0], 'name', e.args[0])!r})"
    if e.op in ("table", "table2"):
        return f"{e.op}({', '.join([repr(e.args[0].digest()), *(_text(a, 0) for a in e.args[1:])])})"
    if e.op in _INFIX:
        level = _INFIX[e.op]
        joined = (" + " if e.op == "+" else e.op).join(_text(a, level + (1 if e.op == "**" else 0)) for a in e.args)
        return f"({joined})" if level < outer else joined
    if e.op in _RELATIONS:
        return f"({_text(e.args[0], 1)} {e.op} {_text(e.args[1], 1)})"
    return f"{e.op}({', '.join(_text(a, 0) for a in e.args)})"


# -- numbers ----------------------------------------------------------------------------------------------------------


def evaluate(e: Expr, values: Callable[[Expr], float]) -> float:
    """The number that e stands for when `values` gives a number for each leaf."""
    if e.op == "number":
        return float(e.args[0])
    if e.op in _LEAVES:
        return values(e)
    a = [evaluate(x, values) for x in e.args]
    if e.op in ("+", "*"):
        return (math.fsum if e.op == "+" else math.prod)(a)
    if e.op == "**":
        return float(a[0] ** a[1])
    if e.op in _RELATIONS:
        return float({"<": a[0] < a[1], "<=": a[0] <= a[1], ">": a[0] > a[1], ">=": a[0] >= a[1]}[e.op])
    return _call(e.op, a)


def _call(name: str, a: list[float]) -> float:
    simple: dict[str, Callable[[], float]] = {
        "Abs": lambda: abs(a[0]), "sign": lambda: math.copysign(1.0, a[0]) if a[0] else 0.0,
        "Min": lambda: min(a), "Max": lambda: max(a), "Heaviside": lambda: float(a[0] >= 0),
        "And": lambda: float(all(a)), "Or": lambda: float(any(a)), "Not": lambda: float(not a[0]),
        "Piecewise": lambda: next((v for v, c in zip(a[::2], a[1::2], strict=True) if c), math.nan),
    }  # fmt: skip
    return float(simple[name]() if name in simple else getattr(math, name)(*a))


# -- sympy ------------------------------------------------------------------------------------------------------------


@lru_cache(maxsize=1)
def leaf_symbol_class() -> Any:
    """The sympy symbol that remembers which leaf it stands for (made on first use: sympy is slow to import)."""
    import sympy as sp

    class LeafSymbol(sp.Symbol):  # type: ignore[misc]  # sympy carries no types
        __slots__ = ("leaf",)

        def __new__(cls, leaf: Expr) -> LeafSymbol:
            if leaf.op in ("time", "table", "table2"):
                name = "t" if leaf.op == "time" else str(leaf)
            else:
                name = leaf.args[0] if leaf.op in ("sense", "local") else leaf.args[0].name
            symbol: Any = sp.Symbol.__xnew__(cls, name, real=True)
            symbol.leaf = leaf
            return symbol  # type: ignore[no-any-return]

        def _hashable_content(self) -> tuple[Any, ...]:
            return (*super()._hashable_content(), self.leaf.op, *(repr(a) for a in self.leaf.args))

        def __reduce_ex__(self, protocol: object) -> tuple[Any, ...]:
            return (to_sympy, (self.leaf,))

    return LeafSymbol


def to_sympy(e: Expr, leaf: Callable[[Expr], Any] | None = None) -> Any:
    """e in sympy; `leaf` gives the symbol of each leaf (default: one that turns back into the leaf)."""
    import sympy as sp

    if e.op == "number":
        x = e.args[0]
        return sp.Integer(int(x)) if x == int(x) and abs(x) < 1e15 else sp.Float(x)
    if e.op in _LEAVES:
        return leaf(e) if leaf else leaf_symbol_class()(e)
    if e.op == "**" and next(e.leaves(), None) is None:
        _check_power(e)
    a = [to_sympy(x, leaf) for x in e.args]
    if e.op in ("+", "*"):
        return (sp.Add if e.op == "+" else sp.Mul)(*a)
    if e.op in ("Max", "Min"):
        from gearblocks.language.extrema import extremum

        return extremum(e.op, a)
    if e.op == "**":
        power = sp.Pow(*a)
        if power.is_number and not power.is_real:
            raise ParameterError(f"'{e}' in an expression is no finite real number")
        return power
    if e.op in _RELATIONS:
        return {"<": sp.Lt, "<=": sp.Le, ">": sp.Gt, ">=": sp.Ge}[e.op](*a)
    if e.op == "Piecewise":
        return sp.Piecewise(*((v, True if c == 1 else c) for v, c in zip(a[::2], a[1::2], strict=True)))
    if e.op == "Heaviside" and a[0] == 0:  # of sympy's it is 1/2
        return sp.Integer(1)
    if e.op == "exp" and a[0].is_Add:  # exp(x + 1000.0) would become exp(1000.0) exp(x), infinite times 0
        a = [sp.Add(*(sp.Rational(x) if x.is_Float else x for x in a[0].args))]
    return getattr(sp, e.op)(*a)


def _check_power(e: Expr) -> None:
    """Refuses 0**-1 and 9**9**9 before sympy works them out."""
    try:
        evaluate(e, lambda _: math.nan)
    except (ArithmeticError, ValueError, TypeError):
        raise ParameterError(f"'{e}' in an expression is no finite real number") from None


def from_sympy(x: Any) -> Expr:
    """A sympy expression of gb.time, Parameters, Inputs and senses. GearblocksError names a foreign symbol."""
    import sympy as sp

    if isinstance(leaf := getattr(x, "leaf", None), Expr):
        return leaf
    if x in (sp.true, sp.false):
        return number(float(bool(x)))
    if x.is_Number or x.is_NumberSymbol:
        return number(float(x))
    if x.is_Symbol:
        raise GearblocksError(
            f"the expression contains the symbol '{x}', which is no gb.time, gb.Parameter, gb.Input or gb.sense(...): "
            f"make it gb.Parameter('{x}', value, unit); in physics a Table is read as s.local('field', x=quantity)"
        )
    name = type(x).__name__
    if name == "ITE":  # what sympy makes of a condition on a value with cases
        return from_sympy(sp.Or(sp.And(x.args[0], x.args[1]), sp.And(sp.Not(x.args[0]), x.args[2])))
    if name == "Piecewise":
        return Expr("Piecewise", *(from_sympy(part) for pair in x.args for part in pair))
    names = {"Add": "+", "Mul": "*", "Pow": "**", "LessThan": "<=", "GreaterThan": ">="}
    names |= {"StrictLessThan": "<", "StrictGreaterThan": ">"}
    if name == "exp" or name in names or name in FUNCTIONS:
        return Expr(names.get(name, name), *(from_sympy(a) for a in x.args))
    raise GearblocksError(f"'{x}' ({name}) cannot stand in a signal; there are {', '.join(FUNCTIONS)}")
