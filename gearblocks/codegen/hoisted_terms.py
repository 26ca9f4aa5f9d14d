"""Parameter terms and time terms of all batches: their offsets and the statements that compute them.

Parameter terms are computed once, time terms once per instant; those that read no number of an instance are shared by all
batches. Knows nothing of which parts of a law are hoisted.
"""

from __future__ import annotations

from gearblocks.codegen.batch import BatchCode
from gearblocks.codegen.comments import of_expression
from gearblocks.codegen.generator import Generator
from gearblocks.codegen.hoisting import HoistedTerm
from gearblocks.codegen.mean_excitation import mean_of_term
from gearblocks.codegen.operands import Assignment, Operand, Role, Statement
from gearblocks.codegen.rounding_of_terms import size_of_term
from gearblocks.laws.symbols import CONSTANT


def lay_out_terms(g: Generator, code: BatchCode) -> None:
    """Gives the hoisted terms of a batch their offsets and keeps the functions that fill them.

    Everything that asks for a term must have been hoisted: predictions, gap scales and directions too.
    """
    for i in range(len(code.events.sorts)):
        code.events.read(i)
    prepare: list[Assignment] = []
    times: dict[bool, list[Assignment]] = {False: [], True: []}
    means: list[Assignment] = []
    sizes: list[Assignment] = []
    moving = code.moving_terms({path.rpartition(".")[2] for path in g.feedback})
    inner = {c.symbol: c.expr for c in code.hoister.terms}
    for item in code.hoister.terms:
        words = of_expression(item.expr, inner, code.offsets.tables)
        outputs_only = item.symbol not in moving
        if item.shared:
            found = _shared(g, code, item, words)
            code.offsets.hoisted[item.symbol] = found
            if not outputs_only:
                g.of_rates.add(found)
        elif item.level == CONSTANT:
            found = code.offsets.hoisted[item.symbol] = Operand(Role.PARAMETERS, g.n_par, instance=True)
            prepare.append(Assignment(found, "=", item.expr, words=words))
            g.n_par += code.n
        else:
            found = code.offsets.hoisted[item.symbol] = Operand(Role.TIME_TERMS, g.n_time, instance=True)
            times[outputs_only].append(Assignment(found.of_lane(), "=", item.expr, words=words))
            means.append(Assignment(found.of_lane(), "=", mean_of_term(code, item)))
            size = None if outputs_only else size_of_term(code.hoister, item)
            if size is not None:
                sizes.append(Assignment(found.of_lane(), "=", size))
            g.n_time += code.n
    g.keep("prepare", code.function("prepare", prepare))
    g.keep("time_terms", code.function("time_terms", times[False], vector=Role.TIME_TERMS))
    g.keep("output_time_terms", code.function("output_time_terms", times[True], vector=Role.TIME_TERMS))
    g.keep("mean_time_terms", code.function("mean_time_terms", means, vector=Role.TIME_TERMS))
    g.keep("time_term_sizes", code.function("time_term_sizes", sizes, vector=Role.TIME_TERMS))


def _shared(g: Generator, code: BatchCode, item: HoistedTerm, words: str) -> Operand:
    """The offset of a term that all instances share; equal ones of several batches are one."""
    text = code.names([item.expr], vector=Role.TIME_TERMS).print(item.expr)
    key = (item.level, text)
    if key in g.shared:
        return g.shared[key]
    if item.level == CONSTANT:
        found = g.shared[key] = Operand(Role.PARAMETERS, g.n_par)
        g.prepare_shared.append(Statement(found, "=", text, words=words))
        g.n_par += 1
        return found
    found = g.shared[key] = Operand(Role.TIME_TERMS, g.n_time)
    g.times_shared.append((found, Statement(found.of_lane(), "=", text, words=words)))
    for expr, kept in ((mean_of_term(code, item), g.means_shared), (size_of_term(code.hoister, item), g.sizes_shared)):
        if expr is not None:
            kept.append(Statement(found.of_lane(), "=", code.names([expr], vector=Role.TIME_TERMS).print(expr)))
    g.n_time += 1
    return found
