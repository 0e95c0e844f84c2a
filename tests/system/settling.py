#!/usr/bin/python3
"""Homogeneous settling in a periodic box at eps = 0.4, density ratios 0.8, 1.05, 2.5 and 1000, coupling interval 0.01 to 100
response times, formulations A and B; closed (no net flux of the mixture) and open (the mixture's weight balanced by a
pressure gradient).

Without this test a fluid velocity frozen over the interval would pass, which blows up from 0.2 (gas) or 0.01 (light
particles, A) response times on; so would a held flux that settles at the wrong slip, and 'hold off' where it can't hold, without a word.
Reference: slip = (rho_p - rho_f) V_p g eps / b with Stokes' drag b = 3 pi mu d, from the balance of drag, pressure
gradient and buoyant weight. Contacts are switched off (springs of 1e-12 N/m): the lattice overlaps.
"""
import math

import numpy as np

from harness import Checks, Run, arguments, data_file, head_with_particles

D, RHO, G, EPS = 1e-3, 1000.0, 9.81, 0.4
TAU = 1e-3                   # response time by which the viscosity is chosen: short, so that nothing moves far
V = math.pi / 6 * D**3
SPACING = (V / (1 - EPS))**(1 / 3)


def viscosity(ratio):
    return ratio * RHO * V * EPS / (3 * math.pi * D * TAU)


def script(ratio, k, formulation, closed, steps):
    rho_p = ratio * RHO
    n = 6
    L = n * SPACING
    mu = viscosity(ratio)
    tau = TAU
    every = max(10, int(4 * k))  # the DEM step stays below a quarter of the response time
    dt = k * tau / every
    q = (np.arange(n) + 0.5) * SPACING
    x = [(a, c, z) for z in q for c in q for a in q]
    weight = (rho_p - RHO) * (1 - EPS) * G   # buoyant, of the mixture: what a pressure gradient has to carry
    drive = "fix_modify gas flow_rate z 0" if closed else f"fix_modify gas pressure_gradient 0 0 {-weight!r}"
    return data_file(f"0 {L!r} 0 {L!r} 0 {L!r}", x, D, rho_p), head_with_particles(dt, kn=1e-12, kt=1e-12, mu=0.0, skin=2e-4).replace(
        "neigh_modify delay 0", "neigh_modify delay 0 one 10000 page 100000") + f"""
fix grav all gravity {G} vector 0 0 -1
fix integrate all nve/sphere
fix gas all twogrid fine 4 4 4 ratio 2 2 2 density {RHO} viscosity {mu!r} every {every}
fix_modify gas drag stokes formulation {formulation} {'deposit trilinear'}
{drive}
compute vz all reduce ave vz
compute uz all reduce ave f_gas[10]
thermo {every}
thermo_style custom step atoms c_vz c_uz f_gas[3] f_gas[7] f_gas[9]
thermo_modify format float %.14g
run {steps * every}
"""


def main():
    executable, _ = arguments()
    c = Checks("homogeneous settling")
    for formulation in "BA":
        for closed in (True, False):
            for ratio in (0.8, 1.05, 2.5, 1000) if closed else (0.8, 2.5, 1000):
                exact = (ratio - 1) * RHO * V * G * EPS / (3 * math.pi * viscosity(ratio) * D)
                errors, swings = [], []
                for k in (0.01, 1, 100):
                    data, text = script(ratio, k, formulation, closed, {0.01: 1000, 1: 30, 100: 12}[k])
                    r = Run(executable, text, 1, ["-fluid_pressure_rtol", "1e-9"], files={"particles.data": data}, expect_success=False)
                    if r.code:
                        c.true(f"{formulation} ratio {ratio} Delta {k} tau runs: {r.output[-300:]}", False)
                        continue
                    t = r.thermo()
                    slip = (t["uz"] if "uz" in t else t["c_uz"]) - (t["vz"] if "vz" in t else t["c_vz"])
                    errors.append(abs(slip[-1] / exact - 1))
                    swings.append(np.max(slip / exact))
                what = f"{formulation} {'closed' if closed else 'open'} ratio {ratio}: Delta 0.01 to 100 tau"
                c.below(f"{what}: error of the steady slip", max(errors, default=np.nan), 5e-3)
                c.below(f"{what}: overshoot of the slip", max(swings, default=np.nan) - 1, 0.1)
    for k, told in ((0.4, True), (0.2, False)):
        data, text = script(2.5, k, "B", True, 10)
        r = Run(executable, text.replace("deposit trilinear", "deposit trilinear hold off"), files={"particles.data": data})
        c.true(f"'hold off' and an interval of {k} response times: {'told' if told else 'not told'} during the run",
               ("response times of a particle, wanted with 'hold off'" in r.output) == told)
    c.end()


if __name__ == "__main__":
    main()
