"""Templates of the generated C, compiled once by jinja and kept from process to process where there is a place for them.

Knows nothing of what they are filled with, nor of where the place is.
"""

from __future__ import annotations

import hashlib
import sys
from functools import lru_cache
from importlib.resources import files
from typing import Any, Protocol


class CompiledTemplates(Protocol):
    """Keeps compiled templates from process to process: parsing them takes as long as everything else of a small train."""

    def __hash__(self) -> int:
        """Each is kept once."""

    def read(self, kind: str, key: str) -> bytes | None:
        """What was written under this key, or None."""

    def write(self, kind: str, key: str, data: bytes) -> Any:
        """Keeps bytes under a key."""


@lru_cache(maxsize=2)
def templates(compiled: CompiledTemplates | None) -> Any:
    """The templates, each compiled once, or read as `compiled` keeps them."""
    import jinja2

    class Kept(jinja2.BytecodeCache):
        """Under a key of the template's text, of Python and of jinja."""

        def get_cache_key(self, name: str, filename: str | None = None) -> str:  # noqa: ARG002
            return hashlib.sha256(f"{sys.version} {jinja2.__version__} {name} {_template(name)}".encode()).hexdigest()

        def load_bytecode(self, bucket: Any) -> None:
            data = compiled.read("templates", bucket.key) if compiled is not None else None
            if data is not None:
                bucket.bytecode_from_string(data)

        def dump_bytecode(self, bucket: Any) -> None:
            if compiled is not None:
                compiled.write("templates", bucket.key, bucket.bytecode_to_string())

    return jinja2.Environment(
        trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True, undefined=jinja2.StrictUndefined,
        loader=jinja2.FunctionLoader(_template), bytecode_cache=Kept(),
    )  # fmt: skip


@lru_cache
def _template(name: str) -> str:
    return files("gearblocks.codegen").joinpath(f"templates/{name}").read_text(encoding="utf-8")
