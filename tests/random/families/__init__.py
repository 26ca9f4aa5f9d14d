"""Eighteen families of random trains; each is a function from a seed to a description."""

from __future__ import annotations

from collections.abc import Callable

from tests.random.description import Train
from tests.random.families.contact import contact
from tests.random.families.control import control
from tests.random.families.feedback import feedback
from tests.random.families.friction import friction
from tests.random.families.given import given
from tests.random.families.heat import heat
from tests.random.families.inertialess import inertialess
from tests.random.families.late import late
from tests.random.families.laws import laws
from tests.random.families.lossy import lossy
from tests.random.families.mixed import mixed
from tests.random.families.positioner import positioner
from tests.random.families.rounded import rounded
from tests.random.families.smooth import smooth
from tests.random.families.starts import starts
from tests.random.families.vehicle import vehicle
from tests.random.families.warm import warm
from tests.random.families.wide import wide

FAMILIES: dict[str, Callable[[int], Train]] = {
    f.__name__: f
    for f in (
        smooth,
        contact,
        friction,
        lossy,
        control,
        mixed,
        wide,
        laws,
        inertialess,
        heat,
        vehicle,
        feedback,
        starts,
        rounded,
        warm,
        given,
        positioner,
        late,
    )
}


def draw(family: str, seed: int) -> Train:
    """The train of a family that belongs to a seed."""
    return FAMILIES[family](seed)
