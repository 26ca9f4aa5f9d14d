"""What in a train is possible and yet hardly meant, in words: values beyond what their field expects or out of proportion
(`proportions`), parts that are joined to nothing, stiffnesses below zero within their cycle, natural frequencies above 1 MHz.

The largest natural frequency w of a train has a bound from below by each spring alone (Rayleigh's quotient):

    w^2 >= k g' M^-1 g        g: the deflection per speed, M: inertias of the rigid groups that it joins

so that no mode has to be computed. Springs at massless or dependent groups are left out. Knows nothing of runs.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from gearblocks.errors import GearblocksError
from gearblocks.language.block import Block
from gearblocks.language.expression import Expr, as_expr, evaluate
from gearblocks.language.fields import COMPLIANCE
from gearblocks.language.signals import Table
from gearblocks.model.build import check_user_blocks
from gearblocks.model.open_starts import open_starts
from gearblocks.model.proportions import inertias_out_of_proportion, out_of_proportion
from gearblocks.model.single_springs import inertias, is_stiffness, mobility, stiffnesses
from gearblocks.train.graph import Train, Tree, blocks_of, flatten
from gearblocks.train.plausibility import unusual
from gearblocks.train.summary import field_texts

HIGHEST = 1e6
"""Natural frequency [Hz] above which a spring is too stiff, or an inertia too small, to be meant."""


def implausible(tree: Tree) -> Iterator[str]:
    """Each thing as one sentence, with what it may have been meant to be."""
    blocks = list(blocks_of(tree))
    for path, block in blocks:
        yield from unusual(path, block)
        yield from out_of_proportion(path, block)
        yield from _negative(path, block)
    yield from inertias_out_of_proportion(tree)
    if len(blocks) > 1:
        yield from _alone(tree)
    try:
        train = flatten(tree)
        check_user_blocks(train)
        yield from _too_stiff(train)
    except GearblocksError:
        return  # it is not finished, or cannot be built; what is wrong is said there


def described(tree: Tree, effects: int) -> str:
    """A table of all blocks with their values, how many effects they have, and what is hardly meant."""
    slides = {c.path: c.slides for c in (flatten(tree, complete=False).components if tree.parts else ())}
    rows = [
        (path, type(block).__name__, ", ".join(field_texts(block, slides.get(path, False))))
        for path, block in blocks_of(tree)
    ]
    widths = [max((len(r[i]) for r in rows), default=0) for i in range(2)]
    blocks, more = f"{len(rows)} block{'s' * (len(rows) != 1)}", f"{effects} effect{'s' * (effects != 1)}"
    head = f"{tree.name}: {blocks}, {more}"
    doubts = [f"is it meant? {words}" for words in implausible(tree)]
    doubts += open_starts(tree)
    return "\n".join([head, *(f"  {a:<{widths[0]}}  {b:<{widths[1]}}  {c}" for a, b, c in rows), *doubts])


# -- stiffness below zero ---------------------------------------------------------------------------------------------


def _negative(path: str, block: Block) -> Iterator[str]:
    """Stiffnesses over time or an angle that fall below zero somewhere; where inputs decide, nothing is known."""
    for name, spec in type(block).fields.items():
        value = block.__dict__[name]
        if isinstance(value, (Table, Expr)) and is_stiffness(spec):
            least, at = _least(value)
            if least < 0:
                yield (
                    f"{path}.{name} ({spec.words}) falls to {least:.4g} {spec.unit} at {at}, below zero, where it drives "
                    "its ends apart; let it stay above 0"
                )


def _least(value: Table | Expr) -> tuple[float, str]:
    """The least value found and where: at the points of a table, else on grids of time and of the angle."""
    if isinstance(value, Table):
        x = np.unique(np.concatenate([value.x, np.linspace(value.x[0], value.x[-1], 721)]))
        values = value.values(x)
        return float(values.min()), f"{x[values.argmin()]:.4g}"
    leaves = {leaf.op for leaf in value.leaves()}
    if leaves & {"input", "sense", "table2"}:
        return 0.0, ""
    if "local" in leaves:
        grid, unit = np.linspace(0.0, 8 * math.pi, 1441), "rad"
    else:
        grid, unit = np.concatenate([np.linspace(0.0, end, 361) for end in (1e-3, 1e-2, 0.1, 1.0, 10.0)]), "s"
    found = [_at(value, float(x)) for x in grid]
    least = int(np.nanargmin(found)) if not np.isnan(found).all() else 0
    return (found[least] if math.isfinite(found[least]) else 0.0), f"{grid[least]:.4g} {unit}"


def _at(value: Expr, x: float) -> float:
    """The value where time, and what the block itself knows, is x."""

    def leaf(e: Expr) -> float:
        if e.op == "parameter":
            return float(e.args[0].si)
        return float(e.args[0].values(_at(as_expr(e.args[1]), x))) if e.op == "table" else x

    try:
        return evaluate(value, leaf)
    except (ArithmeticError, ValueError):
        return math.nan


# -- parts that are joined to nothing ---------------------------------------------------------------------------------


def _alone(tree: Tree, prefix: str = "") -> Iterator[str]:
    """Parts of which no flange is joined to another one, in trains inside too."""
    joined = {end for link in tree.links for end in link} | {end for _, end in tree.exposed}
    for name, part in tree.parts:
        flanges = [*(type(part).flanges if isinstance(part, Block) else dict(part.exposed))]
        if flanges and not any((name, flange) in joined for flange in flanges):
            ways = " or ".join(f"{prefix}{name}.{flange}" for flange in flanges)
            yield f"'{prefix}{name}' is joined to nothing and moves by itself; connect {ways}"
        if isinstance(part, Tree):
            yield from _alone(part, f"{prefix}{name}.")


# -- natural frequencies ----------------------------------------------------------------------------------------------


def _too_stiff(train: Train) -> Iterator[str]:
    """Springs that alone give a natural frequency above HIGHEST."""
    if not any(is_stiffness(spec) for c in train.components for spec in type(c.block).fields.values()):
        return
    from gearblocks.assembly.assemble import assemble

    assembly = assemble(train)
    inertia = inertias(assembly)
    for batch in assembly.batches:
        for e, index in enumerate(batch.components):
            c = train.components[index]
            for name, k in stiffnesses(c):
                frequency = math.sqrt(k * mobility(assembly, batch, e, c, inertia)) / (2 * math.pi)
                if frequency > HIGHEST:
                    yield (
                        f"{c.path}.{name} = {k:.4g} on the inertias beside it gives a natural frequency of "
                        f"{frequency / 1e6:.3g} MHz, above 1 MHz, which costs steps and tells nothing; look at the units of "
                        f'both, or leave it out: rig.without("{c.path}.{COMPLIANCE}")'
                    )
