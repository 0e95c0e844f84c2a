#!/usr/bin/python3
"""A sphere of 3 d and 0.4 times the density, laid on the floor of a bubbling bed of small spheres: it rises to the surface, in
formulations A and B, in times that agree.

    rising_sphere.py EXECUTABLE [--long]     --long: six fillings each, and the times compared

Without this test formulation B would pass that gives a large sphere its drag over eps and no gradient of pressure: such a
sphere stays on the floor of a bed in which it should float, while mass and momentum are conserved to the last digit.

Reference: the large sphere displaces bed of density 0.58 rho_p and weighs 0.4 rho_p of its volume; it floats. How long it takes
has a wide scatter from filling to filling, so that the means are compared by Student's t (99 %).
"""
import numpy as np

from harness import Checks, Run, arguments, data_file, head_with_particles, long_form, walls

D, RHO_P, L, H = 1e-3, 2000.0, 0.015, 0.06
UP = 0.6     # of the mean height of the small ones, doubled: so far up is "at the surface"
PIECE = 2000  # steps of a run: it ends with the first in which the sphere is up
T99 = {2: 9.92, 4: 4.60, 6: 3.71, 8: 3.36, 10: 3.17}


def script(formulation, seed, steps):
    rng = np.random.default_rng(seed)
    n = 13
    q = np.array([(a, b, c) for c in range(13) for b in range(n) for a in range(n)]) * [1.13, 1.13, 1.02] + [0.56, 0.56, 0.55]
    x = (q + rng.uniform(-0.05, 0.05, q.shape)) * D
    large = np.array([[0.5 * L, 0.5 * L, 1.6e-3]])
    x = x[np.linalg.norm(x - large, axis=1) > 2.05e-3]
    d = np.concatenate([[3e-3], np.full(len(x), D)])
    text = data_file(f"0 {L} 0 {L} 0 {H}", np.concatenate([large, x]), d, RHO_P)
    lines = text.split("\n")
    at = next(i for i, line in enumerate(lines) if line.startswith("1 1 "))
    words = lines[at].split()
    words[3] = repr(0.4 * RHO_P)
    lines[at] = " ".join(words)
    return "\n".join(lines), head_with_particles(2e-5, boundary="f f f", kn=400, kt=120, gamman=0.003, gammat=0.001, skin=4e-4) + walls(
        xplane=(0, L), yplane=(0, L), zplane=(0, H)) + f"""
fix weight all gravity 9.81 vector 0 0 -1
fix motion all nve/sphere
fix gas all twogrid fine 10 10 40 ratio 2 2 2 density 1.2 viscosity 1.8e-5 every 10
fix_modify gas drag ergun/wenyu formulation {formulation}
fix_modify gas boundary zlo inlet 0 0 1.0 boundary zhi pressure 0
fix_modify gas boundary xlo slip boundary xhi slip boundary ylo slip boundary yhi slip
group large id 1
variable z equal xcm(large,z)
variable all equal xcm(all,z)
variable surface equal {2 * UP}*xcm(all,z)
thermo 250
thermo_style custom step v_z v_all f_gas[6] f_gas[7]
thermo_modify format float %.8g
label again
variable k loop {steps // PIECE}
run {PIECE}
if "${{z}} > ${{surface}}" then "jump SELF up"
next k
jump SELF again
label up
"""


def rise(executable, formulation, seed, steps, c):
    data, text = script(formulation, seed, steps)
    r = Run(executable, text, 1, files={"particles.data": data}, timeout=300)
    t = r.thermo()
    z, bed = t["z"] if "z" in t else t["v_z"], t["all"] if "all" in t else t["v_all"]
    up = np.nonzero(z > UP * 2 * bed)[0]
    c.below(f"{formulation}, filling {seed}: action and reaction", max(t["f_gas[7]"] if "f_gas[7]" in t else t["gas[7]"]), 1e-11)
    c.note(f"{formulation}, filling {seed}: highest {z.max() * 1e3:.1f} mm, bed to {2 * bed[-1] * 1e3:.1f} mm, up after "
           f"{t['Step'][up[0]] * 2e-5 if len(up) else float('inf'):.3f} s")
    return t["Step"][up[0]] * 2e-5 if len(up) else np.inf


def main():
    executable, _ = arguments()
    c = Checks("a large light sphere in a bubbling bed")
    seeds, steps = range(1, 7) if long_form() else range(1, 2), 50000  # 1 s: 15 standard deviations above the mean time
    times = {f: np.array([rise(executable, f, s, steps, c) for s in seeds]) for f in "AB"}
    for f in "AB":
        c.true(f"{f}: it rises from the floor to the surface ({', '.join(f'{t:.2f}' for t in times[f])} s)", bool(np.isfinite(times[f]).all()))
    if long_form() and all(np.isfinite(t).all() for t in times.values()):
        a, b = times["A"], times["B"]
        n = len(a)
        error = np.sqrt((a.var(ddof=1) + b.var(ddof=1)) / n)
        c.below(f"times {a.mean():.3f} +- {a.std(ddof=1) / n**0.5:.3f} s in A, {b.mean():.3f} +- {b.std(ddof=1) / n**0.5:.3f} s in B: difference over its "
                "standard error", abs(a.mean() - b.mean()) / error, T99[2 * n - 2])
    c.end()


if __name__ == "__main__":
    main()
