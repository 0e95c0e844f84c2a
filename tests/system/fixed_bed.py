#!/usr/bin/python3
"""Fixed bed of uniform void fraction (a lattice that fills every particle cell alike) with through-flow: force on the
particles and pressure drop against the drag law's own formula, formulations A and B, every drag law; gravity off.

Without this test a law could be right as a function (unit tests) and still reach the fluid with a wrong power of eps,
interstitial for superficial velocity, or doubled in formulation A.

Reference: F of the published formulas, evaluated here, independently of the engine, at the bed's own eps and Re; in a
bed at rest the fluid's force on a particle, drag and pressure gradient together, is dp/L over the number of particles
a volume, dp/L = beta U/eps^2 with beta = 18 mu eps eps_s F/d^2, in both formulations. The force is taken over the inner
half of the bed, where the flow is developed. The whole pressure drop is compared in formulation B, in which the gas
gains rho U^2 (1/eps - 1) beside it (in A that gain depends on where in the entrance layer it takes place).
"""
import math

from harness import Checks, Run, arguments, head

D, RHO, MU = 1e-3, 1.2, 1.8e-5
SPACING = 1.2e-3            # of the simple cubic lattice; a particle cell holds 3 x 3 x 3
CELLS = 4                   # particle cells a side
EPS = 1 - math.pi / 6 * (D / SPACING)**3


def lone(re):
    return 1 + 0.15 * re**0.687 if re < 1000 else 0.44 * re / 24


def reference(law, eps, re):
    """F: drag without the mean pressure gradient over 3 pi mu d eps |u - v|."""
    s = 1 - eps
    ergun = (150 * s + 1.75 * re) / (18 * eps**2)
    wenyu = lone(re) * eps**-3.65
    psi = math.atan(150 * 1.75 * (0.2 - s)) / math.pi + 0.5
    if law == "ergun":
        return ergun
    if law == "wenyu":
        return wenyu
    if law in ("ergun/wenyu/jump", "gidaspow"):
        return ergun if eps < 0.8 else wenyu
    if law == "ergun/wenyu":
        return (1 - psi) * ergun + psi * wenyu
    if law == "difelice":  # Di Felice (1994): Dalla Valle's drag times eps^(1 - chi), chi = 3.7 - 0.65 exp(-(1.5 - lg Re)^2/2)
        chi = 3.7 - 0.65 * math.exp(-0.5 * (1.5 - math.log10(re))**2)
        return (0.63 * math.sqrt(re) + 4.8)**2 / 24 * eps**(-chi)
    if law == "kochhill":  # Koch & Hill (2001), Re by radius: Re_r = Re/2
        f0 = (1 + 3 * math.sqrt(s / 2) + 135 / 64 * s * math.log(s) + 16.14 * s) / (1 + 0.681 * s - 8.48 * s**2 + 8.16 * s**3) if s < 0.4 else 10 * s / eps**3
        f3 = 0.0673 + 0.212 * s + 0.0232 / eps**5
        # beta = 18 mu eps^2 eps_s/d^2 (F0 + F3 Re/2)
        return eps * (f0 + f3 * re / 2)
    if law == "beetstra":  # Beetstra et al. (2007), force over 3 pi mu d U
        f = 10 * s / eps**2 + eps**2 * (1 + 1.5 * math.sqrt(s))
        f += 0.413 * re / (24 * eps**2) * (1 / eps + 3 * eps * s + 8.4 * re**-0.343) / (1 + 10**(3 * s) * re**(-0.5 - 2 * s))
        return f
    if law == "tenneti":  # Tenneti et al. (2011): total force over 3 pi mu d U_superficial; drag is eps times it
        iso = 1 + 0.15 * re**0.687
        return eps * (iso / eps**3 + 5.81 * s / eps**3 + 0.48 * s**(1 / 3) / eps**4 + s**3 * re * (0.95 + 0.61 * s**3 / eps**2))
    if law == "schiller/naumann":
        return lone(re / eps) / eps
    if law == "stokes":
        return 1 / eps
    raise KeyError(law)


def script(law, formulation, U, read, deposit):
    L = CELLS * 3 * SPACING
    n = CELLS * 3
    fine = CELLS * 2
    return head(f"0 {L!r} 0 {L!r} 0 {L!r}", 1e-5, boundary="p p f", skin=1e-3) + f"""
lattice sc {SPACING!r} origin 0.5 0.5 0.5
create_atoms 1 region box
set group all diameter {D} density 2500
fix gas all twogrid fine {fine} {fine} {fine} ratio 2 2 2 density {RHO} viscosity {MU} every 10
fix_modify gas drag {law} formulation {formulation} deposit {deposit} read {read}
fix_modify gas boundary zlo inlet 0 0 {U!r} boundary zhi pressure 0
fix_modify gas initial u 0 0 {U / EPS!r}
fix_modify gas dt 1e-4
dump d all custom 1500 dump.txt id z f_gas[3] f_gas[6]
dump_modify d format "%d %.12g %.12g %.12g"
thermo 500
thermo_style custom step f_gas[1] f_gas[4] f_gas[9]
thermo_modify format float %.12g
run 1500
"""


def main():
    executable, _ = arguments()
    c = Checks("fixed bed: pressure drop against the law's own formula")
    L = CELLS * 3 * SPACING
    laws = ["ergun", "wenyu", "ergun/wenyu", "ergun/wenyu/jump", "gidaspow", "difelice", "kochhill", "beetstra", "tenneti",
            "schiller/naumann", "stokes"]
    for law in laws:
        for formulation in "AB":
            for re in (1.0, 50.0):
                U = re * MU / (RHO * D)
                r = Run(executable, script(law, formulation, U, "cell", "centroid"), 1, ["-fluid_pressure_rtol", "1e-9"])
                t = r.thermo()
                found, eps = t["f_gas[4]" if "f_gas[4]" in t else "gas[4]"][-1], t["f_gas[9]" if "f_gas[9]" in t else "gas[9]"][-1]
                beta = 18 * MU * eps * (1 - eps) * reference(law, eps, re) / D**2
                gradient = beta * U / eps**2
                last = r.dump("dump.txt")[-1][1]
                inner = (last["z"] > 0.25 * L) & (last["z"] < 0.75 * L)
                force = (last["f_gas[3]"] + last["f_gas[6]"])[inner].mean()
                wanted = gradient * SPACING**3
                c.below(f"{law} {formulation} Re {re:g}: force on a particle {force:.6g} N, wanted {wanted:.6g}", abs(force / wanted - 1), 0.005)
                if formulation == "B":
                    wanted = gradient * L + RHO * U**2 * (1 / eps - 1)
                    c.below(f"{law} {formulation} Re {re:g}: pressure drop {found:.6g} Pa, wanted {wanted:.6g}", abs(found / wanted - 1), 0.005)
    c.below("void fraction of the lattice", abs(eps - EPS), 1e-9)
    c.end()


if __name__ == "__main__":
    main()
