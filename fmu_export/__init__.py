"""Drivetrains as FMUs: self-contained, with their C sources inside, and checked.

>>> import fmu_export
>>> fmu_export.export(rig, "rig.fmu")        # doctest: +SKIP
>>> print(fmu_export.check("rig.fmu"))       # doctest: +SKIP

A name is imported with its module when it is first used: the process that checks a file needs no exporter.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fmu_export.checks.check_fmu import check
    from fmu_export.checks.report import Item, Report
    from fmu_export.exporter import export

__all__ = ["Item", "Report", "check", "export"]

_HOME = {"Item": "checks.report", "Report": "checks.report", "check": "checks.check_fmu", "export": "exporter"}


def __getattr__(name: str) -> Any:
    """A public name, when it is first used."""
    if name not in _HOME:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    value = getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """The public names, whether used or not."""
    return sorted({*globals(), *__all__})
