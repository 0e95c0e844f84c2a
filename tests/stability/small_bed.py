"""A small bubbling bed, one fine cell deep: 300 particles, 144 fine cells, particle cells of 3.3 diameters."""
import numpy as np

from hard import data_file, head_with_particles, walls

W, DEPTH, H, D, RHO, RHO_P, MU, U, G = 0.012, 0.0048, 0.048, 1.2e-3, 1.2, 2500.0, 1.8e-5, 1.5, 9.81
DT, N = 2e-5, 300
V_P = np.pi / 6 * D**3


def small_bed(steps, every=10, fine=(6, 1, 24), ratio=(2, 1, 2), thermo=None, extra="", before="", prelude=5000,
              floor=f"inlet 0 0 {U}", top="pressure 0"):
    """Data file and script: 0.1 s to come to rest without gas, then `steps` with it."""
    rng = np.random.default_rng(4)
    x = [(a + 3e-5 * rng.uniform(), b, z) for z in np.arange(0.6, 20) * 1.06 * D for b in (np.arange(4) + 0.5) * D
         for a in (np.arange(9) + 0.55) * 1.08 * D][:N]
    data = data_file(f"0 {W} 0 {DEPTH} 0 {H}", x, D, RHO_P)
    return data, head_with_particles(DT, boundary="f f f", kn=100, kt=30, gamman=0.005, gammat=0.002, mu=0.2, skin=6e-4) + walls(
        xplane=(0, W), yplane=(0, DEPTH), zplane=(0, H)) + f"""
fix grav all gravity {G} vector 0 0 -1
fix integrate all nve/sphere
thermo {prelude}
run {prelude}
{before}
fix gas all twogrid fine {fine[0]} {fine[1]} {fine[2]} ratio {ratio[0]} {ratio[1]} {ratio[2]} density {RHO} viscosity {MU} every {every}
fix_modify gas boundary zlo {floor} boundary zhi {top}
fix_modify gas boundary xlo slip boundary xhi slip boundary ylo slip boundary yhi slip
{extra}
variable z atom z
compute z all reduce ave v_z
compute top all reduce max v_z
thermo {thermo or every}
thermo_style custom step atoms c_z c_top ke f_gas[3] f_gas[4] f_gas[5] f_gas[6] f_gas[7] f_gas[9]
thermo_modify format float %.12g lost error norm no flush yes
run {steps}
"""
