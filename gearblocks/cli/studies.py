"""What `gearblocks sweep` reads from its options, and the files it writes."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gearblocks.errors import ParameterError, UnknownNameError, did_you_mean
from gearblocks.files import check_place as place_of_file
from gearblocks.language.units import number_and_unit

if TYPE_CHECKING:
    from gearblocks.analysis.study_result import Study
    from gearblocks.codegen.program import Program

_RANGE = re.compile(r"\s*([^=\s]+)\s*=\s*([^:]+):([^:]+):([^:]+)")
ENDINGS = (".csv", ".nc", ".zarr", ".png", ".svg", ".pdf")


def grid(texts: Sequence[str]) -> dict[str, Any]:
    """Values by path of options such as path=from:to:n, evenly spaced with both ends."""
    import numpy as np

    values: dict[str, Any] = {}
    for text in texts:
        found = _RANGE.fullmatch(text)
        try:
            if found is None:
                raise ValueError
            (low, unit), (high, other) = number_and_unit(found[2]), number_and_unit(found[3])
            path, ends, number = found[1], (float(low), float(high)), int(found[4])
        except ValueError:
            raise ParameterError(
                f"--over {text}: what is asked for is path=from:to:n, such as mesh.k=1e8:2e8:11 or mesh.k=100MN/m:200MN/m:11"
            ) from None
        if unit != other:
            raise ParameterError(
                f"--over {text}: both ends must be in one unit, not in {unit or '1'} and {other or '1'}"
            )
        if number < 1:
            raise ParameterError(f"--over {text}: the number of values must be >= 1")
        if path in values:
            raise ParameterError(f"--over {text}: '{path}' is given twice")
        row = np.linspace(*ends, number)
        values[path] = [f"{x!r} {unit}" for x in row.tolist()] if unit else row
    return values


def quantities(program: Program, texts: Sequence[str], fallback: Sequence[str]) -> list[Any]:
    """What `--of` means: a quantity such as peak(mesh.force), or an output, whose peak, trough and rms are taken."""
    from gearblocks.analysis import quantities as made

    found: list[Any] = []
    for text in texts or fallback:
        if "(" in text:
            found.append(made.parsed(text))
        elif text in program.output_numbers:
            found += [made.peak(text), made.trough(text), made.rms(text)]
        else:
            raise UnknownNameError(
                f"--of {text}: there is no output '{text}'{did_you_mean(text, program.output_numbers)}"
            )
    return found


def check_place(out: Path | None) -> None:
    """Refuse before the study what could not be written after it."""
    if out is None:
        return
    if out.suffix and out.suffix.lower() not in ENDINGS:
        raise ParameterError(f"--out {out}: a folder, or a file that ends in one of {', '.join(ENDINGS)}")
    place_of_file("--out", out)


def written(study: Study, out: Path) -> list[Path]:
    """The files that were written: the one asked for, or a table, everything, and a picture in a folder."""
    from gearblocks.files import make_folder

    if out.suffix.lower() in (".png", ".svg", ".pdf"):
        study.plot(path=out)
        return [out]
    if out.suffix:
        study.save(out)
        return [out]
    folder = make_folder(out)
    study.save(folder / "study.csv")
    study.save(folder / "study.nc")
    files = [folder / "study.csv", folder / "study.nc"]
    if len(study.shape) <= 2:
        study.plot(path=folder / "study.png")
        files.append(folder / "study.png")
    return files
