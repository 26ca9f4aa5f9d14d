"""The public face: a drivetrain that is composed, changed, read and built."""

from __future__ import annotations

import fnmatch
import re
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, overload

from gearblocks.errors import ModelError, arguments_told, by_name, did_you_mean, missing_attribute
from gearblocks.files import as_path
from gearblocks.language.block import Block, Effect
from gearblocks.language.expression import as_expr
from gearblocks.language.fields import Flange
from gearblocks.language.units import declared
from gearblocks.model.build import check_user_blocks
from gearblocks.model.effect_removal import needed, without_effects
from gearblocks.pages import Lines
from gearblocks.train.graph import Coordinate, Train, Tree, flatten
from gearblocks.train.handles import FlangeHandle, Handle, PartsByName, bare, end_of, lost_flanges, main_ends
from gearblocks.train.leaves import with_parameter
from gearblocks.train.left_out import LeftOut, left_out_of
from gearblocks.train.plausibility import warn_of_doubts
from gearblocks.train.values import field_paths, gone_with_effect, replaced, unique_path, value_problems

if TYPE_CHECKING:
    from gearblocks.drawing.drawing import Drawing
    from gearblocks.equations.equations import Equations
    from gearblocks.model.explaining import TrainExplanation
    from gearblocks.model.listing import Listing
    from gearblocks.simulation.trajectory import Trajectory

_B = TypeVar("_B", bound=Block)
_NAME = re.compile(r"[A-Za-z_]\w*")


@arguments_told
class Drivetrain(PartsByName):
    """A drivetrain: named blocks and trains, joined at their flanges.

    `add`, `connect`, `chain`, `expose` and `coordinate` change it; `set`, `without` and `only` return new ones.
    """

    def __init__(self, name: str) -> None:
        if not isinstance(name, str) or not name.strip():
            raise ModelError(f"a Drivetrain needs a name: {name!r} must be text such as 'test rig'")
        self.name = name
        self._parts: dict[str, Block | Drivetrain] = {}
        self._links: list[tuple[tuple[str, str], ...]] = []
        self._exposed: dict[str, tuple[str, str]] = {}
        self._coordinates: list[Coordinate] = []
        self._before: dict[str, Block] = {}
        self.dropped: tuple[str, ...] = ()

    # -- composing ----------------------------------------------------------------------------------------------------

    @overload
    def add(self, name: str, part: Drivetrain | Handle) -> Handle: ...
    @overload
    def add(self, name: str, part: _B) -> _B: ...
    def add(self, name: str, part: Block | Drivetrain | Handle) -> Any:
        """Adds a block, or a copy of a train, under a name; returns a handle with its flanges and fields.

        To a type checker the handle of a block is that block, so that it finds flanges and fields that are not there.
        Raises ModelError for a name that is taken or odd, and for values out of bounds.
        """
        if not isinstance(name, str) or not _NAME.fullmatch(name):
            way = f": the name comes first, add({part!r}, ...)" if isinstance(part, str) else ""
            raise ModelError(f"part name {name!r:.80} must be a word of letters, digits and '_', a letter first{way}")
        if name in self._parts:
            raise ModelError(
                f"'{self.name}' already has a part named '{name}'; take another name, or change it with rig.set"
            )
        whole = bare(part)
        problems = list(_part_problems(name, whole))
        if problems:
            raise ModelError(problems)
        warn_of_doubts(name, whole)
        self._parts[name] = whole._copy() if isinstance(whole, Drivetrain) else whole
        return Handle(self, name, self._parts[name])

    def connect(self, *flanges: FlangeHandle | Flange) -> None:
        """Joins two or more flanges to one shaft. May be repeated; joined flanges turn together."""
        ends = [end_of(self, f) for f in flanges]
        if len(ends) < 2:
            given = f", not {flanges[0]!r} alone" if flanges else ""
            raise ModelError(f"connect needs at least two flanges{given}: rig.connect(motor.b, shaft.a)")
        if len(set(ends)) < len(ends):
            twice = next(e for e in ends if ends.count(e) > 1)
            raise ModelError(f"flange {twice[0]}.{twice[1]} is connected to itself")
        self._links.append(tuple(ends))

    def chain(self, *parts: Handle | Block) -> None:
        """Connects parts in a row by their two main flanges; one with a single flange attaches to the running shaft."""
        if len(parts) < 2:
            raise ModelError(f"chain needs at least two parts, one by one, not {parts!r:.200}")
        running: tuple[str, str] | None = None
        waiting: list[tuple[str, str]] = []
        for part in parts:
            ends = main_ends(self, part)
            attach = [*waiting, *([running] if running else []), ends[0]]
            if len(ends) == 1 and running is None:
                waiting.append(ends[0])
                continue
            if len(attach) > 1:
                self._links.append(tuple(attach))
            waiting = []
            if len(ends) == 2:
                running = ends[1]
        if waiting and running is None and len(waiting) > 1:
            self._links.append(tuple(waiting))

    def expose(self, name: str, flange: FlangeHandle | Flange) -> None:
        """Makes a flange of a part a flange of this train, for use inside another one."""
        if not isinstance(name, str) or not _NAME.fullmatch(name) or name in self._exposed:
            raise ModelError(f"'{self.name}': the name {name!r} for an exposed flange is taken or no word")
        self._exposed[name] = end_of(self, flange)

    def coordinate(self, name: str, expr: Any, unit: str) -> None:
        """Names a relative coordinate, an expression of gb.sense(...) and Parameters.

        It becomes an output, and the unknown of the relative form of the equations when there are as many as degrees
        of freedom.
        """
        taken = {"t", "time", *self._parts, *(c.name for c in self._coordinates)}
        if not isinstance(name, str) or not _NAME.fullmatch(name) or name in taken:
            raise ModelError(f"coordinate name {name!r} is taken or no word")
        expression = as_expr(expr)
        if any(leaf.op not in ("sense", "parameter") for leaf in expression.leaves()):
            raise ModelError(f"coordinate '{name}': only gb.sense(...), Parameters and numbers may stand in it")
        declared(f"coordinate '{name}'", unit)
        self._coordinates.append(Coordinate(name, expression, unit))

    # -- changing -----------------------------------------------------------------------------------------------------

    def _copy(self) -> Drivetrain:
        other = Drivetrain(self.name)
        other._parts = {n: p._copy() if isinstance(p, Drivetrain) else p for n, p in self._parts.items()}
        other._links, other._exposed = list(self._links), dict(self._exposed)
        other._coordinates, other._before = list(self._coordinates), dict(self._before)
        return other

    def __getitem__(self, path: str) -> Handle:
        """The part at a path, "mesh" or "stage.mesh", as `add` returned it: with its flanges and fields."""
        name, _, rest = str(path).partition(".")
        if name not in self._parts:
            raise ModelError(f"'{self.name}' has no part '{name}'{did_you_mean(name, self._parts)}")
        part = self._parts[name]
        if not rest:
            return Handle(self, name, part)
        if isinstance(part, Drivetrain):
            return part[rest]
        raise ModelError(f"'{path}': {name} is a block and has no parts")

    def __contains__(self, path: object) -> bool:
        name, _, rest = str(path).partition(".")
        part = self._parts.get(name)
        return part is not None and (not rest or (isinstance(part, Drivetrain) and rest in part))

    def _walk(self, prefix: str = "") -> Iterator[tuple[str, Drivetrain, str, Block]]:
        """(path, owner, name, block) of every block."""
        for name, part in self._parts.items():
            if isinstance(part, Drivetrain):
                yield from part._walk(f"{prefix}{name}.")
            else:
                yield f"{prefix}{name}", self, name, part

    def set(self, values: Mapping[str, Any]) -> Drivetrain:
        """A new train with other values, by path: {"mesh.backlash.half_gap": 2e-5, "mesh": gb.GearMesh(...)}; or by the name
        of a Parameter, in its unit: {"speed": 3000}, which changes everywhere."""
        other = self._copy()
        paths = {*self.field_paths(), *self._parts, *(path for path, _, _, _ in self._walk())}
        problems: list[str] = []
        changed: dict[str, tuple[Drivetrain, str]] = {}
        for path, value in by_name("the values by path", values).items():
            try:
                if path not in paths and other._set_parameter(path, value, changed):
                    continue
                found = unique_path(path, paths)
                owner, name, rest = other._locate(found)
                owner._parts[name] = replaced(owner._parts[name], rest.split("."), value) if rest else bare(value)
                if (before := owner._before.pop(name, None)) is not None and rest:
                    owner._before[name] = replaced(before, rest.split("."), value)
                changed[found[: -len(rest) - 1] if rest else found] = (owner, name)
            except ModelError as error:
                before_it = ((p, x._before.get(n)) for p, x, n, _ in self._walk())
                gone = path not in paths and gone_with_effect(path, before_it, self.dropped)
                problems += [gone] if gone else [x if str(path) in x else f"'{path}': {x}" for x in error.problems]
        for path, (owner, name) in changed.items():
            problems += [*_part_problems(path, owner._parts[name])] or [
                *lost_flanges(Handle(owner, name, owner._parts[name]), (*owner._links, owner._exposed.values()))
            ]
        if problems:
            raise ModelError(problems)
        for path, (owner, name) in changed.items():
            warn_of_doubts(path, owner._parts[name])
        return other

    def _set_parameter(
        self, name: str, value: Any, changed: dict[str, tuple[Drivetrain, str]], prefix: str = ""
    ) -> bool:
        """Another value of a Parameter; `changed` gets the blocks that it stands in. Whether it stands anywhere."""
        before, coordinates = self._before, self._coordinates
        self._before = {part: with_parameter(block, name, value) for part, block in before.items()}
        self._coordinates = [replace(c, expr=with_parameter(c.expr, name, value)) for c in coordinates]
        found = any(c.expr is not old.expr for c, old in zip(self._coordinates, coordinates, strict=True))
        found |= any(self._before[part] is not block for part, block in before.items())
        for part, whole in self._parts.items():
            if isinstance(whole, Drivetrain):
                found |= whole._set_parameter(name, value, changed, f"{prefix}{part}.")
            elif (new := with_parameter(whole, name, value)) is not whole:
                self._parts[part], changed[f"{prefix}{part}"], found = new, (self, part), True
        return found

    def field_paths(self) -> frozenset[str]:
        """Paths of all values of all blocks: "mesh.k", "mesh.backlash.half_gap", "gear.ratio", ..."""
        return frozenset(f"{path}.{field}" for path, _, _, block in self._walk() for field in field_paths(block))

    def _locate(self, path: str) -> tuple[Drivetrain, str, str]:
        name, _, rest = path.partition(".")
        part = self._parts[name]
        return part._locate(rest) if isinstance(part, Drivetrain) and rest else (self, name, rest)

    def effects(self) -> dict[str, Any]:
        """Every effect that is present, by dotted name: "mesh.backlash", "shaft.compliance", ..."""
        return {f"{path}.{n}": e for path, _, _, block in self._walk() for n, e in block.effects().items()}

    def without(self, *patterns: str) -> Drivetrain:
        """A new train without the effects that match; `dropped` of it says what went. `*` crosses dots.

        Where compliance goes, shafts become one; the start angle and the start speed of their first body stay. See
        `carried_start` for the state of the full train.
        """
        return self._leaving(self._matching("without", patterns).__contains__)

    def only(self, *patterns: str) -> Drivetrain:
        """A new train with only the effects that match, and what they need."""
        kept = set(self._matching("only", patterns))
        for path, _, _, block in self._walk():
            kept |= {
                f"{path}.{effect}" for effect in needed(block, {e for e in block.effects() if f"{path}.{e}" in kept})
            }
        return self._leaving(lambda name: name not in kept, kept)

    def _matching(self, what: str, patterns: tuple[str, ...]) -> dict[str, Any]:
        """The effects that match; ModelError names each pattern that matches none."""
        present, found, problems = self.effects(), dict[str, Any](), list[str]()
        for pattern in patterns:
            if not isinstance(pattern, str):
                raise ModelError(
                    f"{what} takes patterns one by one as text, such as {what}('*.damping'), not {pattern!r}"
                )
            hits = {name: effect for name, effect in present.items() if fnmatch.fnmatchcase(name, pattern)}
            if not hits:
                from gearblocks.model.listing import near_patterns

                problems.append(
                    f"no effect matches '{pattern}'; present are {', '.join(present) or 'none'}"
                    f"{near_patterns(pattern, present)}"
                )
            found |= hits
        if problems:
            raise ModelError(problems)
        return found

    def _leaving(self, goes: Callable[[str], bool], kept: Collection[str] = ()) -> Drivetrain:
        other, removal = self._copy(), without_effects(self.tree(), goes, kept)
        for path, owner, name, block in list(other._walk()):
            changed = removal.blocks.get(path, block)
            if block.effects().keys() - changed.effects().keys():
                owner._before.setdefault(name, block)
            owner._parts[name] = changed
        other.dropped = removal.dropped
        return other

    def left_out(self) -> LeftOut | None:
        """What a run watches: the effects that `without` and `only` took away on the way to here; None: nothing."""
        return left_out_of(self.tree(), [(path, x._before.get(n), block) for path, x, n, block in self._walk()])

    # -- reading ------------------------------------------------------------------------------------------------------

    def tree(self) -> Tree:
        """A frozen snapshot of the composition."""
        parts = tuple((n, p.tree() if isinstance(p, Drivetrain) else p) for n, p in self._parts.items())
        return Tree(self.name, parts, tuple(self._links), tuple(self._exposed.items()), tuple(self._coordinates))

    def train(self) -> Train:
        """A frozen snapshot, flat, with nodes. Raises ModelError with all open ends."""
        return flatten(self.tree())

    def equations(self) -> Equations:
        """The equations of motion for reading, in sympy."""
        from gearblocks.equations.write import write_equations

        train = self.train()
        check_user_blocks(train)
        return write_equations(train)

    def outputs(self, *patterns: str) -> Listing:
        """Names, units and words of what a run records, all or those that match ("mesh.*"; `*` crosses dots)."""
        from gearblocks.model import listing

        return listing.outputs(self.train(), patterns)

    def parameters(self, *patterns: str) -> Listing:
        """Names, values, units and words of what simulate(parameters={...}) takes, all or those that match."""
        from gearblocks.model import listing

        return listing.parameters(self.train(), patterns)

    def inputs(self, *patterns: str) -> Listing:
        """Names, units and values of the inputs before anything is connected, all or those that match."""
        from gearblocks.model import listing

        return listing.inputs(self.tree(), patterns)

    def flanges(self, *patterns: str) -> Listing:
        """The flanges of all parts and what they are joined to, all or those that match; open ends may be left."""
        from gearblocks.model import listing

        return listing.flanges(self.tree(), patterns)

    def draw(
        self, path: str | Path | None = None, *, values: bool = False, run: Trajectory | None = None, at: float | None = None
    ) -> Drawing:  # fmt: skip
        """The train as a kinematic scheme in SVG, written to `path` where one is given.

        values: printed beside the symbols too. run, at: what is stuck, slides or touches at a time [s] (its end), as colour.
        """
        from gearblocks.drawing.drawing import drawing_of

        return drawing_of(self.tree(), path, values=values, run=run, at=at)

    def _repr_svg_(self) -> str | None:
        from gearblocks.drawing.drawing import shown_drawing

        found = shown_drawing(self.tree())
        return None if found is None else found.text

    def describe(self) -> str:
        """A table of all blocks with their values and effects, and what among them is hardly meant (mm typed as m ...)."""
        from gearblocks.model.plausibility import described

        return Lines(described(self.tree(), len(self.effects())))

    def explain(self) -> TrainExplanation:
        """States, switches, the fastest modes, and which element will limit the step."""
        from gearblocks.model.explaining import explanation_of

        return explanation_of(self.train())

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            raise missing_attribute(self, name, parts=self.__dict__.get("_parts", ()))

    def __repr__(self) -> str:
        names = [*self._parts]
        more = f", ... ({len(names)} parts)" if len(names) > 20 else ""
        return f"<Drivetrain '{self.name}': {', '.join(names[:20])}{more}>"

    def to_json(self, path: str | Path) -> None:
        """Writes the train to a file from which `from_json` makes an equal one."""
        from gearblocks.train.json_form import write

        write(self.tree(), as_path(path))

    @staticmethod
    def from_json(path: str | Path) -> Drivetrain:
        """The train in a file that `to_json` wrote. Expressions in it are parsed, never run."""
        from gearblocks.train.json_form import read

        return Drivetrain.from_tree(read(as_path(path)))

    @staticmethod
    def from_tree(tree: Tree) -> Drivetrain:
        """A train from a snapshot."""
        train = Drivetrain(tree.name)
        for name, part in tree.parts:
            train.add(name, Drivetrain.from_tree(part) if isinstance(part, Tree) else part)
        train._links, train._exposed = list(tree.links), dict(tree.exposed)
        for c in tree.coordinates:
            train.coordinate(c.name, c.expr, c.unit)
        return train


def _part_problems(path: str, part: Any) -> Iterator[str]:
    """What is wrong with something that is to be a part."""
    if isinstance(part, type):
        yield f"'{path}': {part.__name__} is a class: make one with its values, such as {part.__name__}(...)"
    elif isinstance(part, Effect):
        yield f"'{path}': {part!r:.80} is an effect, no part: give it to a block, as in GearMesh(backlash=gb.Backlash(...))"
    elif not isinstance(part, (Block, Drivetrain)):
        yield f"'{path}': {part!r:.200} is neither a block nor a Drivetrain"
    elif isinstance(part, Block):
        yield from value_problems(path, part)
