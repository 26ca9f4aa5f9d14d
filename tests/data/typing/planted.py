"""A train with mistakes that a type checker finds before anything runs: each marked line has one, no other line has any."""

import gearblocks as gb

rig = gb.Drivetrain("rig")
disc = rig.add("disc", gb.Inertia(J=1.0))
pair = gb.GearMesh(teeth=(20, 30), external=True, module="3 mm", pressure_angle="20 deg", k=gb.Parameter("k", 1e8))
mesh = rig.add("mesh", pair)
gb.Inertia(J=1.0, w_0=3.0)  # wrong keyword
gb.Backlash(half_gp=1e-5)  # wrong keyword of an effect
gb.Inertia(J=[1.0])  # wrong type
gb.Torque(tau=[1.0])  # wrong type of a signal
gb.GearMesh(teeth=(20, 30), external=True, backlash=gb.Fourier(cos=(0.1,)))  # wrong effect
gb.Inertia()  # a required field is missing
rig.connect(mesh.pinon, disc.a)  # wrong flange
print(mesh.modul)  # wrong field
gb.simulate(rig, t_endd=1.0)  # misspelt argument
gb.simulate(rig, t_end=1.0, method=5)  # wrong type of an argument
gb.simulate(rig, 1.0)  # nameless argument
rig.outputs(3)  # wrong pattern
