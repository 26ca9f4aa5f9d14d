"""Drivetrains as FMUs: self-contained, with their C sources inside, and checked.

>>> import fmu_export
>>> fmu_export.export(rig, "rig.fmu")        # doctest: +SKIP
>>> print(fmu_export.check("rig.fmu"))       # doctest: +SKIP
"""

from fmu_export.checks.check_fmu import check
from fmu_export.checks.report import Item, Report
from fmu_export.exporter import export

__all__ = ["Item", "Report", "check", "export"]
