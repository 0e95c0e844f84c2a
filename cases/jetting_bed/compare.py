#!/usr/bin/python3
"""Verdict on a run of in.jetting_bed, and its pictures.

    compare.py FOLDER      FOLDER: what the run wrote (bed.h5, now.txt, mean.txt)

Prints PASS or FAIL for every check that needs no measured curve, draws FOLDER/*.png, ends with 0 if all passed.
"""
import os
import sys

import h5py
import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import leg_tables  # noqa: E402
import plot_fields  # noqa: E402

# As in.jetting_bed has it.
D_P, RHO_P, G, DEM_STEP = 0.75e-3, 2500.0, 9.81, 1.25e-5


class Verdict:
    failed = 0

    def __call__(self, good, text):
        self.failed += not good
        print(f"{'PASS' if good else 'FAIL'}  {text}", flush=True)

    def note(self, text):
        print(f"      {text}", flush=True)


class Bed:
    """The output file, with what several checks need."""

    def __init__(self, folder):
        self.file = h5py.File(os.path.join(folder, "bed.h5"), "r")
        self.now = leg_tables.table(os.path.join(folder, "now.txt"))
        self.mean = leg_tables.table(os.path.join(folder, "mean.txt"))
        self.x, self.y, self.z = plot_fields.nodes(self.file)
        self.rho_f = float(self.file["record"].attrs["density"])
        self.section = np.ptp(self.x) * np.ptp(self.y)
        last = plot_fields.frames(self.file)[-1]
        inlet = self.file["fluid"][last]["faces/flux_z"][0].mean(axis=0)  # one cell deep: over x
        self.U, self.U_background = inlet.max(), inlet.min()
        jet = (inlet > 0.5 * (self.U + self.U_background)).astype(int)
        edges = np.diff(np.concatenate([[0], jet, [0]]))
        self.jets = list(zip(np.nonzero(edges == 1)[0], np.nonzero(edges == -1)[0]))  # [first, last) of each
        self.jet_width = self.x[self.jets[0][1]] - self.x[self.jets[0][0]]
        self.inflow_momentum = self.rho_f * np.sum(inlet**2 * np.diff(self.x)) * np.ptp(self.y)
        self.weight = self.now[0, 2] * RHO_P * np.pi / 6 * D_P**3 * (1 - self.rho_f / RHO_P) * G


def conservation(bed, verdict):
    now, frames = bed.now, bed.file["fluid"]
    verdict(np.ptp(now[:, 2]) == 0, f"particles: {now[0, 2]:.0f} at the beginning, {now[-1, 2]:.0f} at the end")
    verdict(now[:, 6].max() <= 1e-13, f"solid volume deposited: relative error at most {now[:, 6].max():.1e} (wanted 1e-13)")
    verdict(now[:, 7].max() <= 1e-12, f"action and reaction: relative error at most {now[:, 7].max():.1e} (wanted 1e-12)")
    area = np.outer(np.diff(bed.y), np.diff(bed.x))
    volume = np.diff(bed.z)[:, None, None] * area
    worst_mass = worst_jet = 0
    for name in plot_fields.frames(bed.file):
        if frames[name]["time"][()] < bed.file["average"].attrs["from"]:
            continue
        flux, rate = frames[name]["faces/flux_z"], frames[name]["faces/deps_dt"][:]
        inflow, outflow, displaced = np.sum(flux[0] * area), np.sum(flux[-1] * area), -np.sum(rate * volume)
        worst_mass = max(worst_mass, abs(outflow - inflow - displaced) / inflow)
        for first, last in bed.jets:
            got = np.sum(flux[0][:, first:last] * area[:, first:last])
            worst_jet = max(worst_jet, abs(got / (bed.U * bed.jet_width * np.ptp(bed.y)) - 1))
    verdict(worst_mass <= 1e-6, f"gas out = gas in + displaced: relative error at most {worst_mass:.1e} (wanted 1e-6)")
    verdict(worst_jet <= 1e-10, f"flux through a jet's patch: relative error at most {worst_jet:.1e} (wanted 1e-10)")
    verdict.note(f"largest continuity error of a cell {now[1:, 5].max():.1e} U/h; smallest void fraction {now[1:, 9].min():.3f}; "
                 f"moved by its bound at most {now[:, 8].max():.1e} m3 of {now[0, 2] * np.pi / 6 * D_P**3:.1e} m3")


def momentum(bed, verdict):
    """Vertical momentum of particles and gas over the time of the means:
    d(P_s + P_f) = integral of [ dp A + rho sum U^2 A (in) - rho sum <f u> A (out) + wall forces - buoyant weight ] dt.
    The volume flux of both phases together is the same in every section, hence P_f = const - rho_f/rho_p P_s."""
    average = bed.file["average"]
    step = bed.mean[:, 0]
    window = (step[1] - step[0]) * DEM_STEP
    inside = (step - 0.5 * (step[1] - step[0])) * DEM_STEP > average.attrs["from"]
    dp, wall = bed.mean[inside, 1], bed.mean[inside, 2]
    P = dict(zip(bed.now[:, 0], bed.now[:, 1]))
    begin, end = step[inside][0] - (step[1] - step[0]), step[inside][-1]
    T = inside.sum() * window
    change = (P[end] - P[begin]) * (1 - bed.rho_f / RHO_P)
    fine = average["fine"]
    out = fine["flux"][-1, ..., 2] * fine["u"][-1, ..., 2] + fine["u_variance"][-1, ..., 2]
    outflow_momentum = bed.rho_f * np.sum(out * np.outer(np.diff(bed.y), np.diff(bed.x)))
    force = dp.mean() * bed.section + bed.inflow_momentum - outflow_momentum + wall.mean() - bed.weight
    error = (change - force * T) / (bed.weight * T)
    verdict.note(f"per buoyant weight ({bed.weight:.4e} N, {bed.weight / bed.section:.1f} Pa), over {T:.2f} s: "
                 f"pressure {dp.mean() * bed.section / bed.weight:.4f}, momentum in {bed.inflow_momentum / bed.weight:.4f}, "
                 f"out {outflow_momentum / bed.weight:.4f}, walls {wall.mean() / bed.weight:+.4f}, "
                 f"change {change / (bed.weight * T):+.4f}")
    verdict(abs(error) <= 1e-3, f"momentum of gas and particles: the balance is open by {100 * error:+.3f} % of weight times "
            "time (wanted 0.1 %)")
    groups = [g.mean() for g in np.array_split(dp, min(8, len(dp)))]
    verdict.note(f"mean pressure drop {dp.mean():.1f} +- {np.std(groups, ddof=1) / np.sqrt(len(groups)):.1f} Pa "
                 f"({len(groups)} batches), standard deviation {dp.std():.1f} Pa")


def penetration(bed, verdict):
    """Height above the nozzle up to which the mean void fraction on a jet's axis stays above 0.7, midway between the
    packed bed and the empty jet."""
    x, _, z = plot_fields.nodes(bed.file, "particle_grid")
    eps = bed.file["average/particle_grid/eps"][:].mean(axis=1)
    height = plot_fields.centres(z)
    lengths = []
    for first, last in bed.jets:
        column = np.searchsorted(x, 0.5 * (bed.x[first] + bed.x[last])) - 1
        axis = eps[:, column]
        k = int(np.argmax(axis < 0.7))  # the first that is not void
        lengths.append(0.0 if k == 0 else np.interp(0.7, [axis[k], axis[k - 1]], [height[k], height[k - 1]]))
    L = np.mean(lengths)
    d0 = np.sqrt(4 / np.pi * bed.jet_width * np.ptp(bed.y))  # circle of the slot's area
    froude = bed.U**2 / (G * d0)
    yang_keairns = 6.5 * d0 * np.sqrt(bed.rho_f / (RHO_P - bed.rho_f) * froude)
    merry = 5.2 * d0 * (bed.rho_f * d0 / (RHO_P * D_P))**0.3 * (1.3 * froude**0.2 - 1)
    lo, hi = 0.6 * min(merry, yang_keairns), 1.4 * max(merry, yang_keairns)
    each = ", ".join(f"{1e3 * l:.1f}" for l in lengths)
    verdict(lo <= L <= hi, f"jets reach {each} mm; Yang & Keairns (1978) {1e3 * yang_keairns:.1f} mm, Merry (1975) "
            f"{1e3 * merry:.1f} mm, with 40 % of scatter {1e3 * lo:.1f} to {1e3 * hi:.1f} mm")
    return L


def symmetry(bed, verdict):
    """How far the means are from their mirror image. No verdict: a jet leans to one side for as long as a short run lasts, and a few
    batches of a correlated series carry no bound with a known rate of false alarms. That the program itself prefers no side is
    tested by tests/system/mirror.py, particle by particle."""
    weight, batch = plot_fields.batches(bed.file)
    x, _, z = plot_fields.nodes(bed.file, "particle_grid")
    from_middle = plot_fields.centres(x) - 0.5 * (x[0] + x[-1])
    solids, flux, eps = (np.average(batch(n), axis=0, weights=weight) for n in ("solids_fraction", "solids_flux", "eps"))
    solids, up, eps = solids.mean(axis=1), flux[..., 2].mean(axis=1), eps.mean(axis=1)  # z, x
    low = z[1:] < 20e-3
    off = 1e3 * (solids * from_middle).sum() / solids.sum()
    lean = (up * np.sign(from_middle))[low].mean()
    bed_cells = eps < 0.95
    mirrored = 0.5 * (eps - eps[:, ::-1])[bed_cells]
    verdict.note(f"left and right: particles' centre {off:+.2f} mm off the middle, mean upward particle flux, right less left, {lean:+.2g} m/s, "
                 f"void fraction less its mirror image {np.sqrt(np.mean(mirrored**2)):.3f} (root mean square); a jet that leans, no verdict")


def draw(bed, folder, L):
    heights = [0.5 * L, L, 1.5 * L]
    top = min(1.15 * bed.now[:, 3].max(), bed.z[-1])
    names = plot_fields.frames(bed.file)
    frames = np.linspace(len(names) // 3, len(names) - 1, 3).astype(int)
    pictures = {"mean_void_fraction": plot_fields.mean_void_fraction(bed.file, top=top),
                "snapshots": plot_fields.snapshots(bed.file, frames, top=top),
                "profiles": plot_fields.profiles(bed.file, heights), "pressure": plot_fields.pressure_profile(bed.file)}
    print("pictures:")
    for name, figure in pictures.items():
        path = os.path.join(folder, name + ".png")
        figure.savefig(path, dpi=110, bbox_inches="tight")
        print("  " + os.path.relpath(path))


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    bed, verdict = Bed(sys.argv[1]), Verdict()
    verdict.note(f"{len(bed.jets)} jet(s) of {1e3 * bed.jet_width:.1f} mm at {bed.U:.1f} m/s, background "
                 f"{bed.U_background:.2f} m/s, {bed.now[-1, 0] * DEM_STEP:.2f} s, means from "
                 f"{bed.file['average'].attrs['from']:.2f} s")
    if "weight" not in bed.file["average"].attrs or bed.now[-1, 0] * DEM_STEP <= bed.file["average"].attrs["from"]:
        sys.exit("the run ended before its means began: -var tend must be larger than -var tavg")
    conservation(bed, verdict)
    momentum(bed, verdict)
    L = penetration(bed, verdict)
    symmetry(bed, verdict)
    draw(bed, sys.argv[1], L)
    sys.exit(1 if verdict.failed else 0)


if __name__ == "__main__":
    main()
