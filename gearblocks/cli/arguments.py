"""Arguments that several commands of the shell take."""

from __future__ import annotations

from typing import Annotated

import typer

Train = Annotated[str, typer.Argument(metavar="FILE[:NAME]", help="A script or shipped model; NAME: a function in it.")]
