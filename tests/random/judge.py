"""The verdict on one train: its runs against evidence that is not the same solver in the same order.

Evidence, the strongest first: the independent reference; a fine run of another method; the same in another order of parts
and connections. `without` is held against the train that was built without.
"""

from __future__ import annotations

import dataclasses
import itertools
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from random import Random
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tests.random.description import BODIES, Train, arguments, build
from tests.random.limit import samples_that_switches_pass
from tests.random.without import tied_pair

Array = NDArray[np.float64]
METHODS = ("dp5", "dp8", "rodas")
SAMPLES = 101
FINE = 1e-9
FLOOR = 1.0  # rad and rad/s: a thousandth of it, in trains of some kg m2 and N m, counts as rest
CPU_LIMIT = 15.0  # s of a run that takes milliseconds as a rule
FACTOR = 100.0  # allowed deviation in units of rtol, times 1 + how much the train magnifies errors
LEDGER = 10.0  # allowed energy residual in units of rtol
PERTURBATION = 1e-8
DRAWS = 8  # perturbed runs before anything counts as wrong
CHAOTIC = 1e-2  # where the allowed deviation grows beyond this nothing is compared
COMPARED = 0.2  # of the run, at least, for evidence


class HangError(Exception):
    """A run used more processor time than it may."""


@dataclass
class Verdict:
    """kind: right, wrong, ledger, refused, stopped, hang, crash, or none (no evidence). evidence: what it rests on."""

    family: str
    seed: int
    kind: str = "right"
    what: str = ""
    message: str = ""
    evidence: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    seconds: float = 0.0

    def fails(self, kind: str, what: str, message: str) -> None:
        """The first failure decides; those that follow are notes."""
        if self.kind == "right":
            self.kind, self.what, self.message = kind, what, message
        else:
            self.notes.append(f"{kind} ({what}): {message}")


@contextmanager
def cpu_limit(seconds: float) -> Iterator[None]:
    """Raises HangError after so much processor time of this process."""

    def stop(*_: Any) -> None:
        raise HangError

    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


@dataclass
class Motion:
    """Angles and speeds of all bodies, and rises of all thermal masses, at the samples; jumps: times of impacts."""

    angles: Array
    speeds: Array
    jumps: Array
    rises: Array = field(default_factory=lambda: np.zeros((0, 0)))


def motion_of(run: Any, train: Train) -> Motion:
    """The motion of a run of gearblocks."""
    names = train.outputs()
    jumps = [e.t for e in run.events if e.kind == "impact" or "dog" in e.component or "sync" in e.component]
    jumps += [e.t for e in run.events if "freewheel" in e.component or "oneway" in e.component]
    angles, speeds = (np.array([run[x[i]] for x in names]) for i in (0, 1))
    return Motion(angles, speeds, np.array(jumps), np.array([run[x] for x in train.rises()]).reshape(-1, len(run.t)))


def deviations(one: Motion, other: Motion, t: Array) -> Array:
    """At every time the largest difference relative to the largest value of each quantity; speeds not beside their jumps."""
    worst = np.zeros(len(t))
    beside = np.zeros(len(t), dtype=bool)
    for at in np.concatenate([one.jumps, other.jumps]):
        beside |= np.abs(t - at) <= 2e-4 * t[-1]
    groups = ((one.angles, other.angles, False), (one.speeds, other.speeds, True), (one.rises, other.rises, True))
    for a, b, hidden in groups:
        known = ~np.isnan(b).any(axis=1)
        if not known.any():
            continue
        size = np.abs(b[known]).max(axis=1)
        scale = np.maximum(size, 1e-3 * max(float(size.max()), FLOOR))[:, None]
        off = (np.abs(a[known] - b[known]) / scale).max(axis=0)
        off[~np.isfinite(off)] = np.inf
        if hidden:
            off[beside] = 0.0
        worst = np.maximum(worst, off)
    return worst


def grows_beyond_machines(error: Any) -> bool:
    """The run was given up for growth, by name, and it is no mistake: more than 1e8 rad/s."""
    run = error.trajectory
    return (
        "grows without bound" in str(error)
        and run is not None
        and any(np.abs(run[name]).max() > 1e8 for name in run.names if name.endswith(".w"))
    )


def deviation(one: Motion, other: Motion, t: Array) -> float:
    """The largest of the deviations."""
    return float(deviations(one, other, t).max())


class Judge:
    """Runs and compares; `stage` is told what begins, so that a killed process can be placed."""

    def __init__(self, gb: Any, train: Train, stage: Callable[[str], None] = lambda _: None) -> None:
        self.gb, self.train, self.stage = gb, train, stage
        self.verdict = Verdict(train.family, train.seed)
        self.t = np.linspace(0.0, train.t_end, SAMPLES)
        self.random = Random(f"judge {train.family} {train.seed}")
        self.runs: dict[str, tuple[float, Motion]] = {}

    def judge(self, light: bool = False) -> Verdict:
        """The verdict, with the time that it took. light: two runs against the reference alone."""
        begin = time.perf_counter()
        self._judge(light)
        self.verdict.seconds = time.perf_counter() - begin
        return self.verdict

    def _judge(self, light: bool) -> None:
        model = self._build("build", self.train, None)
        if model is None:
            return
        used = self._run("default", model, method="auto", rtol=1e-6)
        drawn = self.random.choice(METHODS)
        self._run("drawn", model, method=drawn, rtol=self.random.choice((1e-6, 1e-7, 1e-8)))
        fine = self.random.choice([m for m in METHODS if m != used])
        if not light:
            self._run("fine", model, method=fine, rtol=FINE)
            shuffled = self._build("shuffled", self.train, Random(f"order {self.train.seed}"))
            if shuffled is not None:
                self._run("shuffled", shuffled, method=used or "dp8", rtol=FINE)
        if self.train.family in ("inertialess", "positioner"):
            self._against_limit()
        else:
            self._against_reference()
        if not light:
            if not {"reference", "limit"} & set(self.verdict.evidence):
                self._against_each_other(model, fine)
            self._without()
        if self.verdict.kind == "right" and not self.verdict.evidence:
            self.verdict.kind = "none"

    # -- runs ---------------------------------------------------------------------------------------------------------

    def _build(self, name: str, train: Train, order: Random | None) -> Any:
        self.stage(name)
        try:
            return self.gb.build(build(train, self.gb, order))
        except self.gb.GearblocksError as error:
            self.verdict.fails("refused", name, f"{type(error).__name__}: {error}")
        except Exception as error:  # noqa: BLE001  whatever else comes out of a legal train is a finding
            self.verdict.fails("crash", name, f"{type(error).__name__}: {error}")
        return None

    def _run(self, name: str, model: Any, **options: Any) -> str | None:
        """Runs, checks the ledger, keeps the motion; the method that was used, or None where it failed."""
        self.stage(name)
        given = arguments(self.train, self.gb)
        text = f"{name}, method={options['method']!r}, rtol={options['rtol']:g}"
        try:
            with cpu_limit(CPU_LIMIT):
                run = self.gb.simulate(model, t=self.t, **given, **options)
        except HangError:
            if name in ("default", "drawn"):
                self.verdict.fails("hang", text, f"more than {CPU_LIMIT:g} s of processor time")
            return None
        except self.gb.SimulationError as error:
            if grows_beyond_machines(error):
                self.verdict.notes.append(f"{text}: {error}")
            else:
                self.verdict.fails("stopped", text, str(error))
            return None
        except self.gb.GearblocksError as error:
            if "needs the Jacobian" in str(error):  # said by name, with the way out
                return self._run(name, model, **options | {"method": "dp8"})
            self.verdict.fails("refused", text, f"{type(error).__name__}: {error}")
            return None
        except Exception as error:  # noqa: BLE001  see above
            self.verdict.fails("crash", text, f"{type(error).__name__}: {error}")
            return None
        residual = run.energy.residual
        if not residual <= LEDGER * options["rtol"] + 1e-12:
            self.verdict.fails("ledger", text, f"energy residual {residual:.1e}")
        if not run.energy.heat_residual <= LEDGER * options["rtol"] + 1e-12:
            self.verdict.fails("ledger", text, f"residual {run.energy.heat_residual:.1e} of heat")
        self.runs[text] = (options["rtol"], motion_of(run, self.train))
        return run.stats.method if run.stats.method in METHODS else "dp8"

    # -- comparisons --------------------------------------------------------------------------------------------------

    def _against_reference(self) -> None:
        from tests.random.reference import NoEvidenceError, WrongStartError, reference_motion

        self.stage("reference")
        try:
            with cpu_limit(2 * CPU_LIMIT):
                true = reference_motion(self.train, self.t, given=self._given())
            self._compare("reference", true, lambda draw: self._magnification(true, draw))
        except NoEvidenceError as reason:
            self.verdict.notes.append(f"no reference: {reason}")
        except WrongStartError as wrong:
            self.verdict.fails("wrong", "start", str(wrong))
        except HangError:
            self.verdict.notes.append("no reference: too slow")

    def _against_limit(self) -> None:
        """Against the same train with small inertias where there are none, or steep lines where relays jump, extrapolated
        twice: other equations, states and switching. What both extrapolations do not agree on is no evidence."""
        from tests.random.families.inertialess import with_inertias
        from tests.random.families.positioner import widened

        made = widened if self.train.family == "positioner" else with_inertias

        self.stage("limit")
        found: list[Motion] = []
        switched: list[list[tuple[str, float]]] = []
        if not self.runs:
            return
        for share in (4e-4, 2e-4, 1e-4):
            train = made(self.train, share)
            try:
                with cpu_limit(CPU_LIMIT):
                    run = self.gb.simulate(build(train, self.gb), t=self.t, rtol=1e-8, **arguments(train, self.gb))
            except (self.gb.GearblocksError, HangError) as reason:
                self.verdict.notes.append(f"no limit: {reason}")
                return
            found.append(motion_of(run, self.train))
            switched.append([(f"{e.component} {e.kind}", e.t) for e in run.events])
        hidden = samples_that_switches_pass(switched[1], switched[2], self.t)
        first, second = (
            Motion(2 * b.angles - a.angles, 2 * b.speeds - a.speeds, np.append(b.jumps, hidden))
            for a, b in itertools.pairwise(found)
        )
        unsure = 1e-4 + np.maximum.accumulate(10 * deviations(first, second, self.t))
        moved = deviations(found[1], found[2], self.t)  # by a change of 1e-4, or 1e-4 rad/s
        self._compare("limit", second, lambda _: moved / 1e-4, unsure)

    def _given(self) -> Array | None:
        """Angles and speeds at the start of the first run, to be looked at by the reference where it is not given by values."""
        return next((np.array([m.angles[:, 0], m.speeds[:, 0]]) for _, m in self.runs.values()), None)

    def _magnification(self, true: Motion, draw: int) -> Array:
        """How much the train magnifies small changes: of two draws in a row one is the other's negative.

        The second half of the draws has as many changes as impacts: a hundred flights make a hundred errors, alike.
        """
        from tests.random.reference import KICKS, reference_motion

        change = -PERTURBATION if draw % 2 else PERTURBATION
        kicks = max(KICKS, len(true.jumps)) if draw >= DRAWS // 2 else KICKS
        with cpu_limit(2 * CPU_LIMIT):
            other = reference_motion(self.train, self.t, change, given=self._given(), draw=draw // 2, kicks=kicks)
        return deviations(other, true, self.t) / PERTURBATION

    def _against_each_other(self, model: Any, method: str) -> None:
        fine = next((m for text, (_, m) in self.runs.items() if text.startswith("fine")), None)
        others = {text: r for text, r in self.runs.items() if not text.startswith("fine")}
        if fine is None or not others:
            return
        self._compare("other method", fine, lambda draw: self._perturbed(model, fine, method, draw))
        if any(text.startswith("shuffled") for text in others) and "other method" in self.verdict.evidence:
            self.verdict.evidence.append("other order")

    def _perturbed(self, model: Any, true: Motion, method: str, draw: int) -> Array:
        """How much the train magnifies a change of its inertias; in the second half of the draws of its restitutions, too.

        A restitution that is off changes every flight alike, as the errors of a hundred equal ones do.
        """
        rng = Random(f"perturb {self.train.seed}" + f" {draw}" * (draw > 0))
        changed = {}
        for stop in self.train.parts if draw >= DRAWS // 2 else ():
            if stop.block == "HardStop" and stop.field("restitution"):
                changed[f"{stop.name}.restitution"] = stop.field("restitution") * (1 - PERTURBATION)
        for body in self.train.bodies:
            name = BODIES[body.block]
            changed[f"{body.name}.{name}"] = body.field(name) * (1 + PERTURBATION * rng.uniform(-1, 1))
        try:
            with cpu_limit(CPU_LIMIT):
                given = arguments(self.train, self.gb)
                run = self.gb.simulate(model, t=self.t, rtol=FINE, method=method, parameters=changed, **given)
        except (self.gb.GearblocksError, HangError):
            return np.full(len(self.t), np.inf)
        off = deviations(motion_of(run, self.train), true, self.t) - 10 * FINE
        return np.asarray(np.maximum(off, 0.0) / PERTURBATION)

    def _compare(
        self, evidence: str, true: Motion, magnification: Callable[[int], Array], unsure: Array | float = 0.0
    ) -> None:
        """Every run against a motion; where one is off, how much the train magnifies errors up to then decides."""
        found = {text: deviations(m, true, self.t) for text, (_, m) in self.runs.items() if m is not true}
        factor, judged = self._growth(found, magnification, unsure), 0
        for text, off in found.items():
            allowed = self._allowed(text, factor) + unsure
            tame = allowed <= CHAOTIC
            if off.max() > allowed.min() and not tame.all():
                growth, until = f"{factor.max():.1e}", self.t[tame].max(initial=0.0)
                self.verdict.notes.append(f"sensitive ({text}): errors grow by {growth}, compared until {until:.3g} s")
            if tame.mean() >= COMPARED:
                judged += 1
            worst = int(np.argmax(np.where(tame, off / allowed, 0.0)))
            if tame[worst] and off[worst] > allowed[worst]:
                message = (
                    f"off by {off[worst]:.1e} from {evidence} at {self.t[worst]:.3g} s, {allowed[worst]:.1e} allowed"
                )
                self.verdict.fails("wrong", text, message)
        if judged or (not found and self.verdict.kind != "right"):  # no run, but the motion that there is
            self.verdict.evidence.append(evidence)

    def _allowed(self, text: str, factor: Array) -> Array:
        return FACTOR * self.runs[text][0] * factor

    def _growth(
        self, found: dict[str, Array], magnification: Callable[[int], Array], unsure: Array | float = 0.0
    ) -> Array:
        """How much errors grow up to each time, at least 1: further draws only as long as a run would count as wrong.

        One draw may miss what magnifies most: an order of two impacts that only the other sign changes, a bounce so low that
        none of its changes falls into it.
        """
        from tests.random.reference import NoEvidenceError

        factor = np.ones(len(self.t))
        for draw in range(DRAWS):
            if all(bool((off <= self._allowed(text, factor) + unsure).all()) for text, off in found.items()):
                break
            try:
                factor = np.maximum(factor, 1.0 + np.maximum.accumulate(magnification(draw)))
            except (NoEvidenceError, HangError):
                if draw == 0:
                    raise
                break
        return factor

    def _without(self) -> None:
        """A compliant part taken away against the train that was built without it; from rest."""
        self.stage("without")
        pair = tied_pair(self.train, self.random)
        if pair is None or self.verdict.kind != "right":
            return
        name, rested, built = pair
        try:
            with cpu_limit(2 * CPU_LIMIT):
                taken = build(rested, self.gb).without(f"{name}.compliance")
                options = {"rtol": 1e-8, "t": self.t, **arguments(rested, self.gb)}
                one = self.gb.simulate(taken, **options)
                other = self.gb.simulate(build(built, self.gb), **options)
        except (self.gb.GearblocksError, HangError) as error:
            self.verdict.notes.append(f"without {name}: {type(error).__name__}: {error}")
            return
        off = deviation(motion_of(one, rested), motion_of(other, rested), self.t)
        if off > FACTOR * 1e-8:
            self.verdict.notes.append(f"without {name}: off by {off:.1e}")
            if off > CHAOTIC and not self.verdict.evidence:
                self.verdict.kind = "none"
        else:
            self.verdict.evidence.append("without")


def as_dict(verdict: Verdict) -> dict[str, Any]:
    """Plain values, for the way back from a worker."""
    return dataclasses.asdict(verdict)
