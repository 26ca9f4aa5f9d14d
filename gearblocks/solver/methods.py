"""One-step methods as tables, and the C header that holds them.

A method is a frozen `Tableau`; `render_tables` writes all of `METHODS` as constant tables for the solver core.
A further method of the same kind (explicit, one step, embedded error) is one more entry here and no line of C.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from importlib.resources import files

from gearblocks.solver.rosenbrock import RODAS, Rosenbrock

Weights = tuple[float, ...]

MAX_STAGES = 16  # GB_STAGES in gb_internal.h
MAX_ROWS = 8  # GB_ROWS in gb_internal.h


@dataclass(frozen=True, slots=True)
class Tableau:
    """An explicit Runge-Kutta pair with dense output.

    The stages of the step are `c`, `a`; their weights `b`. The derivative at the new point follows as one stage
    more (it is the first stage of the next step), then the stages `extra_c`, `extra_a` that only dense output needs.

    errors: weights of one or two error estimates over the step's stages, optionally with the derivative at the new
        point. Two estimates e5, e3 are joined as e5^2 / sqrt(e5^2 + 0.01 e3^2). Empty: taken from `b_hat`.
    error_order: the power of the step size with which the joined estimate falls.
    dense: rows beyond the cubic Hermite polynomial, over all stages. With R1 = h sum b_j K_j, R2 = h K_1 - R1,
        R3 = R1 - h K_new - R2 and R_m = h sum_j dense[m - 4][j] K_j the solution inside the step is
        y0 + th (R1 + (1 - th) (R2 + th (R3 + (1 - th) (R4 + ...)))).
    beta: the memory of the step control (0: none).
    reach: the largest step size times rate, abs(h lambda), up to which estimate and dense polynomial tell the error, if that
        is less than where the method is stable (0: they do wherever it is). Needs a stage at the end of the step.
    defect: (theta, factor): the error of the dense polynomial inside the step is about factor h times its defect at theta,
        for stiff, vibrating and forced motions alike (factor 0: not known).
    """

    name: str
    order: int
    source: str
    c: Weights
    a: tuple[Weights, ...]
    b: Weights
    b_hat: Weights = ()
    errors: tuple[Weights, ...] = ()
    error_order: int = 0
    extra_c: Weights = ()
    extra_a: tuple[Weights, ...] = ()
    dense: tuple[Weights, ...] = ()
    beta: float = 0.0
    reach: float = 0.0
    defect: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        problems = [*self._shape_problems(), *self._sum_problems()]
        if problems:
            raise ValueError(f"tableau '{self.name}': " + "; ".join(problems))

    @property
    def stages(self) -> int:
        """Stages of the step, without the derivative at the new point."""
        return len(self.c)

    @property
    def all_stages(self) -> int:
        """With the derivative at the new point and the stages of dense output."""
        return len(self.c) + 1 + len(self.extra_c)

    @property
    def rows(self) -> int:
        """Rows of the dense polynomial: three of Hermite and those of `dense`."""
        return 3 + len(self.dense)

    @property
    def error_weights(self) -> tuple[Weights, ...]:
        """Weights of the error estimates, each over the step's stages and the new point."""
        width = self.stages + 1
        if self.errors:
            return tuple(_widen(row, width) for row in self.errors)
        b, b_hat = _widen(self.b, width), _widen(self.b_hat, width)
        return (tuple(x - y for x, y in zip(b, b_hat, strict=True)),)

    @property
    def error_power(self) -> int:
        """`error_order`, by default the order of the method."""
        return self.error_order or self.order

    @property
    def all_c(self) -> Weights:
        """Abscissae of all stages in the order in which they are computed."""
        return (*self.c, 1.0, *self.extra_c)

    @property
    def all_a(self) -> tuple[Weights, ...]:
        """Rows of all stages in the order in which they are computed."""
        return (*self.a, self.b, *self.extra_a)

    def dense_weights(self) -> tuple[Weights, ...]:
        """Every dense row R_m / h as weights over all stages."""
        width, last = self.all_stages, self.stages
        r1 = _widen(self.b, width)
        r2 = tuple((1.0 if j == 0 else 0.0) - r1[j] for j in range(width))
        r3 = tuple(r1[j] - (1.0 if j == last else 0.0) - r2[j] for j in range(width))
        return (r1, r2, r3, *(_widen(row, width) for row in self.dense))

    def _shape_problems(self) -> list[str]:
        out = []
        if len(self.a) != self.stages or len(self.b) != self.stages or len(self.extra_a) != len(self.extra_c):
            out.append("c, a and b must have one entry per stage, extra_a one row per extra_c")
        if any(len(row) > i for i, row in enumerate(self.all_a)):
            out.append("a stage may use earlier stages only")
        if self.all_stages > MAX_STAGES or self.rows > MAX_ROWS:
            out.append(f"at most {MAX_STAGES} stages and {MAX_ROWS} dense rows fit")
        if self.reach and 1.0 not in self.c:
            out.append("a reach needs a stage at the end of the step, c = 1")
        if not self.b_hat and not self.errors:
            out.append("an error estimate is needed: b_hat or errors")
        if any(len(row) > self.stages + 1 for row in (self.b_hat, *self.errors)) or len(self.errors) > 2:
            out.append("one or two error estimates over the step's stages and the new point")
        if any(len(row) > self.all_stages for row in self.dense):
            out.append("dense rows must not be longer than all stages")
        return out

    def _sum_problems(self) -> list[str]:
        out = []
        for i, (c, row) in enumerate(zip(self.all_c, self.all_a, strict=False)):
            if abs(math.fsum(row) - c) > 2e-14:
                out.append(f"row {i} of a sums to {math.fsum(row)!r}, c is {c!r}")
        if abs(math.fsum(self.b) - 1.0) > 2e-14:
            out.append(f"b sums to {math.fsum(self.b)!r}, not 1")
        for row in (*self.error_weights, *self.dense):
            if abs(math.fsum(row)) > 1e-15 * max(1.0, max(map(abs, row))) * 100:
                out.append(f"weights {row[:3]}... sum to {math.fsum(row)!r}, not 0")
        return out


def _widen(row: Weights, width: int) -> Weights:
    return (*row, *(0.0,) * (width - len(row)))


def _rows(text: str) -> tuple[Weights, ...]:
    """Rows of numbers, parted by semicolons."""
    return tuple(tuple(map(float, row.split())) for row in text.split(";"))


RK4 = Tableau(
    name="classical Runge-Kutta 4(3)",
    order=4,
    source="Kutta 1901; the estimate replaces the last stage by the derivative at the new point",
    c=(0, 1 / 2, 1 / 2, 1),
    a=((), (1 / 2,), (0, 1 / 2), (0, 0, 1)),
    b=(1 / 6, 1 / 3, 1 / 3, 1 / 6),
    b_hat=(1 / 6, 1 / 3, 1 / 3, 0, 1 / 6),
    error_order=4,
)

DP5 = Tableau(
    name="Dormand-Prince 5(4)",
    order=5,
    source="Dormand, Prince 1980, doi:10.1016/0771-050X(80)90013-3; dense output: Hairer, Norsett, Wanner 1993, II.6",
    c=(0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1),
    a=(
        (),
        (1 / 5,),
        (3 / 40, 9 / 40),
        (44 / 45, -56 / 15, 32 / 9),
        (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
        (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
    ),
    b=(35 / 384, 0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84),
    b_hat=(5179 / 57600, 0, 7571 / 16695, 393 / 640, -92097 / 339200, 187 / 2100, 1 / 40),
    error_order=5,
    dense=(
        (
            -12715105075 / 11282082432,
            0,
            87487479700 / 32700410799,
            -10690763975 / 1880347072,
            701980252875 / 199316789632,
            -1453857185 / 822651844,
            69997945 / 29380423,
        ),
    ),
    beta=0.04,
    defect=(0.65, 0.3),
)

DP8 = Tableau(
    name="Dormand-Prince 8(5,3)",
    order=8,
    error_order=8,
    source="DOP853: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, 2nd ed., 1993, II.5 and II.6",
    c=_rows(
        """
        0 0.05260015195876773 0.0789002279381516 0.1183503419072274 0.2816496580927726 0.3333333333333333 0.25
        0.3076923076923077 0.6512820512820513 0.6 0.8571428571428571 1.0
        """
    )[0],
    a=(
        (),
        *_rows(
            """
            0.05260015195876773 ;
            0.0197250569845379 0.0591751709536137 ;
            0.02958758547680685 0 0.08876275643042054 ;
            0.2413651341592667 0 -0.8845494793282861 0.924834003261792 ;
            0.037037037037037035 0 0 0.17082860872947386 0.12546768756682242 ;
            0.037109375 0 0 0.17025221101954405 0.06021653898045596 -0.017578125 ;
            0.03709200011850479 0 0 0.17038392571223998 0.10726203044637328 -0.015319437748624402
            0.008273789163814023 ;
            0.6241109587160757 0 0 -3.3608926294469414 -0.868219346841726 27.59209969944671 20.154067550477894
            -43.48988418106996 ;
            0.47766253643826434 0 0 -2.4881146199716677 -0.590290826836843 21.230051448181193 15.279233632882423
            -33.28821096898486 -0.020331201708508627 ;
            -0.9371424300859873 0 0 5.186372428844064 1.0914373489967295 -8.149787010746927 -18.52006565999696
            22.739487099350505 2.4936055526796523 -3.0467644718982196 ;
            2.273310147516538 0 0 -10.53449546673725 -2.0008720582248625 -17.9589318631188 27.94888452941996
            -2.8589982771350235 -8.87285693353063 12.360567175794303 0.6433927460157636
            """
        ),
    ),
    b=_rows(
        """
        0.054293734116568765 0 0 0 0 4.450312892752409 1.8915178993145003 -5.801203960010585 0.3111643669578199
        -0.1521609496625161 0.20136540080403034 0.04471061572777259
        """
    )[0],
    reach=4.0,
    defect=(0.65, 0.13),
    errors=_rows(
        """
        0.01312004499419488 0 0 0 0 -1.2251564463762044 -0.4957589496572502 1.6643771824549864 -0.35032884874997366
        0.3341791187130175 0.08192320648511571 -0.022355307863886294 ;
        -0.18980075407240762 0 0 0 0 4.450312892752409 1.8915178993145003 -5.801203960010585 -0.4226823213237919
        -0.1521609496625161 0.20136540080403034 0.02265179219836082
        """
    ),
    extra_c=(0.1, 0.2, 0.7777777777777778),
    extra_a=_rows(
        """
        0.056167502283047954 0 0 0 0 0 0.25350021021662483 -0.2462390374708025 -0.12419142326381637
        0.15329179827876568 0.00820105229563469 0.007567897660545699 -0.008298 ;
        0.03183464816350214 0 0 0 0 0.028300909672366776 0.053541988307438566 -0.05492374857139099 0 0
        -0.00010834732869724932 0.0003825710908356584 -0.00034046500868740456 0.1413124436746325 ;
        -0.42889630158379194 0 0 0 0 -4.697621415361164 7.683421196062599 4.06898981839711 0.3567271874552811 0 0 0
        -0.0013990241651590145 2.9475147891527724 -9.15095847217987
        """
    ),
    dense=_rows(
        """
        -8.428938276109013 0 0 0 0 0.5667149535193777 -3.0689499459498917 2.38466765651207 2.117034582445028
        -0.871391583777973 2.2404374302607883 0.6315787787694688 -0.08899033645133331 18.148505520854727
        -9.194632392478356 -4.436036387594894 ;
        10.427508642579134 0 0 0 0 242.28349177525817 165.20045171727028 -374.5467547226902 -22.113666853125306
        7.733432668472264 -30.674084731089398 -9.332130526430229 15.697238121770845 -31.139403219565178
        -9.35292435884448 35.81684148639408 ;
        19.985053242002433 0 0 0 0 -387.0373087493518 -189.17813819516758 527.8081592054236 -11.57390253995963
        6.8812326946963 -1.0006050966910838 0.7777137798053443 -2.778205752353508 -60.19669523126412
        84.32040550667716 11.99229113618279 ;
        -25.69393346270375 0 0 0 0 -154.18974869023643 -231.5293791760455 357.6391179106141 93.40532418362432
        -37.45832313645163 104.0996495089623 29.8402934266605 -43.53345659001114 96.32455395918828 -39.17726167561544
        -149.72683625798564
        """
    ),
)

METHODS: tuple[Tableau | Rosenbrock, ...] = (RK4, DP5, DP8, RODAS)  # the order of GB_RK4 .. GB_RODAS in gb_core.h


@dataclass(frozen=True, slots=True)
class _Sparse:
    """The non-zero entries of one row of weights."""

    index: tuple[int, ...]
    value: Weights


def _sparse(row: Weights) -> _Sparse:
    entries = [(j, float(x)) for j, x in enumerate(row) if x != 0]
    return _Sparse(tuple(j for j, _ in entries), tuple(x for _, x in entries))


def _quadrature_rows(method: Tableau | Rosenbrock) -> tuple[Weights, ...]:
    """The dense rows of the quadratures: of an implicit method those through the rates at its nodes."""
    return method.quadrature_weights() if isinstance(method, Rosenbrock) else method.dense_weights()


def _is_implicit(method: Tableau | Rosenbrock) -> bool:
    return isinstance(method, Rosenbrock)


def _full_stages(method: Tableau | Rosenbrock) -> tuple[int, ...]:
    """1 for every stage that a weight of the step or of dense output reads: there the quadratures are computed too."""
    used = list(_quadrature_rows(method))
    if isinstance(method, Tableau):
        used.append(_widen(method.b, method.all_stages))
    return tuple(int(any(row[j] != 0 for row in used)) for j in range(method.all_stages))


def render_tables() -> str:
    """Text of gb_methods.h: every method of `METHODS` as one constant table. The same bytes on every call."""
    import jinja2

    template = (files("gearblocks.solver") / "c" / "gb_methods.h.jinja").read_text(encoding="utf-8")
    environment = jinja2.Environment(trim_blocks=True, lstrip_blocks=True, undefined=jinja2.StrictUndefined)
    environment.globals.update(
        zip=zip,
        sparse=_sparse,
        widen=_widen,
        full_stages=_full_stages,
        quadrature_rows=_quadrature_rows,
        implicit=_is_implicit,
    )
    text = environment.from_string(template).render(methods=METHODS, width=MAX_STAGES)
    return text if text.endswith("\n") else text + "\n"
