"""Pages from templates."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gearblocks.equations.equations import Equations


def page(template: str, **values: Any) -> str:
    """Text of a template of this folder, filled; plain values are escaped, markupsafe ones are not."""
    import jinja2

    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("gearblocks.cli", "report"),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    return environment.get_template(template).render(**values)


def equations_page(equations: Equations) -> str:
    """The equations of a train as a page that a browser shows without a network."""
    from markupsafe import Markup

    from gearblocks.cli.report.mathml import mathml
    from gearblocks.equations.switched_constraints import Sentence

    def shown(expr: Any) -> Markup:
        if isinstance(expr, Sentence):
            return Markup("").join(x if isinstance(x, str) else shown(x) for x in expr.parts)
        return Markup(mathml(expr, equations.latex_of))

    return page(
        "equations.html.jinja",
        title=f"Equations of motion: {equations.name}",
        sections=[(heading, [shown(one) for one in part]) for heading, part in equations.sections()],
        symbols=[(shown(symbol), path) for symbol, path in equations.parameters.items()],
    )
