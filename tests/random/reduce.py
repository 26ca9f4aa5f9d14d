"""Shrinks a train that fails: parts and fields go, numbers become round, as long as it fails alike."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

from tests.random.description import FIXED, Part, Train, senses
from tests.random.draw import digits
from tests.random.expressions import Node, rewrite
from tests.random.pool import Worker

Smaller = Callable[[Train], Iterator[Train]]


def to_plain(x: Any) -> Any:
    """A description as JSON."""
    if isinstance(x, Node):
        return {"op": x.op, "args": [to_plain(a) for a in x.args]}
    if isinstance(x, Train):
        return {n: to_plain(getattr(x, n)) for n in x.__dataclass_fields__}
    if isinstance(x, Part):
        return [to_plain(getattr(x, n)) for n in x.__dataclass_fields__]
    return [to_plain(a) for a in x] if isinstance(x, (tuple, list)) else x


def from_plain(data: dict[str, Any]) -> Train:
    """The description that to_plain wrote."""

    def value(x: Any) -> Any:
        if isinstance(x, dict):
            return Node(x["op"], tuple(value(a) for a in x["args"]))
        return tuple(value(a) for a in x) if isinstance(x, list) else x

    given = {name: value(v) for name, v in data.items() if name != "parts"}
    return Train(parts=tuple(Part(*(value(v) for v in p)) for p in data["parts"]), **given)


def reduced(train: Train, verdict: dict[str, Any], package: str | None) -> tuple[Train, dict[str, Any]]:
    """The smallest train found that fails by the same kind, and its verdict."""
    import os
    import tempfile

    with tempfile.TemporaryDirectory(prefix="random-trains-") as folder:
        cache = os.environ.get("RANDOM_TRAINS_CACHE", folder)
        worker = Worker(package, cache)

        def judge(candidate: Train) -> dict[str, Any]:
            nonlocal worker
            if worker.child.poll() is not None:
                worker = Worker(package, cache)
            light = str(verdict["what"]).startswith(("build", "default", "drawn"))
            job = {"family": train.family, "seed": train.seed, "train": to_plain(candidate), "light": light}
            return worker.judge(job)

        try:
            return shrunk(train, verdict, judge, lambda text: print(text, file=sys.stderr, flush=True))
        finally:
            worker.close()


def shrunk(
    train: Train,
    verdict: dict[str, Any],
    judge: Callable[[Train], dict[str, Any]],
    tell: Callable[[str], None] = lambda _: None,
) -> tuple[Train, dict[str, Any]]:
    """The smallest train to which every step smaller than it is right, or fails in another way."""
    again = True
    while again:
        again = False
        for step in STEPS:
            moved = True
            while moved:
                moved = False
                for candidate in step(train):
                    if candidate == train:
                        continue
                    found = judge(candidate)
                    if alike(found, verdict):
                        tell(f"{len(candidate.parts)} parts")
                        train, verdict, moved, again = candidate, found, True, True
                        break
    return train, verdict


def alike(found: dict[str, Any], wanted: dict[str, Any]) -> bool:
    """The same kind of failure; of one that stopped, with the same words."""
    if found["kind"] != wanted["kind"]:
        return False
    return wanted["kind"] not in ("stopped", "refused", "crash") or words(found) == words(wanted)


def words(verdict: dict[str, Any]) -> str:
    """What a message says, without names and numbers."""
    text = str(verdict["message"]).split(" at t = ")[0].split(": ", 1)[-1]
    return "".join(c for c in text if not c.isdigit())[:60]


# -- what may be smaller ----------------------------------------------------------------------------------------------


def _fewer_parts(train: Train) -> Iterator[Train]:
    for part in sorted(train.parts, key=lambda p: p.is_body):
        gone = {part.name}
        if part.is_body:  # with all that hangs on it
            gone |= {p.name for p in train.parts if part.node("a") in [n for _, n in p.at]}
        kept = [p for p in train.parts if p.name not in gone]
        kept = [p for p in kept if not senses(p) & gone]
        if any(p.is_body for p in kept):
            yield connected(train.with_parts(kept))


def connected(train: Train) -> Train:
    """Without nodes that have neither a body nor two elements."""
    parts = list(train.parts)
    while True:
        count: dict[str, int] = {}
        bodies = {p.node("a") for p in parts if p.is_body}
        for p in parts:
            for _, n in p.at:
                count[n] = count.get(n, 0) + (1 if not p.is_body else 0)
        lonely = {n for n in count if n not in FIXED and n not in bodies and count[n] < 2}
        kept = [p for p in parts if not lonely & {n for _, n in p.at}]
        if len(kept) == len(parts):
            return train.with_parts(kept)
        parts = kept


def _merged(train: Train) -> Iterator[Train]:
    """Both ends of an element become one node; of two bodies there the second goes."""
    for part in train.parts:
        ends = [n for _, n in part.at]
        if part.is_body or len(ends) != 2 or ends[0] == ends[1]:
            continue
        keep, gone = (ends[0], ends[1]) if ends[1] not in FIXED else (ends[1], ends[0])
        if gone in FIXED:
            continue
        kept = []
        for p in train.parts:
            if p.name == part.name or (p.is_body and p.node("a") == gone):
                continue
            kept.append(replace(p, at=tuple((f, keep if n == gone else n) for f, n in p.at)))
        kept = [p for p in kept if not (len(p.at) > 1 and len({n for _, n in p.at}) == 1)]
        names = {p.name for p in kept}
        kept = [p for p in kept if senses(p) <= names]
        if any(p.is_body for p in kept):
            yield connected(train.with_parts(kept))


def _fewer_fields(train: Train) -> Iterator[Train]:
    optional = (
        "w0", "v0", "phi0", "c", "peak", "geometry", "viscous", "stribeck", "bearing", "contact_damping", "hysteresis",
        "stiffness_variation", "transmission_error", "backlash", "lower", "upper", "integral_gain", "time_constant", "bias",
        "drag_area", "rolling", "grade",
    )  # fmt: skip
    for i, part in enumerate(train.parts):
        for name, _ in part.fields:
            if name in optional:
                yield train.with_parts([*train.parts[:i], part.changed(**{name: None}), *train.parts[i + 1 :]])


def _simpler_signals(train: Train) -> Iterator[Train]:
    for i, part in enumerate(train.parts):
        for name, value in part.fields:
            if isinstance(value, Node) and value.op not in ("object", "table"):
                for simple in (*(a for a in value.args if isinstance(a, (Node, float))), 1.0):
                    if isinstance(simple, Node) and simple.op in ("<", ">", "twist", "slip"):
                        continue
                    yield train.with_parts([*train.parts[:i], part.changed(**{name: simple}), *train.parts[i + 1 :]])


def _rounder(train: Train) -> Iterator[Train]:
    for i, part in enumerate(train.parts):
        for name, value in part.fields:
            for to in (1.0, "round"):

                def change(x: Any, to: Any = to) -> Any:
                    if not isinstance(x, float) or x in (0.0, 1.0, -1.0):
                        return x
                    return float(f"{x:.1g}") if to == "round" else to

                new = (
                    change(value) if isinstance(value, float) else (rewrite(value, change) if to == "round" else value)
                )
                if new != value:
                    yield train.with_parts([*train.parts[:i], part.changed(**{name: new}), *train.parts[i + 1 :]])


def _shorter(train: Train) -> Iterator[Train]:
    if train.t_end > 0.1:
        yield replace(train, t_end=digits(0.5 * train.t_end))


STEPS: tuple[Smaller, ...] = (_fewer_parts, _merged, _shorter, _fewer_fields, _simpler_signals, _rounder)
