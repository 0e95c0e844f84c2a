#!/usr/bin/python3
"""A jet of 60 m/s through 1.6 mm into a packed bed of 0.75 mm particles, at once, four fine cells of 0.4 mm across the jet,
particle cells of 3.2 d; formulations A and B, particles that read the mean of their particle cell or the fine grid.

Bounded, at every step: gas speed, particle speed, Courant number (at most the 0.4 asked for), no particle lost. Kinetic and
potential energy of the particles never exceed what they had at first plus the fluid's work on them, since contacts only
dissipate; with elastic contacts without friction, energy and work agree to 1 %. The work is measured outside the coupling, by
LIGGGHTS: force on the particle times its velocity, and what the velocity jumps by at couplings. Gas out = in + displaced to ten
times the tolerance of the pressure.

Without this test a step that is chosen from the velocity before the jet came, a drag that overshoots the gas's velocity, or
a kick at couplings that heats the particles would pass as a vigorous bed.

--long: ten times as long.
"""
import h5py
import numpy as np

from hard import (Checks, Run, arguments, column, data_file, gas_balance, head_with_particles, long_form, settled, walls)

D, RHO, RHO_P, MU, G, U = 0.75e-3, 1.2, 2500.0, 1.8e-5, 9.81, 60.0
DT, EVERY = 4e-6, 2
W, DEPTH, H = 16.8e-3, 2.4e-3, 30e-3
SOFT = dict(kn=1000, kt=285)
LOSSY = dict(gamman=0.01, gammat=0.005, mu=0.1)
ELASTIC = dict(gamman=0, gammat=0, mu=0.0)


def packing(executable):
    rng = np.random.default_rng(3)
    a, b = (np.arange(21) + 0.5) * W / 21, (np.arange(3) + 0.5) * DEPTH / 3
    x = [(p + 2e-5 * rng.uniform(-1, 1), q, z) for z in (np.arange(14) + 0.55) * 1.03 * D for q in b for p in a]
    return settled(executable, f"0 {W} 0 {DEPTH} 0 {H}", x, D, RHO_P, 6000, 1e-5, skin=3e-4, **LOSSY)


def script(x, formulation, read, contact, steps):
    per_mass = DT / 2
    return data_file(f"0 {W} 0 {DEPTH} 0 {H}", x, D, RHO_P), head_with_particles(DT, boundary="f f f", skin=3e-4, **SOFT, **contact) + walls(
        xplane=(0, W), yplane=(0, DEPTH), zplane=(0, H)) + f"""
fix grav all gravity {G} vector 0 0 -1
fix integrate all nve/sphere
fix gas all twogrid fine 42 1 40 ratio 6 1 4 density {RHO} viscosity {MU} every {EVERY}
fix_modify gas formulation {formulation} read {read} cfl 0.4
fix_modify gas boundary zlo slip boundary zlo patch jet rect {W / 2 - 0.8e-3!r} {W / 2 + 0.8e-3!r} 0 {DEPTH} inlet 0 0 {U}
fix_modify gas boundary zhi pressure 0
fix_modify gas boundary xlo slip boundary xhi slip boundary ylo slip boundary yhi slip
fix_modify gas output every 100 file bed.h5 fields u p eps faces particles no
# Work of the fluid: force times velocity at whole steps, and the change of m v^2/2 that is not of the step's forces. The
# order of these fixes matters: 'before' still holds the last step's values when 'work' is evaluated.
fix now all ave/atom 1 1 1 f_gas[1] f_gas[2] f_gas[3] f_gas[4] f_gas[5] f_gas[6]
variable power atom (f_now[1]+f_now[4])*vx+(f_now[2]+f_now[5])*vy+(f_now[3]+f_now[6])*vz
variable kick atom 0.5*mass*({'+'.join(f'(v{a}-{per_mass!r}*f{a}/mass)^2-(f_before[{i}]+{per_mass!r}*f_before[{i + 3}]/mass)^2' for i, a in ((1, 'x'), (2, 'y'), (3, 'z')))})
compute power all reduce sum v_power
compute kick all reduce sum v_kick
variable kinetic atom 0.5*mass*(vx^2+vy^2+vz^2)
compute kinetic all reduce sum v_kinetic
compute spin all erotate/sphere
variable height atom mass*z
compute height all reduce sum v_height
fix work all ave/time 1 1 1 c_power c_kick c_kinetic c_height c_spin file work.txt
fix before all ave/atom 1 1 1 vx vy vz fx fy fz
variable speed atom sqrt(vx*vx+vy*vy+vz*vz)
compute fastest all reduce max v_speed
thermo {EVERY}
thermo_style custom step atoms c_fastest f_gas[2] f_gas[3] f_gas[5] f_gas[6] f_gas[7] f_gas[9]
thermo_modify format float %.14g lost error
dump d all custom {steps} dump.txt id x y z vx
dump_modify d format "%d %.17g %.17g %.17g %.17g"
run {steps}
"""


def elastic_energy(x):
    """Of the contacts, kn delta^2/2."""
    gap = np.linalg.norm(x[:, None] - x[None], axis=2)[np.triu_indices(len(x), 1)]
    wall = np.concatenate([x[:, a] - at if at == 0 else at - x[:, a] for a, at in ((0, 0), (0, W), (1, 0), (1, DEPTH), (2, 0), (2, H))])
    return 0.5 * SOFT["kn"] * (np.sum(np.maximum(0, D - gap)**2) + np.sum(np.maximum(0, D / 2 - wall)**2))


def main():
    executable, _ = arguments()
    c = Checks("jet of 60 m/s into a packed bed, at once")
    steps = 10000 if long_form() else 1000
    x = packing(executable)
    cases = [("B", "cell", LOSSY), ("A", "cell", LOSSY), ("B", "fine/trilinear", LOSSY), ("B", "cell", ELASTIC)]
    for formulation, read, contact in cases:
        elastic = contact is ELASTIC
        what = f"{formulation}, read {read}" + (", elastic" if elastic else "")
        data, text = script(x, formulation, read, contact, steps)
        r = Run(executable, text, 1, files={"particles.data": data}, timeout=3000, expect_success=False)
        if r.code:
            c.true(f"{what}: runs to the end: {r.output[-400:]}", False)
            continue
        t = r.thermo()
        col = lambda name: column(t, name)
        with h5py.File(r.file("bed.h5")) as f:
            gas = max(np.abs(frame["faces/u" + a][()]).max() for frame in f["fluid"].values() for a in "xz")
        c.below(f"{what}: Courant number", col("f_gas[3]").max(), 0.4)
        c.below(f"{what}: gas speed / (jet / smallest void fraction)", gas / (U / col("f_gas[9]").min()), 1)
        c.below(f"{what}: particle speed / jet", col("c_fastest").max() / U, 1)
        c.true(f"{what}: no particle lost", t["Atoms"][-1] == len(x))
        c.below(f"{what}: gas out - in - displaced / in", gas_balance(r.file("bed.h5"), U * 1.6e-3 * DEPTH), 1e-5)
        step, power, kick, kinetic, height, spin = np.loadtxt(r.file("work.txt")).T
        kick[:1] = 0  # there is no step before the first
        work = np.cumsum(DT * power + kick) - 0.5 * DT * power
        energy = kinetic + spin + (1 - RHO / RHO_P) * G * height
        first, last = (np.stack([f[a] for a in "xyz"], axis=1) for f in (r.dump("dump.txt")[0][1], r.dump("dump.txt")[-1][1]))
        at_first = (1 - RHO / RHO_P) * G * RHO_P * np.pi / 6 * D**3 * first[:, 2].sum() + elastic_energy(first)
        excess = np.max(energy - at_first - work) / work[-1]
        c.note(f"{what}: work {work[-1]:.3e} J, of it kicks {np.sum(kick):.1e} J, kinetic {kinetic[-1]:.3e} J, potential "
               f"{energy[-1] - kinetic[-1] - spin[-1] - at_first:.3e} J; gas to {gas:.0f} m/s, particles to {col('c_fastest').max():.1f} m/s, "
               f"fluid step {col('f_gas[2]')[1:].min():.1e} s")
        c.below(f"{what}: energy less work less energy at first / work, at any step", excess, 0)
        if elastic:
            c.below(f"{what}: energy with that of the contacts against the work", abs(energy[-1] + elastic_energy(last) - at_first - work[-1]) / work[-1], 0.01)
    c.end()


if __name__ == "__main__":
    main()
