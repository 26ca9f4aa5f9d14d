"""A figure that a notebook shows once: as the value of its cell, or at the end of the cell by pyplot, but not twice."""

from __future__ import annotations

from typing import NoReturn, final

import matplotlib as mpl
from matplotlib import pyplot
from matplotlib.figure import Figure


@final
class NotebookFigure(Figure):
    """A figure of pyplot."""

    def _ipython_display_(self) -> NoReturn:
        """Asks for the usual picture (NotImplementedError); pyplot, which would show it once more, forgets the figure."""
        if "inline" in mpl.get_backend().lower():
            pyplot.close(self)
        raise NotImplementedError
