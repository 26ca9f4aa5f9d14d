"""Launch of a car on a hill with a dual-clutch gearbox: hill hold, first gear, second gear, without a gap in the torque.

    engine - crank -+- K1 - shaft 1 - first gear  -+- output - half shafts - wheels - car on a grade
                    +- K2 - shaft 2 - second gear -+                           hill hold

The brake of the hill hold keeps the car at rest on a slope of 12 percent while K1 fills; it opens while K1 takes the
weight over, and the car starts without rolling back. Then K1 locks, and at 5 s the torque goes over from K1 to K2: both
slip for a moment, and the engine follows to the lower speed. Shaft 2 turns with the output all the time.

Run as a script it draws `dual_clutch.png`.
"""

from __future__ import annotations

import math

import gearblocks as gb

GRADE = math.atan(0.12)
FIRST, SECOND = 13.6, 8.2
"""Shaft over wheel speed, final drive included."""
MASS, RADIUS, T_END = 1550.0, 0.32, 9.0  # kg, m, s

ENGINE = gb.Table2(
    [0.0, 80.0, 100.0, 200.0, 300.0, 400.0, 520.0, 620.0],  # rad/s
    [0.0, 1.0],
    [[90, 90], [25, 130], [-12, 145], [-18, 190], [-24, 215], [-30, 210], [-40, 180], [-50, -50]],  # N m
)
THROTTLE = gb.Table([0.5, 1.4, 5.0, 5.1, 5.5, 5.9], [0.0, 0.72, 0.72, 0.4, 0.4, 0.72])
K1 = gb.Table([0.5, 1.4, 2.6, 3.4, 4.6, 4.9, 5.12], [0.0, 95.0, 120.0, 200.0, 200.0, 130.0, 0.0])
K2 = gb.Table([4.9, 5.15, 6.0, 6.6], [0.0, 115.0, 120.0, 200.0])
HOLD = gb.Table([0.9, 1.5], [1400.0, 0.0])
"""Capacities over time, N m. Between 4.9 and 5.2 s one clutch gives to the other."""


def build() -> gb.Drivetrain:
    """The launch from hill hold, 9 s."""
    rig = gb.Drivetrain("dual-clutch launch")
    engine = rig.add("engine", gb.Engine(torque_map=ENGINE, throttle=THROTTLE))
    crank = rig.add("crank", gb.Inertia(J=0.16, w0=88.0))
    rig.chain(engine, crank)
    output = rig.add("output", gb.Inertia(J=0.08))
    for name, ratio, capacity in (("1", FIRST, K1), ("2", SECOND, K2)):
        clutch, shaft = rig.add(f"K{name}", gb.Clutch(capacity=capacity)), rig.add(f"shaft{name}", gb.Inertia(J=6e-3))
        gear = rig.add(f"gear{name}", gb.IdealGear(ratio=ratio))
        rig.chain(crank, clutch, shaft, gear, output)
    half_shafts, wheels = rig.add("half_shafts", gb.Shaft(k=9000.0, c=300.0)), rig.add("wheels", gb.Inertia(J=2.2))
    car = gb.Vehicle(
        mass=MASS, wheel_radius=RADIUS, drag_area=0.65, rolling=0.011, rolling_speed=0.05, grade=GRADE
    )  # fmt: skip
    rig.chain(output, half_shafts, wheels, rig.add("car", car))
    rig.connect(rig.add("hill_hold", gb.Brake(capacity=HOLD)).a, wheels.b)
    return rig


def draw(run: gb.Trajectory, path: str) -> None:
    """Speeds, torques and the speed of the car over time."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(3, 1, figsize=(9, 9), sharex=True, layout="constrained")
    for name in ("crank", "shaft1", "shaft2"):
        axes[0].plot(run.t, run[f"{name}.w"], lw=1, label=name)
    axes[0].set_ylabel("speed in rad/s")
    for name in ("engine", "K1", "K2"):
        axes[1].plot(run.t, run[f"{name}.torque"], lw=1, label=name)
    axes[1].plot(run.t, run["hill_hold.torque"] / 10, lw=1, label="hill hold / 10")
    axes[1].set_ylabel("torque in N m")
    axes[2].plot(run.t, 3.6 * run["car.v"], lw=1)
    axes[2].set(xlabel="time in s", ylabel="speed of the car in km/h")
    for axis in axes[:2]:
        axis.legend(loc="upper left", fontsize=8)
    figure.savefig(path, dpi=110)
    plt.close(figure)


if __name__ == "__main__":
    shown = gb.simulate(build(), t_end=T_END)
    print(shown.stats, shown.energy, sep="\n")
    draw(shown, "dual_clutch.png")
