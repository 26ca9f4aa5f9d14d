"""Automatic gearbox: engine map, torque converter, Ravigneaux set with two clutches and two brakes, a car and its driver.

    engine - crank - converter - turbine -+- C1 - small sun \\
                                          +- C2 - carrier ---+- ring - final drive - half shafts - wheels - car
                                    B1 - large sun, B2 - carrier                                  service brake

    gear   C1   C2   B1   B2    input/output
      1     x              x    76/30              = 2.533
      2     x         x         (a + b)/(1 + b)    = 1.493      a = 76/30, b = 76/36
      3     x    x              1
      4          x    x         b/(1 + b)          = 0.679

`Controller` shifts by the speed of the car and the throttle: one state per shift runs from 0 (the lower gear) to 1 (the
upper one) and tells the pressures of the element that opens and of the one that closes, which overlap. The driver is two
tables over time, throttle and brake: up through the gears, down to a crawl, up again, and to a stop, 60 s in all. The
numbers are those of a plausible car of 1500 kg, not of a product.

Run as a script it draws `automatic_gearbox.png`.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import gearblocks as gb

RATIO_SMALL, RATIO_LARGE = -76 / 30, 76 / 36
"""Ring over sun; negative: two planets between small sun and ring."""
GEARS = (76 / 30, (76 / 30 + 76 / 36) / (1 + 76 / 36), 1.0, 76 / 36 / (1 + 76 / 36))
FINAL, T_END = 3.7, 60.0

ENGINE = gb.Table2(
    [0.0, 80.0, 100.0, 200.0, 300.0, 400.0, 520.0, 620.0],  # rad/s
    [0.0, 1.0],
    [[90, 90], [25, 130], [-12, 145], [-18, 190], [-24, 215], [-30, 210], [-40, 180], [-50, -50]],  # N m
)
CAPACITY = gb.Table([-0.5, 0.5, 0.8, 0.9, 1.0, 1.15], [3.9e-3, 3.7e-3, 2.8e-3, 1.9e-3, 0.0, -2.0e-3])
TORQUE_RATIO = gb.Table([-0.5, 0.86], [2.6, 1.0])
"""Over the speed ratio, without a corner at 0, where the turbine stands still."""
THROTTLE = gb.Table(
    [0.0, 1.0, 2.0, 17.0, 18.0, 29.0, 30.0, 38.0, 39.0, 43.0, 43.5, 47.0, 48.0],
    [0.0, 0.0, 0.6, 0.6, 0.0, 0.0, 0.7, 0.7, 0.2, 0.2, 0.95, 0.95, 0.0],
)
BRAKING = gb.Table(
    [0.0, 0.5, 1.0, 18.5, 19.5, 27.0, 28.0, 49.0, 50.0, 60.0],
    [900.0, 900.0, 0.0, 0.0, 1100.0, 1100.0, 0.0, 0.0, 1800.0, 1800.0],
)  # N m at the wheels


class Controller(gb.Block):
    """Shifts a gearbox of four gears; exerts no torque.

    Shift i moves its state x from 0 to 1 in shift_time while the wheels turn faster than up[i] + up_throttle[i] throttle,
    and back while they are slower than down[i] + down_throttle[i] throttle; in between it finishes what is more than half
    done and takes back the rest. On the way the element that opens fades out over x = 0 .. 0.4, the one that closes comes
    in over x = 0.1 .. 1; below 0 they are free. c1, c2, b1, b2: shares of the capacities. gear: 1 + the sum of the states.
    """

    flange = gb.Flange("wheels, whose speed is sensed")
    throttle: Any = gb.signal("throttle, 0 to 1")
    up: Any = gb.param("speeds of the upshifts without throttle", "rad/s", many=True, symbol="omega_up")
    up_throttle: Any = gb.param("what full throttle adds to them", "rad/s", many=True, symbol="a_up")
    down: Any = gb.param("speeds of the downshifts without throttle", "rad/s", many=True, symbol="omega_down")
    down_throttle: Any = gb.param("what full throttle adds to them", "rad/s", many=True, symbol="a_down")
    shift_time: float = gb.param("duration of a shift", "s", gt=0, symbol="T_s")
    first, second, third = (
        gb.State(f"progress of the shift from {i} to {i + 1}", symbol=f"s_{i}{i + 1}") for i in (1, 2, 3)
    )

    def physics(self, s: Any) -> Iterator[Any]:
        """The states of the shifts and the pressures that follow from them."""
        import sympy as sp

        w, shifts = s.flange.w, (s.first, s.second, s.third)
        for i, x in enumerate(shifts):
            up, down = s.up[i] + s.up_throttle[i] * s.throttle, s.down[i] + s.down_throttle[i] * s.throttle
            faster = sp.Or(w >= up, sp.And(w >= down, x >= sp.Rational(1, 2)))
            upward, downward = sp.Piecewise((0, x >= 1), (1, True)), sp.Piecewise((0, x <= 0), (1, True))
            yield gb.Rate(x, sp.Piecewise((upward, faster), (-downward, True)) / s.shift_time)
        closing = [(10 * x - 1) / 9 for x in shifts]
        opening = [1 - sp.Rational(5, 2) * x for x in shifts]
        yield gb.Shows("c1", opening[2])
        yield gb.Shows("c2", closing[1])
        yield gb.Shows("b1", sp.Max(sp.Min(closing[0], opening[1]), closing[2]))
        yield gb.Shows("b2", opening[0])
        yield gb.Shows("gear", 1 + sum(shifts))


def build() -> gb.Drivetrain:
    """The car with its driver: 60 s, fourteen shifts."""
    rig = gb.Drivetrain("automatic gearbox")
    engine = rig.add("engine", gb.Engine(torque_map=ENGINE, throttle=THROTTLE))
    crank, turbine = rig.add("crank", gb.Inertia(J=0.18, w0=90.0)), rig.add("turbine", gb.Inertia(J=0.05))
    converter = rig.add("converter", gb.TorqueConverter(capacity=CAPACITY, ratio=TORQUE_RATIO))
    rig.chain(engine, crank)
    rig.connect(crank.b, converter.impeller)
    rig.connect(converter.turbine, turbine.a)
    ring = _gearbox(rig, turbine)
    final = rig.add("final_drive", gb.IdealGear(ratio=FINAL))
    shafts = rig.add("half_shafts", gb.Shaft(k=9000.0, c=90.0))
    wheels = rig.add("wheels", gb.Inertia(J=2.5))
    car = gb.Vehicle(mass=1500.0, wheel_radius=0.31, drag_area=0.65, rolling=0.012, rolling_speed=0.05)
    rig.chain(ring, final, shafts, wheels, rig.add("car", car))
    control = Controller(
        throttle=THROTTLE, up=(12.0, 24.0, 38.0), up_throttle=(16.0, 28.0, 40.0), down=(9.0, 19.0, 31.0),
        down_throttle=(8.0, 18.0, 30.0), shift_time=0.8,
    )  # fmt: skip
    rig.connect(rig.add("control", control).flange, wheels.b)
    rig.connect(rig.add("brake", gb.Brake(capacity=BRAKING)).a, wheels.b)
    return rig


def _gearbox(rig: gb.Drivetrain, turbine: Any) -> Any:
    """Ravigneaux's set, its clutches, brakes and controller; returns the ring, its output."""
    small, large, carrier, ring = (
        rig.add(name, gb.Inertia(J=J))
        for name, J in (("small_sun", 4e-3), ("large_sun", 6e-3), ("carrier", 1.2e-2), ("ring", 2e-2))
    )
    for name, sun, ratio in (("small_set", small, RATIO_SMALL), ("large_set", large, RATIO_LARGE)):
        planets = rig.add(name, gb.IdealPlanetary(ratio=ratio))
        rig.connect(planets.sun, sun.a)
        rig.connect(planets.carrier, carrier.a)
        rig.connect(planets.ring, ring.a)
    for name, inner, most in (("c1", small, 400.0), ("c2", carrier, 400.0)):
        clutch = rig.add(name, gb.Clutch(capacity=most * gb.sense(f"control.{name}")))
        rig.connect(turbine.b, clutch.a)
        rig.connect(clutch.b, inner.b)
    for name, held, most in (("b1", large, 300.0), ("b2", carrier, 600.0)):
        rig.connect(rig.add(name, gb.Brake(capacity=most * gb.sense(f"control.{name}"))).a, held.b)
    return ring


def draw(run: gb.Trajectory, path: str) -> None:
    """Speeds, torques, and which clutches and brakes are stuck, slip or are free, over time."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    names = ("c1", "c2", "b1", "b2")
    figure, axes = plt.subplots(4, 1, figsize=(10, 11), sharex=True, layout="constrained")
    for name, words in (("crank.w", "engine"), ("turbine.w", "turbine"), ("ring.w", "output")):
        axes[0].plot(run.t, run[name], lw=1, label=words)
    axes[0].set_ylabel("speed in rad/s")
    axes[1].plot(run.t, 3.6 * run["car.v"], lw=1, label="car in km/h")
    axes[1].plot(run.t, 20 * run["control.gear"], lw=1, label="20 gear")
    for name in ("engine.torque", "converter.torque", "half_shafts.torque"):
        axes[2].plot(run.t, run[name] / (10 if name.startswith("half") else 1), lw=1, label=name)
    axes[1].set_ylabel("car and gear")
    axes[2].set_ylabel("torque in N m (half shafts: /10)")
    for row, name in enumerate(names):
        mode = run[f"{name}.mode"]
        for value, colour, words in (
            (0, "tab:green", "stuck"),
            (1, "tab:orange", "slips"),
            (-1, "tab:red", "slips back"),
        ):
            where = (mode == value).astype(float)
            axes[3].fill_between(
                run.t, row, row + 0.8 * where, step="post", color=colour, lw=0, label=words * (row == 0)
            )
    axes[3].set_yticks([i + 0.4 for i in range(4)], [name.upper() for name in names])
    axes[3].set_xlabel("time in s")
    axes[3].set_ylim(-0.2, 4.9)
    for axis in axes:
        axis.legend(loc="upper right", fontsize=8, ncols=3)
    figure.savefig(path, dpi=110)
    plt.close(figure)


if __name__ == "__main__":
    shown = gb.simulate(build(), t_end=T_END)
    print(shown.stats, shown.energy, sep="\n")
    draw(shown, "automatic_gearbox.png")
