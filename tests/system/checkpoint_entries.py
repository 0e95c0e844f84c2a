#!/usr/bin/python3
"""No entry of a checkpoint is idle: a run that goes on with one of them left out, so that it begins with what a new process has, becomes
another run. For each entry there is a scene that shows it.

Without this test something that is no state could be carried along, or, worse, an entry be written and not read, which no comparison of
whole runs would tell. --long: all entries in all scenes, as a table; else each in the scene named for it. Of the groups in WALKED unit tests walk
through the lists of state, whatever stands there, and a few are tried here too; of all others every entry that a file holds must be shown here.
Usage: checkpoint_entries.py EXECUTABLE [--long]
"""
import os
import sys
from concurrent.futures import ThreadPoolExecutor

import h5py

import checkpoint_scenes
from checkpoint_scenes import AIR, BED, GRAINS, MESH, PACK, RATE, Scene, differences
from harness import Checks, arguments

LIQUID = "density 1000 viscosity 1e-3 every 10"
STEPS = (65, 60)
# On two ranks, whose border at z = 8 mm all four cross: at a rate, with velocities by normal numbers, of which generators make two at a time, and
# shares of the ranks by random numbers; packs to a volume fraction; one that is done; a stream with a part for each rank.
INSERTION = GRAINS + "".join(f"region {name} cylinder z {at} 0.0015 0.005 0.0145 units box\n" for name, at in (("rain", "0.006 0.002"), ("packs", "0.006 0.006"), ("once", "0.002 0.006"))) + """
fix rain all insert/rate/region seed 86028121 distributiontemplate both nparticles 500 particlerate 100000 insert_every 10 random_distribute uncorrelated overlapcheck yes vel gaussian 0 0 -3 0.1 0.1 0.1 region rain ntry_mc 1000
fix packs all insert/pack seed 86028157 distributiontemplate both maxattempt 50 insert_every 20 overlapcheck yes all_in yes vel uniform 0 0 -3 0.1 0.1 0.1 region packs volumefraction_region 0.2 ntry_mc 1000
fix once all insert/pack seed 67867967 distributiontemplate both maxattempt 50 insert_every once overlapcheck yes all_in yes vel constant 0 0 -3 region once particles_in_region 9
fix face all mesh/surface/planar file face.stl type 1
fix stream all insert/stream seed 67867979 distributiontemplate both nparticles 400 particlerate 30000 overlapcheck yes all_in no vel constant 0 0 -4 insertion_face face extrude_length 0.002 parallel yes
"""
SCENES = {
    "bed": (1, Scene(AIR, steps=STEPS)),
    "A": (1, Scene(AIR, BED + " formulation A method paper", steps=STEPS)),
    "held": (1, Scene(LIQUID, "hold on method jets boundary zlo inlet 0 0 0.02 boundary zhi pressure 0", steps=STEPS)),
    "flow rate": (1, Scene("density 1.2 viscosity 1.8e-3 every 10", "flow_rate z 0.3 implicit on convection central method kernel 0.004", boundary="p p p", steps=STEPS)),
    "many steps": (1, Scene("density 1.2 viscosity 1.8e-5 every 30", "initial vortex 2 boundary zlo inlet 0 0 3 boundary zhi pressure 0", steps=STEPS, output=30)),
    "changed between": (1, Scene(AIR, "hold on " + BED, between="set group all diameter 0.00105\n", skin=0.1e-3, options=("-skin", "best"), steps=STEPS)),
    "warned": (1, Scene("density 1.2 viscosity 1.8e-5 every 30", "eps bound move 0.75 " + BED, steps=(65, 180), output=30, speed=-5.0)),
    "still": (1, Scene(AIR, BED, other="fix hold all freeze\n", steps=STEPS)),
    "accuracy": (1, Scene("density 1.2 viscosity 1.8e-5 every auto", BED + " accuracy 0.003", steps=(405, 400))),
    "rate": (1, Scene(AIR, other=MESH + RATE, steps=(65, 120))),
    "packs": (2, Scene(AIR, other=PACK, steps=(65, 120))),
    "insertion": (2, Scene(AIR, other=INSERTION, layers=3, steps=(65, 120), cut={2: "1 1 2"}, options=("-balance", "off"))),
    "borders": (4, Scene(AIR, box="0 0.0026 0 0.0026 0 0.128", fine="4 4 64", layers=24, cut={4: "1 1 4"}, steps=(5, 40))),
    "balanced": (2, Scene(AIR, box="0 0.0026 0 0.0026 0 0.128", fine="4 4 64", layers=24, cut={2: "1 1 2"}, steps=STEPS, speed=5.0)),
    "bricks": (4, Scene(AIR, box="0 0.0026 0 0.0026 0 0.032", fine="4 4 32", layers=24, cut={4: "1 1 4"}, steps=STEPS)),
}

WALKED = {"fluid": "test_fluid_state", "coupling": "test_coupling_state", "averages": "test_averages", "output": "test_output", "schedule": "test_schedule",
          "accuracy": "test_accuracy", "watch": "test_coupling_watch"}
SHORT = {
    "borders": ["ranks/borders", "balance/moving", "ranks/tags"],
    "insertion": ["insertion/"],
    "bricks": ["ranks/layout"],
    "balanced": ["balance/next"],
    "accuracy": ["report/", "record/every"],
    "changed between": ["record/step", "record/particles", "record/skin", "fluid/p", "fluid/eps_f_z", "coupling/known_volume", "coupling/holding", "coupling/change_resting", "schedule/next_frame"],
}


# Datasets that are left out together, by one name.
TOGETHER = {"layout": ("cuts_x", "cuts_y", "cuts_z", "fluid_brick"), "borders": ("borders_x", "borders_y", "borders_z", "bricks", "equal", "particles"), "tags": ("tags",)}


def entries(path):
    out = []
    with h5py.File(path) as f:
        f.visititems(lambda n, d: out.append(n) if isinstance(d, h5py.Dataset) else None)
    of = {f"ranks/{part}": f"ranks/{name}" for name, parts in TOGETHER.items() for part in parts}
    return list(dict.fromkeys(of.get(n, n) for n in out))


def prepared(executable, name):
    """The first run, and what differs in the second with all entries."""
    ranks, scene = SCENES[name]
    a = scene.first(executable, ranks)
    return a, differences(scene, a, scene.second(executable, ranks, a))


def without(executable, name, a, entry):
    """What differs in the second run without this entry."""
    ranks, scene = SCENES[name]
    b = scene.second(executable, ranks, a, expect_success=False, left_out=entry)
    return ["ends"] if b.code != 0 else differences(scene, a, b)


def main():
    executable, _ = arguments()
    only = [a[2:] for a in sys.argv if a.startswith("--") and a != "--long"]
    long = "--long" in sys.argv or only
    c = Checks("entries of a checkpoint, each left out in turn")
    shown, tried = {}, set()
    with ThreadPoolExecutor(2) as pool:
        scenes = only or (SCENES if long else SHORT)
        first = {name: pool.submit(prepared, executable, name) for name in scenes}
        second = {}
        for name in scenes:
            a, differ = first[name].result()
            there = entries(a.file("half.h5"))
            here = [e for e in there if long or any(e.startswith(o) for o in SHORT[name])]
            c.true(f"{name}: every bit with all of its {len(there)} entries{': but ' + ', '.join(differ) if differ else ''}; {len(here)} are left out in turn", here and not differ)
            shown.update((e, []) for e in there if e not in shown)
            tried |= set(here)
            second.update(((e, name), pool.submit(without, executable, name, a, e)) for e in here)
            if name == "insertion":
                alone = pool.submit(SCENES[name][1].second, executable, 1, a).result()
                c.true("from 2 ranks on 1: what was inserted once is not so again, others go on", "insertion once: inserted" not in alone.output and "insertion rain: inserted" in alone.output)
        for (entry, name), differ in second.items():
            if differ.result():
                shown[entry].append(name)
    walked = sorted(e for e in shown if e not in tried and e.split("/")[0] in WALKED)
    c.note(f"in unit tests alone ({', '.join(sorted({WALKED[e.split('/')[0]] for e in walked}))}): {len(walked)} entries")
    for entry, where in sorted(shown.items()):
        if entry not in walked:
            c.true(f"without {entry} another run: {', '.join(where) or 'nowhere'}", bool(where))
    c.end()


if __name__ == "__main__":
    main()
