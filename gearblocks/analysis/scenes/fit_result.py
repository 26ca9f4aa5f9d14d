"""What a scene calls for: the fitted train, how it is run, and the evidence that it is right."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, final

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.scenes.bench import Effort
from gearblocks.analysis.scenes.price_result import GAIN, Price
from gearblocks.analysis.scenes.scene import Scene
from gearblocks.analysis.scenes.trials import Judgement, Trial, Verdict, percent, relative_cost
from gearblocks.drivetrain import Drivetrain
from gearblocks.plurals import singular
from gearblocks.simulation.records import Stats

Array = NDArray[np.float64]


class Neighbour(NamedTuple):
    """The fitted train beside the whole one at another load or speed; message: why it was not to be run."""

    words: str
    judgement: Judgement
    names: tuple[str, ...]
    message: str = ""

    @property
    def holds(self) -> bool:
        """Whether the quantities stay within the accuracy there."""
        return self.judgement.verdict is Verdict.not_needed

    def __str__(self) -> str:
        if self.message:
            return f"{self.words}: {self.message}"
        return f"{self.words}: {self.judgement.worst(self.names)}"


_AROUND = {
    Verdict.not_needed: "it holds at",
    Verdict.needed: "it stops holding at",
    Verdict.undecided: "it is undecided at",
}


@final
@dataclass(frozen=True, slots=True, eq=False)
class Fit:
    """The cheapest train that a scene calls for. trial: the fitted train and its runs; judgement: beside the whole train;
    full: counters of a run of the whole train, its CPU time taken in turns with that of the trial; effort: the cheapest
    way to run it; around: at other loads and speeds; given_up: what would have stayed within the
    accuracy too, without gain, but not around the scene (spoilt says where); trains, runs: how many were built and made."""

    scene: Scene
    price: Price
    trial: Trial
    judgement: Judgement
    full: Stats
    effort: Effort
    around: tuple[Neighbour, ...]
    given_up: Trial | None
    spoilt: tuple[Neighbour, ...]
    trains: int
    runs: int

    @property
    def drivetrain(self) -> Drivetrain:
        """The fitted train; `.dropped` of it says what went."""
        return self.trial.train

    @property
    def dropped(self) -> tuple[str, ...]:
        """The effects that went."""
        return tuple(name for name in self.scene.drivetrain.effects() if name in self.trial.effects)

    @property
    def method(self) -> str:
        """Of the cheapest run."""
        return self.effort.method

    @property
    def rtol(self) -> float:
        """Of the cheapest run."""
        return self.effort.rtol

    @property
    def step(self) -> float | None:
        """Of the cheapest run [s], where its steps are fixed."""
        return self.effort.step

    @property
    def locate(self) -> bool:
        """Whether the cheapest run locates events."""
        return self.effort.locate

    @property
    def value(self) -> Array:
        """Quantities of the fitted train, shape (quantities,)."""
        return self.trial.estimates[1].values

    @property
    def error(self) -> Array:
        """How far off these may be as values of the fitted train, in their units."""
        return self.trial.estimates[1].errors

    @property
    def holds(self) -> bool:
        """Whether it holds at load and speed 10 % lower and higher, too."""
        return all(one.holds for one in self.around)

    @property
    def evidence(self) -> str:
        """Quantities with everything and fitted, what the runs took, and where it holds."""
        full, lines = self.price.full, []
        units = [f" {unit}".rstrip() for unit in self.scene.units]
        for i, name in enumerate(self.scene.names):
            change = percent(self.judgement.changes[i], self.judgement.errors[i]) + self.judgement.made_of
            lines.append(
                f"{name}: {full.values[i]:.9g} +- {full.errors[i]:.1g}{units[i]} with everything, {self.value[i]:.9g} +- "
                f"{self.error[i]:.1g}{units[i]} fitted ({change})"
            )
        whole, trial = self.price.whole, self.trial
        took = (
            f"{whole.n_states} states, {self.full.rhs_calls:,} right-hand sides and {1e3 * self.full.cpu_seconds:.3g} ms "
            f"with everything; {trial.n_states} states, {trial.stats.rhs_calls:,} and {1e3 * trial.stats.cpu_seconds:.3g} ms "
            f"fitted, at {trial.estimates[1].effort}"
        )
        lines += [singular(took), *map(str, self.around)]
        return "\n".join([*lines, singular(f"{self.trains} trains built, {self.runs} runs made")])

    @property
    def sentence(self) -> str:
        """What may go, what is gained, how to run it, and where it stops holding."""
        asked = f"For {', '.join(self.scene.names)} within {100 * self.scene.within:g} %"
        run = f"run it with {self.effort}{self._mean_words()}"
        if not self.trial.effects:
            return f"{asked} nothing is to be left out{self._given_up_words()}; {run}."
        whole, now = self.full, self.trial.stats
        ratio = whole.cpu_seconds / now.cpu_seconds if now.cpu_seconds > 0 else np.inf
        cost = relative_cost(self.trial.work / self.price.whole.work, now.cpu_seconds, whole.cpu_seconds)
        gains = max(cost, 1 / ratio) < 1 - GAIN
        gain = f"it runs {ratio:.3g} times as fast" if gains else "without gain"
        went = f"{', '.join(self.dropped)} may go: {gain} ({whole.rhs_calls:,} to {now.rhs_calls:,} right-hand sides)"
        return f"{asked} {went}; {run}; {self._around_words()}."

    def _mean_words(self) -> str:
        found = self.trial.estimates[1]
        if not found.scattered:
            return ""
        spread = float(np.max(found.members.std(axis=0, ddof=1) / np.abs(found.values)))
        return f" and take means over runs: its motion scatters, single runs by {100 * spread:.2g} %"

    def _given_up_words(self) -> str:
        if self.given_up is None:
            return ""
        names = ", ".join(n for n in self.scene.drivetrain.effects() if n in self.given_up.effects)
        off = [str(one) for one in self.spoilt if not one.holds and one.judgement.verdict is not Verdict.undecided]
        unknown = [str(one) for one in self.spoilt if one.judgement.verdict is Verdict.undecided]
        told = [f"does not hold around the scene ({', '.join(off)})"] if off else []
        told += [f"is undecided around the scene ({', '.join(unknown)})"] if unknown else []
        return f": {names} may go here, without gain, but {' and '.join(told)}"

    def _around_words(self) -> str:
        if not self.around:
            return "the train has no load and no speed to vary"
        kinds: dict[str, list[str]] = {}
        for one in self.around:
            kinds.setdefault(
                _AROUND.get(one.judgement.verdict, "it was not to be seen whether it holds at"), []
            ).append(one.words if one.holds else str(one))
        missing = [what for what in ("load", "speed") if not any(one.words.startswith(what) for one in self.around)]
        told = [f"{words} {', '.join(found)}" for words, found in kinds.items()]
        return "; ".join([*told, *(f"the train has no {what} to vary" for what in missing)])

    def __str__(self) -> str:
        return f"{self.scene}\n{self.evidence}\n{self.sentence}"

    def __repr__(self) -> str:
        return singular(f"<Fit of '{self.scene.name}': {len(self.dropped)} effects left out, {self.effort}>")

    def _repr_html_(self) -> str:
        from gearblocks.pages import small_table

        return small_table(str(self.scene), [(line,) for line in self.evidence.splitlines()], notes=[self.sentence])
