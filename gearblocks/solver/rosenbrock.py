"""Linearly implicit one-step methods as tables: Rosenbrock methods and the conditions that they satisfy.

A step of size h from y solves with one matrix, J being the Jacobian of f, and `s` stages K_j:

    (I - gamma h J) K_i = gamma (f(t + c_i h, y + h sum_j a_ij K_j) + sum_j coupling_ij K_j + h d_i df/dt)
    y_new = y + h sum_j b_j K_j

This is the form without products of matrix and vector of Hairer, Wanner, Solving Ordinary Differential Equations II,
2nd ed., 1996, IV.7, with K_j = U_j / h.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations_with_replacement

Weights = tuple[float, ...]
Tree = tuple["Tree", ...]
"""A rooted tree as the tuple of the trees that hang on its root."""


@dataclass(frozen=True, slots=True)
class Rosenbrock:
    """A stiffly accurate Rosenbrock method with an embedded error estimate and dense output.

    b is the last row of `a` with a 1 behind it, and the last stage estimates the error: both follow from stiff accuracy.

    dense: rows R_2, R_3, .. over the stages; with R_1 = h sum b_j K_j the solution inside the step is
        y0 + th (R1 + (1 - th) (R2 + th (R3 + (1 - th) (R4 + ...)))).
    nodes: points in (0, 1) at which quadratures along the step are sampled, beside 0 and 1; the Lobatto points.
    instants: points in (0, 1) at which what depends on time alone is known too, for its slope at 0.
    error_order: the power of the step size with which the estimate falls.
    beta: the memory of the step control (0: none).
    """

    name: str
    order: int
    source: str
    gamma: float
    c: Weights
    d: Weights
    a: tuple[Weights, ...]
    coupling: tuple[Weights, ...]
    dense: tuple[Weights, ...]
    nodes: Weights
    instants: Weights
    error_order: int
    beta: float = 0.0

    def __post_init__(self) -> None:
        problems = [*self._shape_problems()] or [*self._sum_problems(), *self._order_problems()]
        if problems:
            raise ValueError(f"Rosenbrock method '{self.name}': " + "; ".join(problems))

    @property
    def stages(self) -> int:
        """Stages, each one solution of a linear system."""
        return len(self.c)

    @property
    def all_stages(self) -> int:
        """With the derivative at the new point and those at the nodes."""
        return self.stages + 1 + len(self.nodes)

    @property
    def rows(self) -> int:
        """Rows of the dense polynomial."""
        return 1 + len(self.dense)

    @property
    def b(self) -> Weights:
        """Weights of the new point."""
        return (*self.a[-1], 1.0)

    @property
    def error_weights(self) -> tuple[Weights, ...]:
        """Weights of the error estimate."""
        return ((*(0.0,) * (self.stages - 1), 1.0),)

    @property
    def error_power(self) -> int:
        """`error_order`."""
        return self.error_order

    @property
    def all_c(self) -> Weights:
        """Abscissae of the stages, of the new point and of the nodes."""
        return (*self.c, 1.0, *self.nodes)

    @property
    def all_a(self) -> tuple[Weights, ...]:
        """Rows of the stages, of the new point and of the nodes, where the dense polynomial is taken."""
        return (*self.a, self.b, *map(self.weights_at, self.nodes))

    def weights_at(self, theta: float) -> Weights:
        """Weights w with y(t + theta h) = y + h sum_j w_j K_j."""
        rows = self.dense_weights()
        total = list(rows[-1][: self.stages])
        for m in reversed(range(self.rows - 1)):
            factor = 1 - theta if m % 2 == 0 else theta
            total = [rows[m][j] + factor * total[j] for j in range(self.stages)]
        return tuple(theta * x for x in total)

    def dense_weights(self) -> tuple[Weights, ...]:
        """Every dense row R_m / h as weights over all stages."""
        return tuple((*row, *(0.0,) * (self.all_stages - len(row))) for row in (self.b, *self.dense))

    def slope_weights(self) -> Weights:
        """Weights w of h du/dt = sum_j w_j u(t + c_j h) over the abscissae and then the instants: the slope at 0 of the
        polynomial through those that are well inside the step and apart (its end may be where a law jumps)."""
        every = (*self.all_c, *self.instants)
        used: list[float] = []
        for c in sorted(set(every)):
            if c < 0.9 and (not used or c - used[-1] > 0.03):
                used.append(c)
        slope = {}
        for c in used[1:]:
            others = [x for x in used[1:] if x != c]
            slope[c] = math.prod(-x / (c - x) for x in others) / c
        slope[0.0] = -math.fsum(slope.values())
        return tuple(slope.get(c, 0.0) if every.index(c) == j else 0.0 for j, c in enumerate(every))

    def quadrature_weights(self) -> tuple[Weights, ...]:
        """The rows R_m / h of a quadrature: the integral of the polynomial through the rates at 0, 1 and the nodes."""
        points = (0.0, 1.0, *self.nodes)
        out = [[0.0] * self.all_stages for _ in range(len(points))]
        for i in range(len(points)):
            integral = _integral_of_basis(points, i)
            p = [math.fsum(x * theta ** (k + 1) for k, x in enumerate(integral)) for theta in (0.5, 1.0)]
            start, end = float(i == 0), float(i == 1)
            r1, r2 = p[1], start - p[1]
            r3 = p[1] - end - r2
            half = (4 * p[0] - 2 * r1 - r2) * 2  # R3 + R4 / 2
            column = (0, self.stages)[i] if i < 2 else self.stages + i - 1
            for row, value in zip(out, (r1, r2, r3, 2 * (half - r3)), strict=False):
                row[column] = value
        return tuple(map(tuple, out))

    def angle_weights(self) -> tuple[Weights, ...]:
        """The rows R_m / h, without the speed w0 in the first one, of an angle with rate w, as weights over h K_j of the
        state w. An angle that were a state itself would have the stages K_i = gamma (w0 + h sum_j a_ij K_j(w) + sum_j
        coupling_ij K_j) + gamma h K_i(w), and its own weight of w0 is 1 in the first row and 0 in the others."""
        stages: list[Weights] = []
        for i, (a, coupling) in enumerate(zip(self.a, self.coupling, strict=True)):
            before = [math.fsum((c * row[j] for c, row in zip(coupling, stages, strict=True))) for j in range(i)]
            stages.append(
                (
                    *(self.gamma * (x + y) for x, y in zip(a, before, strict=True)),
                    self.gamma,
                    *(0.0,) * (self.stages - i - 1),
                )
            )
        return tuple(
            tuple(math.fsum(x * row[j] for x, row in zip(weights, stages, strict=True)) for j in range(self.stages))
            for weights in (_widen(row, self.stages) for row in (self.b, *self.dense))
        )

    def _shape_problems(self) -> list[str]:
        s = self.stages
        rows = (self.a, self.coupling)
        out = []
        if len(self.d) != s or any(len(row) != i for table in rows for i, row in enumerate(table)):
            out.append("row i of a and of coupling must have i entries, d one per stage")
        elif any(len(table) != s for table in rows) or any(len(row) > s for row in self.dense):
            out.append("a and coupling must have one row per stage, dense rows one weight per stage")
        elif self.rows != 4 or len(self.nodes) != 2:
            out.append("dense output needs four rows, quadratures two nodes")
        return out

    def matrices(self) -> tuple[list[list[float]], list[list[float]], list[float]]:
        """alpha, beta = alpha + Gamma and b of the form with products (the one in which order conditions are written).

        Gamma^-1 = I / gamma - coupling; alpha = a Gamma; the weights follow in the same way.
        """
        s, g = self.stages, self.gamma
        gammas = [[0.0] * s for _ in range(s)]
        for i in range(s):
            for j in range(i + 1):
                inner = math.fsum(self.coupling[i][k] * gammas[k][j] for k in range(j, i))
                gammas[i][j] = g * (inner + float(i == j))
        alpha = [[math.fsum(self.a[i][k] * gammas[k][j] for k in range(j, i)) for j in range(s)] for i in range(s)]
        beta = [[alpha[i][j] + gammas[i][j] for j in range(s)] for i in range(s)]
        b = [math.fsum(self.b[k] * gammas[k][j] for k in range(j, s)) for j in range(s)]
        return alpha, beta, b

    def residuals(self, theta: float = 1.0, order: int | None = None) -> Iterator[tuple[Tree, float]]:
        """Every tree up to the order and by how much its condition is missed, at the end or at theta in the step."""
        alpha, beta, b = self.matrices()
        if theta != 1.0:
            weights, gammas = (
                self.weights_at(theta),
                [[x - y for x, y in zip(*rows, strict=True)] for rows in zip(beta, alpha, strict=True)],
            )
            b = [math.fsum(weights[k] * gammas[k][j] for k in range(j, self.stages)) for j in range(self.stages)]
        for size in range(1, (order or self.order) + 1):
            for tree in trees(size):
                value = math.fsum(x * y for x, y in zip(b, _elementary(tree, alpha, beta), strict=True))
                yield tree, value - theta**size / _density(tree)

    def damping_at_infinity(self) -> float:
        """R(infinity) = 1 - b' beta^-1 1 of the stability function: 0 for an L-stable method."""
        _, beta, b = self.matrices()
        x: list[float] = []
        for i in range(self.stages):
            x.append((1.0 - math.fsum(beta[i][j] * x[j] for j in range(i))) / beta[i][i])
        return 1.0 - math.fsum(p * q for p, q in zip(b, x, strict=True))

    def _sum_problems(self) -> list[str]:
        alpha, beta, b = self.matrices()
        out = []
        for i in range(self.stages):
            for what, row, want in (("alpha", alpha[i], self.c[i]), ("beta", beta[i], self.c[i] + self.d[i])):
                if abs(math.fsum(row) - want) > 1e-12:
                    out.append(f"row {i} of {what} sums to {math.fsum(row)!r}, not {want!r}")
        if abs(self.c[-1] - 1.0) > 0.0 or any(abs(x - y) > 1e-12 for x, y in zip(b, beta[-1], strict=True)):
            out.append("not stiffly accurate: the last row of beta is not b")
        if abs(self.damping_at_infinity()) > 1e-12:
            out.append(f"R(infinity) is {self.damping_at_infinity()!r}, not 0")
        return out

    def _order_problems(self) -> list[str]:
        worst = max(self.residuals(), key=lambda item: abs(item[1]))
        return [] if abs(worst[1]) <= 1e-12 else [f"the condition of tree {worst[0]} is missed by {worst[1]:.1e}"]


def _widen(row: Weights, length: int) -> Weights:
    return (*row, *(0.0,) * (length - len(row)))


def _integral_of_basis(points: Weights, i: int) -> list[float]:
    """Coefficients of theta, theta^2, .. of the integral of the Lagrange polynomial that is 1 at points[i]."""
    poly = [1.0]
    for j, point in enumerate(points):
        if j != i:
            scale = 1.0 / (points[i] - point)
            low, high = [-point * x for x in poly] + [0.0], [0.0, *poly]
            poly = [scale * (x + y) for x, y in zip(low, high, strict=True)]
    return [x / (k + 1) for k, x in enumerate(poly)]


def trees(size: int) -> Iterator[Tree]:
    """All rooted trees with that many nodes."""

    def forests(left: int, largest: int) -> Iterator[Tree]:
        if left == 0:
            yield ()
        for first in range(min(left, largest), 0, -1):
            for count in range(left // first, 0, -1):
                for group in combinations_with_replacement(tuple(trees(first)), count):
                    for rest in forests(left - first * count, first - 1):
                        yield (*group, *rest)

    yield from forests(size - 1, size - 1)


def _nodes(tree: Tree) -> int:
    return 1 + sum(map(_nodes, tree))


def _density(tree: Tree) -> int:
    return _nodes(tree) * math.prod(map(_density, tree))


def _elementary(tree: Tree, alpha: list[list[float]], beta: list[list[float]]) -> list[float]:
    """Elementary weights by stage: a single branch goes through beta, several go through alpha (Hairer, Wanner IV.7)."""
    matrix = beta if len(tree) == 1 else alpha
    columns = [_elementary(branch, alpha, beta) for branch in tree]
    return [
        math.prod(math.fsum(x * y for x, y in zip(row, column, strict=True)) for column in columns) for row in matrix
    ]


def _rows(text: str) -> tuple[Weights, ...]:
    """Rows of numbers, parted by semicolons."""
    return tuple(tuple(map(float, row.split())) for row in text.split(";"))


def _from_powers(first: Weights, second: Weights, third: Weights) -> tuple[Weights, ...]:
    """R2, R3, R4 from the published form y0 (1 - th) + th (y1 + (1 - th) (H1 + th (H2 + th H3)))."""
    return first, tuple(x + y for x, y in zip(second, third, strict=True)), tuple(-x for x in third)


_NEW = (-7.502846399306121, 2.561846144803919, -11.627539656261098, -0.18268767659942256, 0.030198172008377946)

RODAS = Rosenbrock(
    name="Rodas5P 5(4)",
    order=5,
    source="Steinebach 2023, Construction of Rosenbrock-Wanner method Rodas5P, doi:10.1007/s10543-023-00967-x",
    gamma=0.21193756319429014,
    c=(0, 0.6358126895828704, 0.4095798393397535, 0.9769306725060716, 0.4288403609558664, 1, 1, 1),
    d=(0.21193756319429014, -0.42387512638858027, -0.3384627126235924, 1.8046452872882734, 2.325825639765069, 0, 0, 0),
    a=(
        (),
        *_rows(
            """
            3 ;
            2.849394379747939 0.45842242204463923 ;
            -6.954028509809101 2.489845061869568 -10.358996098473584 ;
            2.8029986275628964 0.5072464736228206 -0.3988312541770524 -0.04721187230404641
            """
        ),
        _NEW,
        (*_NEW, 1.0),
        (*_NEW, 1.0, 1.0),
    ),
    coupling=(
        (),
        *_rows(
            """
            -14.155112264123755 ;
            -17.97296035885952 -2.859693295451294 ;
            147.12150275711716 -1.41221402718213 71.68940251302358 ;
            165.43517024871676 -0.4592823456491126 42.90938336958603 -5.961986721573306 ;
            24.854864614690072 -3.0009227002832186 47.4931110020768 5.5814197821558125 -0.6610691825249471 ;
            30.91273214028599 -3.1208243349937974 77.79954646070892 34.28646028294783 -19.097331116725623
            -28.087943162872662 ;
            37.80277123390563 -3.2571969029072276 112.26918849496327 66.9347231244047 -40.06618937091002
            -54.66780262877968 -9.48861652309627
            """
        ),
    ),
    dense=_from_powers(
        *_rows(
            """
            25.948786856663858 -2.5579724845846235 10.433815404888879 -2.3679251022685204 0.524948541321073
            1.1241088310450404 0.4272876194431874 -0.17202221070155493 ;
            -9.91568850695171 -0.9689944594115154 3.0438037242978453 -24.495224566215796 20.176138334709044
            15.98066361424651 -6.789040303419874 -6.710236069923372 ;
            11.419903575922262 2.8879645146136994 72.92137995996029 80.12511834622643 -52.072871366152654
            -59.78993625266729 -0.15582684282751913 4.883087185713722
            """
        )
    ),
    nodes=((5 - math.sqrt(5)) / 10, (5 + math.sqrt(5)) / 10),
    instants=(0.05, 0.15),
    error_order=5,
    beta=0.04,
)
