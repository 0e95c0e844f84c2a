#!/usr/bin/python3
"""What the particles alone cost, against LIGGGHTS' own contacts, walls, gravity, motion and neighbour lists in the same go.

    dem.py EXECUTABLE [--folder FOLDER] [--ranks N] [--kernel auto|plain|AVX2|AVX-512] [--rounds N]

9240 spheres of 1.2 mm, contacts and box of common_case.py, three states:
  settled    a bed at rest, 2.6 contacts a particle
  flowing    the same bed with gravity tilted by 60 degrees: an avalanche, four moments of it
  bubbling   blown up by gas at 0.9 m/s, four moments between 0.2 and 0.6 s
Each is run for 1000 steps from a restart file without gas; start-up (a run of no steps) is taken off; stock and ours by turns, `rounds`
times. CPU seconds of all ranks. FOLDER keeps the states.
"""
import argparse
import os
import tempfile

import numpy as np

import common_case

N, STEPS = common_case.N, 1000
TILT = "vector 0.866 0 -0.5"
MOMENTS = 4


class Dem(common_case.Bench):
    def tilted(self, text):
        return text.replace("vector 0 0 -1", TILT)

    def avalanche(self):
        if all(os.path.exists(os.path.join(self.folder, f"flow.{i}")) for i in range(MOMENTS)):
            return
        script = self.tilted(self.head("read_restart settled"))
        for i in range(MOMENTS):
            script += f"run 2500\nwrite_restart flow.{i}\n"
        self.run("flow", script)

    def bubbling(self):
        if not all(os.path.exists(os.path.join(self.folder, f"gas.{i}")) for i in range(MOMENTS)):
            self.coupled("gas", [15, 3, 50, 1, 1, 1], [0.2 + 0.1 * (i + 1) for i in range(MOMENTS)])

    def cost(self, state, tilted, kernel):
        """CPU seconds of STEPS steps."""
        script = self.head(f"read_restart {state}")
        if tilted:
            script = self.tilted(script)
        whole, _ = self.run("alone", script + f"run {STEPS}\n", ["-particles", kernel])
        start, _ = self.run("alone", script + "run 0\n", ["-particles", kernel])
        return whole - start


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("executable")
    parser.add_argument("--folder", help="where the states are kept; those that are there are used again")
    parser.add_argument("--ranks", type=int, default=1)
    parser.add_argument("--kernel", default="auto")
    parser.add_argument("--rounds", type=int, default=3)
    a = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        folder = a.folder or scratch
        os.makedirs(folder, exist_ok=True)
        b = Dem(a.executable, folder, a.ranks)
        b.settle()
        b.avalanche()
        b.bubbling()
        print(f"particles alone, kernel {a.kernel}, {a.ranks} ranks: ns of CPU a particle and step, median of {a.rounds} rounds, and the ratio")
        for name, states in (("settled", ["settled"]), ("flowing", [f"flow.{i}" for i in range(MOMENTS)]),
                             ("bubbling", [f"gas.{i}" for i in range(MOMENTS)])):
            seconds = np.array([[[b.cost(s, name == "flowing", k) for k in ("stock", a.kernel)] for s in states] for _ in range(a.rounds)])
            ns = np.median(seconds.mean(axis=1), axis=0) / (N * STEPS) * 1e9
            ratio = seconds.sum(axis=1)[:, 1] / seconds.sum(axis=1)[:, 0]
            print(f"  {name:9s} LIGGGHTS {ns[0]:6.1f}   twogrid {ns[1]:6.1f}   ratio {np.median(ratio):.3f} (rounds: "
                  + " ".join(f"{r:.3f}" for r in ratio) + ")", flush=True)


if __name__ == "__main__":
    main()
