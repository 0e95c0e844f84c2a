#!/usr/bin/python3
"""A fluidised bed in momentum balance: over any window, the integral of (dp A - buoyant weight) against the change of the
mixture's momentum, the momentum carried in and out by the gas, and the force of the bottom on the particles.

Without this test a pressure drop that is off by the momentum of the inflow, by the void fraction at a boundary, or by an
interval that is counted twice would pass: the plain mean of dp hides it in the bed's own swings.
All figures come from outside the coupling: LIGGGHTS' velocities and wall forces, the written gas velocities, the
pressure drop of the fix's vector.
"""
import numpy as np

from harness import WALL, Checks, MixtureBalance, Run, arguments, column, data_file, head_with_particles, walls

L, H, D, RHO, RHO_P, U, G = 0.015, 0.06, 1e-3, 1.2, 2500.0, 1.3, 9.81
DT, EVERY, STEPS = 1e-5, 5, 12000


def script(formulation):
    rng = np.random.default_rng(11)
    x = [(a + 1e-4 * rng.uniform(), b + 1e-4 * rng.uniform(), z) for z in np.arange(0.5, 14) * 1.02 * D
         for b in np.arange(0.6, 13.4) * 1.1 * D for a in np.arange(0.6, 13.4) * 1.1 * D]
    data = data_file(f"0 {L} 0 {L} 0 {H}", x, D, RHO_P)
    bottom = WALL.format(id="bottom", plane="zplane", at=0.0).replace("absolute_damping", "store_force yes absolute_damping")
    return data, head_with_particles(DT, boundary="f f f", mu=0.0, gamman=0.01, kn=300, kt=300) + walls(
        xplane=(0, L), yplane=(0, L), zplane=(H,)) + bottom + f"""
fix grav all gravity {G} vector 0 0 -1
fix integrate all nve/sphere
fix gas all twogrid fine 10 10 40 ratio 2 2 2 density {RHO} viscosity 1.8e-5 every {EVERY}
fix_modify gas formulation {formulation} deposit trilinear
fix_modify gas boundary zlo inlet 0 0 {U} boundary zhi pressure 0
fix_modify gas boundary xlo slip boundary xhi slip boundary ylo slip boundary yhi slip
fix_modify gas initial u 0 0 {U}
fix_modify gas dt {EVERY * DT!r}
fix_modify gas output every {20 * EVERY} file bed.h5 fields u p eps faces particles no
variable mvz atom mass*vz
compute mvz all reduce sum v_mvz
compute fz all reduce sum f_force_bottom[3]
thermo 1
thermo_style custom step atoms c_mvz c_fz f_gas[4] f_gas[5] f_gas[6] f_gas[7] f_gas[9]
thermo_modify format float %.14g
run {STEPS}
"""


def main():
    executable, ranks = arguments()
    c = Checks("momentum balance of a fluidised bed")
    for formulation in "BA":
        data, text = script(formulation)
        r = Run(executable, text, max(ranks), ["-fluid_pressure_rtol", "1e-8"], timeout=280, files={"particles.data": data})
        t = r.thermo()
        step, mv, fz = t["Step"].astype(int), column(t, "c_mvz"), column(t, "c_fz")
        dp, area = column(t, "f_gas[4]"), L * L
        weight = t["Atoms"][0] * np.pi / 6 * D**3 * (RHO_P - RHO) * G
        balance = MixtureBalance(r.file("bed.h5"), RHO, EVERY, DT, weight, step, mv, fz, dp, U)
        worst, first = 0.0, 2000  # the impulsive start is not a window
        for begin, end in [(first, 4000), (3000, 5000), (first, 8000), (5000, 11000), (first, STEPS)]:
            w = balance.window(begin, end)
            c.note(f"{formulation} window {w['begin'] * DT:.3f}-{w['end'] * DT:.3f} s: dp A/weight {w['dp']:.4f}, "
                   f"floor {w['wall']:+.4f}, momentum {w['change']:+.4f}, error {w['error']:.2e}")
            worst = max(worst, w["error"])
        c.below(f"{formulation}: balance over any window / (weight x time)", worst, 1e-3)
        batches = np.array_split(dp[balance.coupled & (step > first)] * area / weight, 10)
        means = np.array([b.mean() for b in batches])
        c.note(f"{formulation}: mean of dp A / weight {means.mean():.4f} +- {means.std(ddof=1) / np.sqrt(len(means)):.4f} (batch error)")
        c.below(f"{formulation}: momentum exchange error", column(t, "f_gas[7]").max(), 1e-12)
        c.true(f"{formulation}: no particle lost", t["Atoms"][-1] == t["Atoms"][0])
    c.end()


if __name__ == "__main__":
    main()
