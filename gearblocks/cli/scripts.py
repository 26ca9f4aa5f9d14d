"""Finding trains and scenes: shipped models by bare name, scripts by path, the functions in them that make one."""

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
from gearblocks.files import unreadable

if TYPE_CHECKING:
    from gearblocks.analysis.scenes.scene import Scene
    from gearblocks.drivetrain import Drivetrain

DEFAULT = "build"


@dataclass(frozen=True, slots=True)
class Maker:
    """One train or scene that a script offers: its name there, the first line about it, and what it makes."""

    name: str
    words: str
    kind: str = "train"


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
    if len(path.parts) == 1 and path.stem in models:
        raise StorageError(
            f"there is no file '{file}' here; the shipped model is named '{path.stem}', without an ending"
        )
    if path.suffix in (".py", ".json") or len(path.parts) > 1:
        near = [one.name for one in path.parent.glob(f"*{path.suffix}")] if path.parent.is_dir() else []
        raise StorageError(
            f"there is no file '{file}'; `gearblocks new` writes a script to start from{did_you_mean(path.name, near)}"
        )
    listed = f"shipped are {', '.join(models)}" if models else "none is shipped"
    raise StorageError(f"there is no file and no shipped model '{file}'; {listed}{did_you_mean(file, models)}")


def makers(path: Path) -> list[Maker]:
    """What in the script makes a train or a scene: trains first, and `build` first of all."""
    if path.suffix == ".json":
        return [Maker(DEFAULT, "a stored train")]
    module = load(path)
    kinds = ((name, thing, _kind(module, name, thing)) for name, thing in vars(module).items())
    found = [Maker(name, _words(thing), kind) for name, thing, kind in kinds if kind]
    return sorted(found, key=lambda maker: (maker.kind != "train", maker.name != DEFAULT))


def make(text: str) -> Drivetrain:
    """The train that FILE[:NAME] means, that of a scene included. Raises GearblocksError for whatever goes wrong in the
    script."""
    from gearblocks.drivetrain import Drivetrain

    thing = made(text)
    return thing if isinstance(thing, Drivetrain) else thing.drivetrain


def made(text: str) -> Drivetrain | Scene:
    """The train or scene that FILE[:NAME] means."""
    from gearblocks.drivetrain import Drivetrain

    path, name = locate(text)
    if path.suffix == ".json":
        return Drivetrain.from_json(path)
    thing = _attribute(load(path), path, name)
    found = thing if _type(thing) else _called(thing, path, name)
    if not _type(found):
        raise ModelError(
            f"'{name}' in {path.name} answers with {type(found).__name__}, not with a Drivetrain; end it with `return rig`"
        )
    return found  # type: ignore[return-value]  # asked by name: a train has not imported what scenes need


def scene(text: str) -> Scene:
    """The scene that FILE:NAME means, or the only one in FILE. Raises ModelError where there is none."""
    path, name = locate(text)
    known = [] if path.suffix == ".json" else [maker.name for maker in makers(path) if maker.kind == "scene"]
    open_to_choice = name == DEFAULT and not text.endswith(f":{name}")
    if open_to_choice and len(known) > 1:
        raise ModelError(f"{path.name} has several scenes; name one: {', '.join(f'{text}:{one}' for one in known)}")
    if open_to_choice and len(known) == 1:
        text, name = f"{text}:{known[0]}", known[0]
    found = made(text) if name in known else None
    if _type(found) == "scene":
        return found  # type: ignore[return-value]  # as above
    there = f"; its scenes are {', '.join(known)}" if known else ""
    raise ModelError(
        f"'{name}' in {path.name} makes no scene{there}: write what is asked of the train, `def scene() -> gb.Scene: return "
        f"gb.Scene(build(), t_end=0.5, quantity=gb.peak('mesh.force', after=0.2), within=0.01)`"
    )


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
        path.read_bytes()
        spec.loader.exec_module(module)
    except GearblocksError:
        raise
    except PermissionError as error:
        if error.filename != str(path):
            raise ModelError(_trouble(path, error)) from error
        raise unreadable(path, error) from error
    except Exception as error:
        raise ModelError(_trouble(path, error)) from error
    finally:
        if folder in sys.path:
            sys.path.remove(folder)
    return module


def _split(text: str) -> tuple[str, str]:
    file, colon, name = text.removesuffix("()").rpartition(":")
    drive = len(file) == 1 and file.isalpha()
    return (file, name) if colon and not drive and name.isidentifier() else (text, DEFAULT)


def _attribute(module: ModuleType, path: Path, name: str) -> object:
    if hasattr(module, name):
        return getattr(module, name)
    names = [key for key, thing in vars(module).items() if _kind(module, key, thing)]
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


def _type(thing: object) -> str:
    """What a value is: "train", "scene" or ""."""
    return {"Drivetrain": "train", "Scene": "scene"}.get(type(thing).__name__, "")


def _kind(module: ModuleType, name: str, thing: object) -> str:
    """What a name of a script makes: "train", "scene" or ""."""
    if name.startswith("_") or _type(thing):
        return "" if name.startswith("_") else _type(thing)
    if not inspect.isfunction(thing) or thing.__module__ != module.__name__ or _needed(thing):
        return ""
    answer = thing.__annotations__.get("return", "")
    answer = answer if isinstance(answer, str) else getattr(answer, "__name__", "")
    if answer.rpartition(".")[2] == "Scene":
        return "scene"
    return "train" if answer.rpartition(".")[2] == "Drivetrain" or (name == DEFAULT and not answer) else ""


def _words(thing: object) -> str:
    if inspect.isfunction(thing):
        return (inspect.getdoc(thing) or "").partition("\n")[0]
    return f"the {_type(thing)} '{getattr(thing, 'name', '')}'"


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
