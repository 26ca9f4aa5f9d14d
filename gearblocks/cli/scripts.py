"""Finding trains: shipped models by bare name, scripts by path, the functions in them that make a train."""

from __future__ import annotations

import importlib.util
import inspect
import sys
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

from gearblocks.errors import GearblocksError, ModelError, StorageError, did_you_mean

if TYPE_CHECKING:
    from gearblocks.drivetrain import Drivetrain

DEFAULT = "build"


@dataclass(frozen=True, slots=True)
class Maker:
    """One train that a script offers: its name there and the first line about it."""

    name: str
    words: str


def shipped() -> dict[str, Path]:
    """The models that come with the package: bare name and script."""
    for folder in (Path(__file__).parents[1] / "models", Path(__file__).parents[2] / "models"):
        if folder.is_dir():
            return {path.stem: path for path in sorted(folder.glob("*.py")) if not path.stem.startswith("_")}
    return {}


def first_line(path: Path) -> str:
    """The first line of a script's docstring, read without running it."""
    import ast

    try:
        words = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
    except (OSError, SyntaxError, ValueError):
        return ""
    return words.partition("\n")[0]


def locate(text: str) -> tuple[Path, str]:
    """Script and function that FILE[:NAME] means; FILE is a path or a shipped model's bare name."""
    file, name = (text, DEFAULT) if Path(text).is_file() else _split(text)
    path = Path(file)
    if path.is_file():
        return path, name
    models = shipped()
    if file in models:
        return models[file], name
    if path.is_dir():
        raise StorageError(f"'{file}' is a folder; name the script in it")
    if path.suffix in (".py", ".json") or len(path.parts) > 1:
        near = [one.name for one in path.parent.glob(f"*{path.suffix}")] if path.parent.is_dir() else []
        raise StorageError(
            f"there is no file '{file}'; `gearblocks new` writes a script to start from{did_you_mean(path.name, near)}"
        )
    listed = f"shipped are {', '.join(models)}" if models else "none is shipped"
    raise StorageError(f"there is no file and no shipped model '{file}'; {listed}{did_you_mean(file, models)}")


def makers(path: Path) -> list[Maker]:
    """What in the script makes a train, `build` first."""
    if path.suffix == ".json":
        return [Maker(DEFAULT, "a stored train")]
    module = load(path)
    found = [Maker(name, _words(thing)) for name, thing in vars(module).items() if _makes_a_train(module, name, thing)]
    return sorted(found, key=lambda maker: maker.name != DEFAULT)


def make(text: str) -> Drivetrain:
    """The train that FILE[:NAME] means. Raises GearblocksError for whatever goes wrong in the script."""
    from gearblocks.drivetrain import Drivetrain

    path, name = locate(text)
    if path.suffix == ".json":
        return Drivetrain.from_json(path)
    thing = _attribute(load(path), path, name)
    if isinstance(thing, Drivetrain):
        return thing
    train = _called(thing, path, name)
    if not isinstance(train, Drivetrain):
        raise ModelError(
            f"'{name}' in {path.name} answers with {type(train).__name__}, not with a Drivetrain; end it with `return rig`"
        )
    return train


def load(path: Path) -> ModuleType:
    """The script as a module; it sees the files beside it, as when Python runs it."""
    spec = importlib.util.spec_from_file_location(f"gearblocks_script_{path.stem}", path)
    if spec is None or spec.loader is None:
        raise StorageError(
            f"file '{path}' is no Python script; name a .py script, a stored train (.json) or a shipped model"
        )
    module = importlib.util.module_from_spec(spec)
    sys.modules[module.__name__] = module
    folder = str(path.resolve().parent)
    sys.path.insert(0, folder)
    try:
        spec.loader.exec_module(module)
    except GearblocksError:
        raise
    except Exception as error:
        raise ModelError(_trouble(path, error)) from error
    finally:
        if folder in sys.path:
            sys.path.remove(folder)
    return module


def _split(text: str) -> tuple[str, str]:
    file, colon, name = text.rpartition(":")
    drive = len(file) == 1 and file.isalpha()
    return (file, name) if colon and not drive and name.isidentifier() else (text, DEFAULT)


def _attribute(module: ModuleType, path: Path, name: str) -> object:
    if hasattr(module, name):
        return getattr(module, name)
    names = [key for key, thing in vars(module).items() if _makes_a_train(module, key, thing)]
    listed = (
        f"it has {', '.join(names)}"
        if names
        else (
            f"nothing in it makes a train: write `def {name}() -> gb.Drivetrain`, as in the script of `gearblocks new`"
        )
    )
    raise ModelError(f"{path.name} has no function '{name}'; {listed}{did_you_mean(name, names)}")


def _called(thing: object, path: Path, name: str) -> object:
    if not callable(thing):
        raise ModelError(f"'{name}' in {path.name} is {type(thing).__name__}, not a function that makes a train")
    if needed := _needed(thing):
        raise ModelError(
            f"'{name}' in {path.name} needs {', '.join(needed)}; give default values or write a function without"
        )
    try:
        return thing()
    except GearblocksError:
        raise
    except Exception as error:
        raise ModelError(_trouble(path, error)) from error


def _needed(thing: Callable[..., object]) -> list[str]:
    """Names of the parameters without a default value."""
    try:
        listed = inspect.signature(thing).parameters.values()
    except (TypeError, ValueError):
        return []
    loose = (inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD)
    return [one.name for one in listed if one.kind not in loose and one.default is one.empty]


def _makes_a_train(module: ModuleType, name: str, thing: object) -> bool:
    if name.startswith("_"):
        return False
    if type(thing).__name__ == "Drivetrain":
        return True
    if not inspect.isfunction(thing) or thing.__module__ != module.__name__ or _needed(thing):
        return False
    answer = thing.__annotations__.get("return", "")
    answer = answer if isinstance(answer, str) else getattr(answer, "__name__", "")
    return answer.rpartition(".")[2] == "Drivetrain" or (name == DEFAULT and not answer)


def _words(thing: object) -> str:
    if inspect.isfunction(thing):
        return (inspect.getdoc(thing) or "").partition("\n")[0]
    return f"the train '{getattr(thing, 'name', '')}'"


def _trouble(path: Path, error: Exception) -> str:
    """What went wrong in a script, and in which of its lines."""
    if isinstance(error, SyntaxError):
        return f"{Path(error.filename or path).name}, line {error.lineno}: {error.msg}"
    here = path.resolve()
    lines = [
        frame.lineno for frame in traceback.extract_tb(error.__traceback__) if Path(frame.filename).resolve() == here
    ]
    place = f"{path.name}, line {lines[-1]}" if lines else path.name
    return f"{place}: {type(error).__name__}: {error}"
