"""Scripts to start from: a commented one of its own (`gearblocks new`), or a shipped model (`gearblocks copy`)."""

from __future__ import annotations

import shutil
from pathlib import Path

from gearblocks.cli import scripts
from gearblocks.errors import ParameterError, StorageError, UnknownNameError, did_you_mean
from gearblocks.files import reason

TEMPLATE = Path(__file__).with_name("starting_script.py.txt")


def new(file: Path) -> Path:
    """Write the starting script to `file`; an ending that is missing becomes .py. What exists is left alone."""
    return _copied(TEMPLATE, _script(file))


def copy(model: str, file: Path | None) -> Path:
    """Copy the script of a shipped model to `file`, a folder, or a file of its own name here."""
    models = scripts.shipped()
    name = model.removesuffix(".py")
    if name not in models:
        raise UnknownNameError(
            f"there is no shipped model '{model}'; shipped are {', '.join(models) or 'none'}{did_you_mean(name, models)}"
        )
    here = Path(f"{name}.py")
    target = here if file is None else file / here if file.is_dir() else file
    return _copied(models[name], _script(target))


def _script(file: Path) -> Path:
    if file.is_dir():
        raise StorageError(f"'{file}' is a folder; name the script in it, such as {file / 'train.py'}")
    if file.suffix not in ("", ".py"):
        raise ParameterError(f"'{file}' ends in {file.suffix}; a script ends in .py, such as {file.with_suffix('.py')}")
    return file.with_suffix(".py")


def _copied(source: Path, target: Path) -> Path:
    """`target`, made with the content of `source`, unless it exists: nobody's script is overwritten."""
    if not target.parent.is_dir():
        raise StorageError(f"cannot write '{target}': there is no folder '{target.parent}'; make it or name another")
    try:
        with source.open("rb") as content, target.open("xb") as script:
            shutil.copyfileobj(content, script)
    except FileExistsError:
        raise StorageError(f"'{target}' exists and is left alone; name another file or remove it first") from None
    except OSError as error:
        raise StorageError(f"cannot write '{target}': {reason(error)}; choose another place") from error
    return target
