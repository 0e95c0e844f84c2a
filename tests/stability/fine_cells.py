#!/usr/bin/python3
"""Fine cells of d, d/2 and d/4 under one and the same bed, packed, then bubbling, then collapsing; particle cells of 3 d,
one fine cell deep; formulations A and B.

Bounded, at every step of every stage: gas speed, particle speed, void fraction, Courant number. Conserved: solid volume to
1e-13, gas out = in + displaced to ten times the tolerance of
the pressure, action and reaction to 1e-12, momentum of the
mixture over each stage to 0.1 % of its weight times time, from outside the coupling.

Without this test a map that is sound at one ratio only would pass, such as one that forgets how many fine cells share a
particle cell, or that leaves a jump of eps at each particle cell's border to drive the gas: cells smaller than a particle
are what the two grids are for, and where a single grid fails.

--long: 20 times as long, a wider bed, deposition by centroid, too.
"""
import h5py
import numpy as np

from hard import Checks, MixtureBalance, Run, arguments, column, data_file, gas_balance, head_with_particles, long_form, settled

D, RHO, RHO_P, MU, G = 1e-3, 1.2, 2500.0, 1.8e-5, 9.81
DT, EVERY, FRAME = 1e-5, 5, 25
SLOW, FAST = 0.35, 1.3        # superficial: packed; bubbling, 2.2 times minimum fluidisation
DEPTH, H = 3e-3, 42e-3
CONTACT = dict(kn=300, kt=85, gamman=0.01, gammat=0.005, mu=0.1)
PLANES = {"left": "xplane 0.0", "right": "xplane {W}", "front": "yplane 0.0", "back": f"yplane {DEPTH}", "bottom": "zplane 0.0", "top": f"zplane {H}"}


def packing(executable, width, layers):
    rng = np.random.default_rng(7)
    a = (np.arange(int(width / (1.1 * D))) + 0.55) * 1.1 * D
    b = (np.arange(int(DEPTH / (1.05 * D) + 0.3)) + 0.5) * (DEPTH / int(DEPTH / (1.05 * D) + 0.3))
    x = [(p + 5e-5 * rng.uniform(-1, 1), q, z) for z in (np.arange(layers) + 0.55) * 1.05 * D for q in b for p in a]
    return settled(executable, f"0 {width} 0 {DEPTH} 0 {H}", x, D, RHO_P, 8000, DT, **CONTACT)


def script(width, x, refine, formulation, deposit, stages):
    nx, nz = round(width / D) * refine, round(H / D) * refine
    # Full walls with their force: what they take and give is part of the balance.
    wall = "".join(f"fix {n} all wall/gran model hooke/stiffness tangential history primitive type 1 {at.format(W=width)} "
                   "store_force yes absolute_damping on\n" for n, at in PLANES.items())
    return data_file(f"0 {width} 0 {DEPTH} 0 {H}", x, D, RHO_P), head_with_particles(DT, boundary="f f f", **CONTACT) + wall + f"""
fix grav all gravity {G} vector 0 0 -1
fix integrate all nve/sphere
variable U equal {SLOW}
fix gas all twogrid fine {nx} 1 {nz} ratio {3 * refine} 1 {3 * refine} density {RHO} viscosity {MU} every {EVERY}
fix_modify gas formulation {formulation} deposit {deposit}
fix_modify gas boundary zlo inlet 0 0 v_U boundary zhi pressure 0
fix_modify gas boundary xlo slip boundary xhi slip boundary ylo slip boundary yhi slip
fix_modify gas initial u 0 0 {SLOW}
fix_modify gas output every {FRAME} file bed.h5 fields u p eps faces particles no
variable mvz atom mass*vz
compute mvz all reduce sum v_mvz
variable wz atom {'+'.join(f'f_force_{n}[3]' for n in PLANES)}
compute wz all reduce sum v_wz
variable speed atom sqrt(vx*vx+vy*vy+vz*vz)
compute fastest all reduce max v_speed
thermo 1
thermo_style custom step atoms c_mvz c_wz c_fastest f_gas[3] f_gas[4] f_gas[5] f_gas[6] f_gas[7] f_gas[9]
thermo_modify format float %.14g lost error
run {stages[0]}
variable U equal {FAST}
run {stages[1]}
variable U equal 0.0
run {stages[2]}
"""


def main():
    import h5py
    executable, _ = arguments()
    c = Checks("fine cells of d, d/2, d/4 under a packed, a bubbling and a collapsing bed")
    width, layers, stages = (24e-3, 16, [10000, 40000, 10000]) if long_form() else (12e-3, 14, [800, 2000, 800])
    runs = [(f, r, d) for f in "BA" for r in (1, 2, 4) for d in ("trilinear", "centroid")]
    if not long_form():
        runs = [("B", 1, "trilinear"), ("B", 2, "trilinear"), ("A", 2, "trilinear"), ("B", 4, "trilinear")]
    x = packing(executable, width, layers)
    edges = np.cumsum([0] + stages)
    for formulation, refine, deposit in runs:
        data, text = script(width, x, refine, formulation, deposit, stages)
        r = Run(executable, text, 1, files={"particles.data": data}, timeout=3000, expect_success=False)
        what = f"{formulation}, cells of d/{refine}, {deposit}"
        if r.code:
            c.true(f"{what}: runs to the end: {r.output[-400:]}", False)
            continue
        t = r.thermo()
        _, first = np.unique(t["Step"], return_index=True)  # a stage's last step is the next one's first
        t = {n: v[first] for n, v in t.items()}
        step = t["Step"].astype(int)
        col = lambda name: column(t, name)
        weight = t["Atoms"][0] * np.pi / 6 * D**3 * (RHO_P - RHO) * G
        U = np.select([step <= edges[1], step <= edges[2]], [SLOW, FAST], 0.0)
        balance = MixtureBalance(r.file("bed.h5"), RHO, EVERY, DT, weight, step, col("c_mvz"), col("c_wz"), col("f_gas[4]"), U)
        errors = []
        for stage, name in enumerate(("packed", "bubbling", "collapsing")):
            # The step in which the inflow jumps takes an impulse of its own: windows begin two frames later.
            w = balance.window(edges[stage] + 2 * FRAME, edges[stage + 1], band=stages[stage] // 4)
            errors.append(w["error"])
            c.note(f"{what}, {name}: dp {w['dp']:.4f}, walls {w['wall']:+.4f}, momentum {w['change']:+.4f} of the weight, "
                   f"open by {w['error']:.1e}")
        c.below(f"{what}: momentum balance of the mixture / (weight x time)", np.max(errors), 1e-3)
        with h5py.File(r.file("bed.h5")) as f:
            gas = max(np.abs(frame["faces/u" + a][()]).max() for frame in f["fluid"].values() for a in "xz")
        c.below(f"{what}: gas speed / (inflow / smallest void fraction)", gas / (FAST / col("f_gas[9]").min()), 3)
        c.below(f"{what}: particle speed / inflow", col("c_fastest").max() / FAST, 1)
        c.below(f"{what}: Courant number", col("f_gas[3]").max(), 0.4)
        c.below(f"{what}: 1 - smallest void fraction", 1 - col("f_gas[9]").min(), 0.7 + 1e-12)
        c.below(f"{what}: gas out - in - displaced / in", gas_balance(r.file("bed.h5"), FAST * width * DEPTH), 1e-5)
        c.below(f"{what}: solid volume error", col("f_gas[6]").max(), 1e-13)
        c.below(f"{what}: action and reaction", col("f_gas[7]").max(), 1e-12)
        c.true(f"{what}: no particle lost", t["Atoms"][-1] == len(x))
    c.end()


if __name__ == "__main__":
    main()
