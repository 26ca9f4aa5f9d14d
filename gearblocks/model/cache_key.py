"""Cache key of a program: the sources of this package, the code of foreign classes, the structure of the train."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Iterator
from contextlib import suppress
from itertools import pairwise
from pathlib import Path
from typing import Any

from gearblocks.errors import ModelError
from gearblocks.language.block import Declared, field_values
from gearblocks.solver.cache import digest
from gearblocks.train.content import Contents
from gearblocks.train.graph import Train
from gearblocks.train.structure import structure_of_expression

PACKAGE = Path(__file__).parents[1]


@functools.cache
def package_digest(package: Path = PACKAGE) -> str:
    """Digest of all Python sources and templates below a folder, by path and content: another version of this package
    makes its own programs. The C core is no part of it: what is compiled has a key of its own (solver/library.py)."""
    paths = [*package.rglob("*.py"), *package.rglob("*.jinja")]
    sources = {path.relative_to(package).as_posix(): path.read_bytes() for path in paths}
    return digest(*(part for name in sorted(sources) for part in (name, sources[name])))


def classes_digest(train: Train) -> str:
    """Digest of the code of every class of blocks and effects that is not ours."""
    classes = {cls for block in train.examples for cls in _classes_in(block)}
    foreign = sorted(
        (cls for cls in classes if not cls.__module__.startswith("gearblocks.")),
        key=lambda c: (c.__qualname__, c.__module__),
    )
    for one, other in pairwise(foreign):
        if (one.__module__, one.__qualname__) == (other.__module__, other.__qualname__):
            raise ModelError(f"two classes of blocks are named {one.__qualname__}; rename one, or make its blocks anew")
    return digest(*(_class_text(cls) for cls in foreign))


def _classes_in(value: Any) -> Iterator[type[Declared]]:
    """The classes of a block or effect, of its effects, and of theirs."""
    if isinstance(value, Declared):
        yield type(value)
    inner = value if isinstance(value, tuple) else field_values(value).values() if isinstance(value, Declared) else ()
    for part in inner:
        yield from _classes_in(part)


def structural_text(train: Train) -> str:
    """Canonical text of the whole structure: equal text, equal program."""
    lines = [train.name, str(train.n_nodes)]
    lines += [f"{c.path} {kind.digest} {c.nodes}" for c, kind in zip(train.components, train.kinds, strict=True)]
    lines += [f"{c.name} {structure_of_expression(c.expr)} {c.unit}" for c in train.coordinates]
    return "\n".join(lines)


def _class_text(cls: type) -> str:
    """Source file of a class where there is one, and the code of its methods with what they call."""
    parts = [cls.__qualname__]
    with suppress(OSError, TypeError):
        parts.append(Path(inspect.getfile(cls)).read_text(encoding="utf-8"))
    return "\n".join([*parts, Contents().of_members(cls)])
