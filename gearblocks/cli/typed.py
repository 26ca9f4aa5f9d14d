"""What is wrong with how a command was typed: told with what belongs there and one call that is right."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import typer

from gearblocks.cli.terminal import complain

EXAMPLES = {
    "check": "gearblocks check rig.fmu",
    "copy": "gearblocks copy spline_coupling",
    "cost": "gearblocks cost gear_pair:whine",
    "describe": "gearblocks describe rig.py",
    "draw": "gearblocks draw rig.py -o rig.svg",
    "effects": "gearblocks effects gear_pair:whine",
    "equations": "gearblocks equations rig.py --format latex",
    "export": "gearblocks export rig.py -o rig.fmu",
    "inputs": "gearblocks inputs rig.py",
    "new": "gearblocks new rig.py",
    "outputs": "gearblocks outputs rig.py 'mesh.*'",
    "parameters": "gearblocks parameters rig.py",
    "run": "gearblocks run rig.py --t-end 0.5",
    "sweep": "gearblocks sweep rig.py --over mesh.k=1e8:3e8:5",
}
"""A call of every command that needs something."""


def called(app: typer.Typer, arguments: Sequence[str] | None) -> int:
    """The status of a command. Raises what it raises; a slip in how it was typed is told, with status 2."""
    try:
        status: Any = app(
            args=None if arguments is None else list(arguments), prog_name="gearblocks", standalone_mode=False
        )
    except typer.Abort:
        complain("stopped")
        return 1
    except Exception as error:  # of the click that comes with typer or beside it, by version
        if not hasattr(error, "format_message") or not hasattr(error, "show"):
            raise
        slip: Any = error
        command = getattr(getattr(slip, "ctx", None), "info_name", None) or ""
        example = f"; for example: {EXAMPLES[command]}" if command in EXAMPLES else ""
        missing = getattr(slip, "param", None) if type(slip).__name__ == "MissingParameter" else None
        if missing is None:
            slip.show()
            if example:
                complain(example.removeprefix("; "))
        else:
            complain(f"{command}: {_words(missing)} is missing{example}")
        return int(slip.exit_code)
    return status if isinstance(status, int) else 0


def _words(parameter: Any) -> str:
    """An argument or option as it is typed, and what it is."""
    name = parameter.metavar or parameter.name
    if parameter.param_type_name == "option":
        name = f"{'/'.join(parameter.opts)} {name}" if parameter.metavar else "/".join(parameter.opts)
    words = (getattr(parameter, "help", "") or "").strip().rstrip(".")
    return f"{name} ({words[:1].lower()}{words[1:]})" if words else name
