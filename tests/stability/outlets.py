#!/usr/bin/python3
"""An outlet under backflow, and a closed box.

Backflow: a bubbling bed whose inlet blows and sucks by turns, so that gas comes in through the outlet half of the time; a jet
that draws gas in through the outlet beside it. Bounded, over the whole run: gas speed; gas out = in + displaced; no particle
lost. Closed box, particles falling: the mean of p stays 0 (p is defined up to a constant), its range below the weight
per area; inlets that balance run, those that don't are refused with a sentence, also when changed between runs.
Without this test an outlet that feeds energy to what comes in, a constant of p that drifts away, or an inflow without a way
out that is silently spread over the domain would pass.
"""
import time

import h5py
import numpy as np

from hard import Checks, Run, arguments, column, head, walls
from small_bed import DEPTH, G, H, N, RHO, RHO_P, V_P, W, small_bed


def frames(path):
    """Of every frame but the first: in at the floor, out at the top (m3/s), displaced by the particles, part of the top with
    inflow, largest speed, mean and range of p."""
    rows = []
    with h5py.File(path) as f:
        x, y, z = (np.diff(f["grid/" + a][()]) for a in "xyz")
        area = np.outer(y, x)
        for name in sorted(f["fluid"])[1:]:
            g = f["fluid/" + name]
            flux, rate, p = g["faces/flux_z"][()], g["faces/deps_dt"][()], g["p"][()]
            V = z[:, None, None] * area
            rows.append(((flux[0] * area).sum(), (flux[-1] * area).sum(), -(rate * V).sum(), np.mean(flux[-1] < 0),
                         max(np.abs(g["faces/u" + a][()]).max() for a in "xyz"), (p * V).sum() / V.sum(), np.ptp(p)))
    return np.array(rows).T


def pulsating(c, executable):
    swing = 1.8  # superficial, m/s
    data, text = small_bed(5000, every=10, before=f"variable U equal 0.4+{swing}*sin(2*PI*step*2e-5/0.02)", floor="inlet 0 0 v_U",
                           extra="fix_modify gas output every 50 file bed.h5 fields u p eps faces particles no")
    r = Run(executable, text, 1, files={"particles.data": data})
    t = r.thermo()
    into, out, displaced, back, speed, _, _ = frames(r.file("bed.h5"))
    half = len(speed) // 2
    c.true("pulsating inlet: no particle lost", np.all(t["Atoms"] == N))
    c.true(f"pulsating inlet: gas comes in by the outlet in {np.mean(out < 0):.0%} of the frames", 0.3 < np.mean(out < 0) < 0.7)
    c.below("pulsating inlet: (out - in - displaced)/largest inflow", np.abs(out - into - displaced).max() / into.max(), 1e-5)
    c.below("pulsating inlet: largest speed of the second half / first half", speed[half:].max() / speed[:half].max(), 1.2)
    c.below("pulsating inlet: largest speed / (largest superficial / eps_min)",
            speed.max() / ((0.4 + swing) / column(t, "f_gas[9]").min()), 2)


def bare(box, gas, steps, dt):
    """No particle. LIGGGHTS itself wants a type in use (a wall's), and can't sort nothing."""
    return head(box, dt, boundary="f f f").replace("newton off", "newton off\natom_modify sort 0 0") + walls(zplane=(0,)) + f"""
fix integrate all nve/sphere
{gas}
thermo 100
thermo_style custom step atoms f_gas[3] f_gas[5]
run {steps}
"""


def entraining(c, executable):
    jet = 5.0
    sides = "fix_modify gas boundary xlo slip boundary xhi slip boundary ylo slip boundary yhi slip\n"
    gas = f"""fix gas all twogrid fine 20 1 30 density 1.2 viscosity 1.8e-5 every 10
{sides}fix_modify gas boundary zlo noslip boundary zlo patch jet rect 0.003 0.006 0 0.002 inlet 0 0 {jet} boundary zhi pressure 0
fix_modify gas output every 100 file bed.h5 fields u p eps faces particles no"""
    r = Run(executable, bare("0 0.02 0 0.002 0 0.03", gas, 6000, 2e-5), 1, ["-fluid_pressure_rtol", "1e-7"])
    into, out, _, back, speed, _, _ = frames(r.file("bed.h5"))
    c.true(f"jet: gas comes in through part of the outlet ({back[20:].mean():.0%} of it, mean)", back[20:].mean() > 0.1)
    c.below("jet: (out - in)/in", np.abs(out / into - 1).max(), 1e-5)
    c.below("jet: largest speed / the jet's", speed.max() / jet, 1.5)
    half = len(speed) // 2
    c.below("jet: largest speed of the second half / first half", speed[half:].max() / speed[:half].max(), 1.1)


def closed(c, executable):
    extra = """fix_modify gas deposit trilinear
fix_modify gas output every 50 file bed.h5 fields u p eps faces particles no"""
    data, text = small_bed(3000, every=10, extra=extra, prelude=1, floor="slip", top="slip")
    r = Run(executable, text, 1, files={"particles.data": data})
    t = r.thermo()
    _, _, displaced, _, speed, mean, spread = frames(r.file("bed.h5"))
    weight = N * V_P * (RHO_P - RHO) * G / (W * DEPTH)
    c.true("closed box: no particle lost", np.all(t["Atoms"] == N))
    c.below("closed box: mean of p / (weight/area)", np.abs(mean).max() / weight, 1e-9)
    c.below("closed box: range of p / (weight/area)", spread.max() / weight, 1)
    c.below("closed box: gas displaced in all (m3/s), over eps-changes that balance", np.abs(displaced).max() / (W * DEPTH), 1e-12)
    c.below("closed box: continuity error", column(t, "f_gas[5]").max(), 1e-4)

    sides = "fix_modify gas boundary xlo slip boundary xhi slip boundary ylo slip boundary yhi slip\n"
    for name, zlo, zhi, later, runs in (("inlets that balance", 0.5, 0.5, "", True), ("more in than out", 0.5, 0.4, "", False),
                                        ("more out than in", 0.5, 0.6, "", False),
                                        ("balance lost between runs", 0.5, 0.5, "fix_modify gas boundary zlo inlet 0 0 0.7\nrun 100\n", False)):
        gas = f"""fix gas all twogrid fine 4 4 8 density 1.2 viscosity 1.8e-5 every 10
{sides}fix_modify gas boundary zlo inlet 0 0 {zlo} boundary zhi inlet 0 0 {zhi}"""
        begin = time.time()
        r = Run(executable, bare("0 0.01 0 0.01 0 0.02", gas, 100, 2e-5) + later, 1, expect_success=runs)
        sentence = [line for line in r.output.split("\n") if "outlet" in line or "lets it out" in line]
        c.true(f"closed, {name}: " + ("runs" if runs else f"refused in {time.time() - begin:.1f} s: {(sentence or [r.output[-300:]])[-1][:200]}"),
               (r.code == 0) == runs and (runs or len(sentence) > 0))


def main():
    executable, _ = arguments()
    c = Checks("outlets under backflow, closed boxes")
    pulsating(c, executable)
    entraining(c, executable)
    closed(c, executable)
    c.end()


if __name__ == "__main__":
    main()
