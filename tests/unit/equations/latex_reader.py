"""Printed LaTeX back to numbers: a reader of the equations as a person reads them, who knows no sympy and no notation.

read(latex)          the equations of a document, (left, right) as LaTeX
Sheet(values, ...)   what a person computes from them: number and rate of every symbol, with 30 digits
"""

import re
from typing import NamedTuple

import mpmath as mp

TOKENS = re.compile(r"\\[a-zA-Z]+|\\.|\d+(?:\.\d+)?|[^\s]")
SKIPPED = {r"\,", r"\ ", r"\quad", r"\left", r"\right", r"\cdot", "&"}


def read(latex):
    """(heading, left, right) of each equation of a document."""
    found, heading = [], ""
    for part in re.split(r"(\\paragraph\{[^\n]*\}\n|\\begin\{align\}\n.*?\n\\end\{align\})", latex, flags=re.DOTALL):
        if part.startswith(r"\paragraph"):
            heading = part[len(r"\paragraph{") : -2]
        elif part.startswith(r"\begin{align}"):
            body = part[len("\\begin{align}\n") : -len("\n\\end{align}")].replace(" \\notag \\\\*\n", " ")
            body = body.replace(r"\begin{aligned}[t]&", " ").replace(r"\\ &\quad ", " ").replace(r"\end{aligned}", " ")
            for row in body.split(" \\\\\n"):
                left, right = re.split(r" &= |(?<![<>]) = ?", row.replace(r"&\quad", " "), maxsplit=1)
                found.append((heading, left.strip().lstrip("&"), right))
    return found


def of_all(equations, feet):
    """Equations of alike parts (an index i, its values in the heading) as those of each part; sums over i as their terms."""
    alike = {}
    for foot in feet:  # gear.planet[1] is "planet1" at the foot of symbols, and one of any "planet i"
        whole = foot.translate({ord(" "): r"\,", ord("_"): r"\_"})
        stem = whole.rstrip("0123456789")
        if stem != whole:
            foot = stem.removesuffix(r"\_")
            alike[rf"{foot}}}\,i", whole[len(stem) :]] = whole
    for heading, left, right in equations:
        over = re.search(r", i = (\d+), \.\.\., (\d+)$", heading)
        for i in range(int(over[1]), int(over[2]) + 1) if over else [None]:
            yield heading, *(_at(_summed(x, alike), i, alike) for x in (left, right))


def _at(latex, index, alike):
    """With the symbols of one part for those of any."""
    if index is None:
        return latex
    for (foot, i), one in alike.items():
        if i == str(index):
            latex = re.sub(rf"(?<=\{{){re.escape(foot)}(?=[\\}}])", lambda _, one=one: f"{one}}}", latex)
    return latex


def _summed(latex, alike):
    """Sums written out term by term."""
    while found := re.search(r"\\sum_\{i=(\d+)\}\^\{(\d+)\} ", latex):
        depth, end = 0, found.end()
        while end < len(latex) and not (depth == 0 and re.match(r"\s+[+-] ", latex[end:])):
            depth += (latex[end] in "({") - (latex[end] in ")}")
            end += 1
        term = latex[found.end() : end]
        terms = (_at(term, i, alike) for i in range(int(found[1]), int(found[2]) + 1))
        latex = f"{latex[: found.start()]}({' + '.join(terms)}){latex[end:]}"
    return latex


class Moving(NamedTuple):
    """A number and its rate in time (None: nothing says it)."""

    value: mp.mpf
    rate: mp.mpf | None = mp.mpf(0)

    def through(self, value, slope):
        """A function of it."""
        return Moving(value, None if self.rate is None else slope * self.rate)


def _of_two(one, two, value, by_one, by_two):
    rates = [
        mp.mpf(0) if slope == 0 else None if x.rate is None else slope * x.rate
        for x, slope in ((one, by_one), (two, by_two))
    ]
    return Moving(value, None if None in rates else sum(rates))


def _power(one, two):
    value = one.value**two.value
    return one.through(value, two.value * one.value ** (two.value - 1))


def _solved(x, angle):
    """The angle a with tan(a) - a = x."""
    return x.through(angle, 1 / mp.tan(angle) ** 2)


FUNCTIONS = {
    r"\sin": lambda x: x.through(mp.sin(x.value), mp.cos(x.value)),
    r"\cos": lambda x: x.through(mp.cos(x.value), -mp.sin(x.value)),
    r"\tan": lambda x: x.through(mp.tan(x.value), 1 + mp.tan(x.value) ** 2),
    r"\arctan": lambda x: x.through(mp.atan(x.value), 1 / (1 + x.value**2)),
    r"\exp": lambda x: x.through(mp.exp(x.value), mp.exp(x.value)),
    "arcinv": lambda x: _solved(x, mp.findroot(lambda a: mp.tan(a) - a - x.value, mp.cbrt(3 * x.value))),
    "sgn": lambda x: Moving(mp.mpf(mp.sign(x.value))),
    "H": lambda x: Moving(mp.mpf(x.value >= 0)),
    r"\max": lambda *x: max(x),
    r"\min": lambda *x: min(x),
}
RELATIONS = {
    "=": lambda a, b: a == b, "<": lambda a, b: a < b, ">": lambda a, b: a > b, r"\le": lambda a, b: a <= b,
    r"\ge": lambda a, b: a >= b, r"\ne": lambda a, b: a != b,
}  # fmt: skip


class UnknownError(LookupError):
    """A symbol whose number is not known yet."""


class Sheet:
    """known: Moving by name in LaTeX without blanks; tables: functions of (arguments, primes) by name."""

    def __init__(self, known, tables):
        self.known, self.tables, self.used = known, tables, set()

    def value(self, latex):
        """Number and rate of an expression. Raises UnknownError for what is not known yet."""
        self.tokens, self.at = [t for t in TOKENS.findall(latex) if t not in SKIPPED], 0
        found = self._sum()
        assert self.at == len(self.tokens), (latex, self.tokens[self.at :])
        return found

    def holds(self):
        """A relation, or several with and, or; some of them in brackets."""
        if self._peek() == "(" and r"\text" in self.tokens[self.at : self._closing()]:
            self._next("(")
            found = self.holds()
            self._next(")")
        else:
            left = self._sum()
            relation = RELATIONS[self._next()]
            found = relation(left.value, self._sum().value)
        while self._peek() == r"\text" and self.tokens[self.at + 2 : self.at + 4] in (list("an"), list("or")):
            word = self._braced()
            more = self.holds()
            found = (found and more) if word == "and" else (found or more)
        return found

    def _closing(self):
        """Where the bracket that opens here closes."""
        depth = 0
        for at in range(self.at, len(self.tokens)):
            depth += {"(": 1, ")": -1}.get(self.tokens[at], 0)
            if depth == 0:
                return at
        return len(self.tokens)

    def _peek(self):
        return self.tokens[self.at] if self.at < len(self.tokens) else ""

    def _next(self, wanted=None):
        token = self._peek()
        assert token and wanted in (None, token), (wanted, self.tokens[max(0, self.at - 5) : self.at + 5])
        self.at += 1
        return token

    def _braced(self):
        """The letters between braces behind a macro."""
        self._next()
        self._next("{")
        start, depth = self.at, 1
        while depth:
            depth += {"{": 1, "}": -1}.get(self._next(), 0)
        return "".join(self.tokens[start : self.at - 1])

    def _sum(self):
        minus = self._peek() == "-"
        if minus:
            self._next()
        found = self._product()
        found = found.through(-found.value, -1) if minus else found
        while self._peek() in ("+", "-"):
            sign = 1 if self._next() == "+" else -1
            other = self._product()
            found = _of_two(found, other, found.value + sign * other.value, 1, sign)
        return found

    def _product(self):
        found = self._factor()
        while self._begins():
            if self._peek() == "/":
                self._next()
                other = self._factor()
                value = found.value / other.value
                found = _of_two(found, other, value, 1 / other.value, -value / other.value)
            else:
                if self._peek() == r"\times":
                    self._next()
                other = self._factor()
                found = _of_two(found, other, found.value * other.value, other.value, found.value)
        return found

    def _begins(self):
        """Whether another factor follows."""
        token = self._peek()
        if token == "|":
            return self.fences == 0
        ends = ("", "+", "-", ")", "}", ",", "_", "^", r"\\", r"\end", r"\text", r"\rfloor", *RELATIONS)
        return token not in ends

    fences = 0

    def _factor(self):
        found = self._base()
        if self._peek() == "^":
            self._next()
            self._next("{")
            found = _power(found, self._sum())
            self._next("}")
        return found

    def _base(self):
        token = self._peek()
        if token[0].isdigit():
            return Moving(mp.mpf(self._next()))
        special = {
            "(": self._bracket, "|": self._size, r"\frac": self._fraction, r"\tfrac": self._fraction, r"\sqrt": self._root,
            r"\begin": self._cases, r"\operatorname": self._function, r"\pi": self._pi, "{": self._primed,
            r"\lfloor": self._floor,
        }.get(token)  # fmt: skip
        if special:
            return special()
        return self._function() if token in FUNCTIONS else self._symbol()

    def _pi(self):
        self._next()
        return Moving(+mp.pi)

    def _bracket(self):
        self._next("(")
        outer, self.fences = self.fences, 0
        found = self._sum()
        self.fences = outer
        self._next(")")
        return found

    def _size(self):
        self._next("|")
        self.fences += 1
        found = self._sum()
        self.fences -= 1
        self._next("|")
        return found.through(abs(found.value), mp.sign(found.value))

    def _floor(self):
        self._next()
        found = self._sum()
        self._next(r"\rfloor")
        return Moving(mp.floor(found.value))

    def _group(self):
        self._next("{")
        outer, self.fences = self.fences, 0
        found = self._sum()
        self.fences = outer
        self._next("}")
        return found

    def _fraction(self):
        self._next()
        top, bottom = self._group(), self._group()
        value = top.value / bottom.value
        return _of_two(top, bottom, value, 1 / bottom.value, -value / bottom.value)

    def _root(self):
        self._next()
        inner = self._group()
        return inner.through(mp.sqrt(inner.value), 1 / (2 * mp.sqrt(inner.value)) if inner.value else 0)

    def _cases(self):
        assert self._braced() == "cases"
        outer, self.fences, found = self.fences, 0, None
        while self._peek() != r"\end":
            value = self._sum()
            self._next(",")
            otherwise = self._peek() == r"\text" and self.tokens[self.at + 2] == "o"
            holds = bool(self._braced()) if otherwise else self.holds()
            found = value if found is None and holds else found
            if self._peek() == r"\\":
                self._next()
        self._braced()
        self.fences = outer
        return found

    def _arguments(self):
        self._next("(")
        outer, self.fences = self.fences, 0
        found = [self._sum()]
        while self._peek() == ",":
            self._next()
            found.append(self._sum())
        self.fences = outer
        self._next(")")
        return found

    def _function(self):
        name = self._braced() if self._peek() == r"\operatorname" else self._next()
        return FUNCTIONS[name](*self._arguments())

    def _primed(self):
        self._next("{")
        name, _ = self._name()
        self._next("}")
        primes = 0
        while self._peek() == "'":
            self._next()
            primes += 1
        return self.tables[name](self._arguments(), primes)

    def _symbol(self):
        name, dots = self._name()
        self.used.add(name)
        if name in self.tables:
            return self.tables[name](self._arguments(), 0)
        if dots == 0 or (name, dots) in self.known:
            return self._of((name, dots))
        base = self._of((name, dots - 1))
        if base.rate is None:
            raise UnknownError(name)
        return Moving(base.rate, None)

    def _of(self, name):
        if name not in self.known:
            raise UnknownError(name)
        return self.known[name]

    def _name(self):
        """A name without its dots, and how many they are."""
        text, dots = "", 0
        while self._peek() in (r"\Delta", r"\partial"):
            text += self._next()
        token = self._peek()
        if token in (r"\dot", r"\ddot", r"\dddot"):
            dots = len(token) - 3
            letter = self._braced()
        else:
            letter = rf"\mathrm{{{self._braced()}}}" if token == r"\mathrm" else self._next()
        assert re.fullmatch(r"[A-Za-z]|\\[A-Za-z]+|\\mathrm\{.*\}", letter), letter
        foot = ""
        if self._peek() == "_":
            foot = f"_{{{self._braced()}}}"
        return text + letter + foot, dots


def bare(latex):
    """A name in LaTeX as `Sheet` has it: (name, dots)."""
    sheet = Sheet({}, {})
    sheet.tokens, sheet.at = [t for t in TOKENS.findall(latex) if t not in SKIPPED], 0
    return sheet._name()
