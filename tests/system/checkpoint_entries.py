#!/usr/bin/python3
"""No entry of a checkpoint is idle: a run that goes on with one of them left out, so that it begins with what a new process has, becomes
another run. For each entry there is a scene that shows it.

Without this test something that is no state could be carried along, or, worse, an entry be written and not read, which no comparison of
whole runs would tell. --long: all entries in all scenes, as a table; else each in the scene named for it, and a few of those that unit tests walk
through one by one: test_fluid_state, test_coupling_state, test_averages, test_output, test_schedule, test_accuracy, test_coupling_watch.
Usage: checkpoint_entries.py EXECUTABLE [--long]
"""
import os
import sys
from concurrent.futures import ThreadPoolExecutor

import h5py

import checkpoint_scenes
from checkpoint_scenes import AIR, BED, GRAINS, MESH, RATE, PACK, Scene, differences
from harness import Checks, arguments

LIQUID = "density 1000 viscosity 1e-3 every 10"
STEPS = (65, 60)
# Grains with velocities by normal numbers, of which generators make two at a time.
NORMAL = GRAINS + (
    "fix pour all insert/rate/region seed 32452867 distributiontemplate both nparticles 500 particlerate 35000 insert_every 60 overlapcheck yes "
    "vel gaussian 0 0 -0.5 0.05 0.05 0.05 region top ntry_mc 10000\n")
SCENES = {
    "bed": (1, Scene(AIR, steps=STEPS)),
    "A": (1, Scene(AIR, BED + " formulation A method paper", steps=STEPS)),
    "held": (1, Scene(LIQUID, "hold on method jets boundary zlo inlet 0 0 0.02 boundary zhi pressure 0", steps=STEPS)),
    "flow rate": (1, Scene("density 1.2 viscosity 1.8e-3 every 10", "flow_rate z 0.3 implicit on convection central method kernel 0.004", boundary="p p p", steps=STEPS)),
    "many steps": (1, Scene("density 1.2 viscosity 1.8e-5 every 30", "initial vortex 2 boundary zlo inlet 0 0 3 boundary zhi pressure 0", steps=STEPS, output=30)),
    "changed between": (1, Scene(AIR, "hold on " + BED, between="set group all diameter 0.00105\n", steps=STEPS)),
    "warned": (1, Scene("density 1.2 viscosity 1.8e-5 every 30", "eps bound move 0.75 " + BED, steps=(65, 180), output=30, speed=-5.0)),
    "still": (1, Scene(AIR, BED, other="fix hold all freeze\n", steps=STEPS)),
    "accuracy": (1, Scene("density 1.2 viscosity 1.8e-5 every auto", BED + " accuracy 0.003", steps=(405, 400))),
    "rate": (1, Scene(AIR, other=MESH + RATE, steps=(65, 120))),
    "packs": (2, Scene(AIR, other=PACK, steps=(65, 120))),
    "normal": (2, Scene(AIR, other=NORMAL, steps=(65, 120))),
    "borders": (4, Scene(AIR, box="0 0.0026 0 0.0026 0 0.128", fine="4 4 64", layers=24, cut={4: "1 1 4"}, steps=(5, 40))),
    "balanced": (2, Scene(AIR, box="0 0.0026 0 0.0026 0 0.128", fine="4 4 64", layers=24, cut={2: "1 1 2"}, steps=STEPS, speed=5.0)),
    "bricks": (4, Scene(AIR, box="0 0.0026 0 0.0026 0 0.032", fine="4 4 32", layers=24, cut={4: "1 1 4"}, steps=STEPS)),
    "odd": (1, Scene(AIR, other=NORMAL.replace("particlerate 35000", "particlerate 41000"), steps=(45, 80))),
    "skin": (1, Scene(AIR, skin=0.1e-3, options=("-skin", "best"), steps=STEPS)),
}


SHORT = {
    "bed": ["fluid/p", "fluid/eps_1", "report/cfl", "report/pressure_drop", "report/eps_min", "report/pressure_iterations", "coupling/known_volume", "schedule/next_frame"],
    "changed between": ["fluid/eps_f_z", "coupling/holding", "coupling/change_resting"],
    "odd": ["random/fix_pour_kept", "random/fix_pour_second"],
    "normal": ["random/fix_pour_random", "random/fix_both_random", "random/region_top_random"],
    "skin": ["record/skin"],
    "balanced": ["balance/next"],
    "borders": ["ranks/borders", "balance/moving"],
    "bricks": ["ranks/layout"],
}


def entries(path):
    out = []
    with h5py.File(path) as f:
        f.visititems(lambda n, d: out.append(n) if isinstance(d, h5py.Dataset) else None)
    return [n for n in out if n not in ("record/step", "record/particles") and not n.startswith("ranks/")] + ["ranks/layout", "ranks/borders", "ranks/tags"]


def sweep(executable, name, only=None):
    ranks, scene = SCENES[name]
    a = scene.first(executable, ranks)
    whole = scene.second(executable, ranks, a)
    if differ := differences(scene, a, whole):
        print(f"FAIL {name}: differs with all entries: {differ}", flush=True)
        return {}
    seen = {}

    def one(entry):
        b = scene.second(executable, ranks, a, expect_success=False, left_out=entry)
        return entry, ["ends"] if b.code != 0 else differences(scene, a, b)

    with ThreadPoolExecutor(2) as pool:
        for entry, differ in pool.map(one, [e for e in entries(a.file("half.h5")) if only is None or e in only]):
            seen[entry] = differ
    return seen


def main():
    executable, _ = arguments()
    only = [a[2:] for a in sys.argv if a.startswith("--") and a != "--long"]
    long = "--long" in sys.argv or only
    c = Checks("entries of a checkpoint, each left out in turn")
    shown, all_of = {}, set()
    for name in only or (SCENES if long else SHORT):
        seen = sweep(executable, name, None if long else SHORT[name])
        c.true(f"{name}: every bit with all of its {len(seen)} entries", bool(seen))
        all_of |= set(seen)
        for entry, differ in seen.items():
            if differ:
                shown.setdefault(entry, []).append(name)
    for entry in sorted(all_of):
        c.true(f"without {entry} another run: {', '.join(shown.get(entry, [])) or 'nowhere'}", entry in shown)
    c.end()


if __name__ == "__main__":
    main()
