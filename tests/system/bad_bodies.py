#!/usr/bin/python3
"""Vessels and bodies that can't be: a sentence each, or they are right.

    bad_bodies.py EXECUTABLE

Wanted of each wrong one: a non-zero exit code, one line that begins with ERROR, in it the words listed. Of those that are right: the same
pressure drop as without the flaw, and a warning where one is due.

What would pass falsely without it: gas through a hole in the steel, or none of it, computed for hours; an inlet that is walled up
and flows none the less; a body that the grid doesn't see, or that nobody finds, without a word; grains behind the fluid's wall, who feel
nothing and tell nobody; a fluid from a checkpoint in a vessel of another shape.
"""
import concurrent.futures

from bodies import C, H, MU, R, RHO, WALL, WIDE, stl
from harness import Checks, Run, arguments, column, head


MESH = "fix cad all mesh/surface file a.stl type 1"
TUBE = f"region tube cylinder z {C[0]} {C[1]} {R} INF INF side out units box"
BALL = "region ball sphere 0.0085 0.0085 0.009 0.003 units box"
POINT = " fluid_at 0.0085 0.0085 0.009"


def script(before, modify, after="", inlet="0 0 0.1", steps=20, grains=(0.0085,)):
    """grains: along the diagonal of the middle plane."""
    grains = "".join(f"create_atoms 1 single {x} {x} 0.009 units box\n" for x in grains)
    return head(f"0 {WIDE} 0 {WIDE} 0 {H}", 1e-4, boundary="f f f") + grains + f"""set group all diameter 1e-5 density 2500
{before}
fix gas all twogrid fine 18 18 18 ratio 3 3 3 density {RHO} viscosity {MU} every 10
fix_modify gas boundary zlo inlet {inlet} boundary zhi pressure 0
{modify}
thermo_style custom step f_gas[4] f_gas[5]
thermo_modify norm no
thermo {steps}
run {steps}
{after}
"""


def tube(**options):
    return stl([(R, 0.0), (R, 0.4 * H), (R, H)], **options)


def with_hole(text):
    """Some facets less: a hole two cells wide."""
    facets = text.split("facet normal")
    return "facet normal".join(facets[:200] + facets[220:])


def ball(radius=4e-3, centre=0.009, **options):
    import numpy as np
    rings = [(radius * np.sin(a), centre - radius * np.cos(a)) for a in np.linspace(0, np.pi, 24)]
    return stl(rings, facets=48, **options)


# name: lines before the fix, fix_modify, words of the sentence, further: script(), files
WRONG = {
    "no fix of that id": ("", "solid a mesh nope", "solid a mesh", "nope", "no fix of that id"),
    "a fix of another kind": (WALL.format(what="primitive type 1 zplane 0"), "solid a mesh steel", "solid a mesh", "wall/gran", "mesh/surface"),
    "no region of that id": ("", "solid a region nope", "no region of that id"),
    "region that moves": ("variable q equal 0.001*step\nregion ball sphere 0.0085 0.0085 0.009 0.003 move v_q NULL NULL units box", "solid a region ball", "moves"),
    "region that grows": ("variable q equal 0.003+0.001*step\nregion ball sphere 0.0085 0.0085 0.009 v_q units box", "solid a region ball", "shape"),
    "mesh that moves": (MESH + "\nfix turn all move/mesh mesh cad rotate origin 0 0 0 axis 0 0 1 period 1", "solid a mesh cad", "turn", "at rest"),
    "unknown kind": (BALL, "solid a sphere ball", "found sphere", "mesh, wall or region"),
    "no name": (BALL, "solid", "end of the line"),
    "one name twice": (BALL, "solid a region ball solid a region ball", "second body of this name"),
    "slip and noslip": (BALL, "solid a region ball slip noslip", "noslip and slip"),
    "fluid_at outside": (BALL, "solid a region ball fluid_at 0.1 0 0", "fluid_at", "domain"),
    "fluid_at in the solid": (BALL, "solid a region ball" + POINT, "fluid_at", "solid of a"),
    "fluid_at cut short": (BALL, "solid a region ball fluid_at 0.1 0", "fluid_at", "three coordinates"),
    "both sides reach inlet and outlet": (MESH + "\n" + WALL.format(what="mesh n_meshes 1 meshes cad"), "solid a mesh cad", "fluid_at", dict(grains=(0.0085, 0.0005))),
    "a mesh that leaks": (MESH, "solid a mesh cad" + POINT, "body 'a'", "fluid on both sides"),
    "no room left": ("region all block INF INF INF INF INF INF units box", "solid a region all", "body 'a'", "no edge"),
    "inlet walled up": ("region plug block INF INF INF INF INF 0.002 units box", "solid a region plug", "zlo", "cover"),
    "outlet walled up": ("region plug block INF INF INF INF 0.016 INF units box", "solid a region plug", "outlet"),
    "wall between inlet and outlet": ("region plug block INF INF INF INF 0.008 0.011 units box", "solid a region plug", "outlet"),
    "body outside the domain": ("region ball sphere 0.0085 0.0085 0.09 0.003 units box", "solid a region ball", "body 'a'", "outside"),
    "body thinner than a cell": ("region sheet block INF INF 0.0101 0.0103 0.004 0.012 units box", "solid a region sheet", "thinner than a cell"),
    "a region as a sheet": (BALL, "solid a region ball sheet", "as a sheet", "mesh FIXID sheet"),
    "a sheet beside the domain": (MESH.replace("type 1", "type 1 move 0.1 0 0", 1), "solid a mesh cad sheet", "sheet 'a'", "stands between no two cells"),
    "after the first run": (BALL, "cfl 0.3", "solid", "first run", dict(after="fix_modify gas solid a region ball")),
    "another shape in a later run": (BALL, "solid a region ball", "another shape", dict(after="region ball delete\nregion ball sphere 0.0085 0.0085 0.009 0.004 units box\nrun 10")),
}


def behind_the_wall(c, executable):
    """A wall at 8.6 mm: six particle cells of 2.8 mm; the fourth is open for a sliver, the others behind it are closed."""
    side = "region side block 0.0086 INF INF INF INF INF units box"
    run = Run(executable, script(side, "fix_modify gas solid a region side", grains=(0.004, 0.0125, 0.0155, 0.0165)).replace("f_gas[5]\n", "f_gas[5] f_gas[23] f_gas[24]\n"))
    t = run.thermo()
    c.true(f"grains in the cell behind the wall: {column(t, 'f_gas[23]')} (wanted: 1), and deeper: {column(t, 'f_gas[24]')} (wanted: 2), from the beginning",
           (column(t, "f_gas[23]") == 1).all() and (column(t, "f_gas[24]") == 2).all())
    c.true("a warning, once", run.output.count("2 particle(s), one of them of ID 4, lie in a body") == 1)


def other_bodies_than_the_checkpoints(c, executable):
    """LIGGGHTS' own way, by two scripts."""
    modify = "fix_modify gas solid a region ball"
    first = Run(executable, script(BALL, modify, "write_restart a.restart\nfix_modify gas checkpoint write a.h5"))
    for name, before, change, words in (
            ("the same", BALL, modify, ()),
            ("a ball that is larger", BALL.replace("0.003 units", "0.0031 units"), modify, ("bodies", "solid")),
            ("a ball a tenth of a cell further", BALL.replace("0.0085 0.0085", "0.0086 0.0085"), modify, ("bodies", "solid")),
            ("none", "", "", ("no bodies", "solid"))):
        lines = [line for line in script(before, f"{change}\nfix_modify gas checkpoint read {first.path}/a.h5").split("\n") if not line.startswith(("create_atoms", "set group", "region box"))]
        text = "\n".join(f"read_restart {first.path}/a.restart" if line.startswith("create_box") else line for line in lines)
        run = Run(executable, text, expect_success=not words)
        errors = [line for line in run.output.split("\n") if line.startswith("ERROR")]
        c.true(f"a checkpoint, and the script's bodies: {name}: {errors}", (run.code != 0) == bool(words) == (len(errors) == 1) and all(w in errors[0] for w in words))


def main():
    executable, _ = arguments()
    c = Checks("bodies that can't be")

    def wrong(name):
        before, modify, *words = WRONG[name]
        further = words.pop() if isinstance(words[-1], dict) else {}
        text = with_hole(tube()) if "leaks" in name else tube()
        run = Run(executable, script(before, "fix_modify gas " + modify, **further), expect_success=False, files={"a.stl": text})
        errors = [line for line in run.output.split("\n") if line.startswith("ERROR")]
        return name, run.code != 0 and len(errors) == 1 and all(w in errors[0] for w in words), errors or run.output[-300:]

    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        for name, good, said in pool.map(wrong, WRONG):
            c.true(f"{name}: {said}", good)

    def drop(before, modify, text=""):
        run = Run(executable, script(before, modify and "fix_modify gas " + modify), files={"a.stl": text} if text else None)
        return column(run.thermo(), "f_gas[4]")[-1], run

    mesh = MESH + "\n" + WALL.format(what="mesh n_meshes 1 meshes cad")
    right, _ = drop(mesh, "solid a mesh cad" + POINT, tube())
    for name, (before, modify, text) in {
            "inverted mesh": (mesh, "solid a mesh cad" + POINT, tube(inverted=True)),
            "a mesh, and within its solid a region": (mesh + "\n" + f"region tube cylinder z {C[0]} {C[1]} {R * 1.3} INF INF side out units box",
                                                      "solid a mesh cad solid b region tube" + POINT, tube()),
            "a mesh, and a region less than a cell behind it": (mesh + "\n" + f"region tube cylinder z {C[0]} {C[1]} {R * 1.02} INF INF side out units box",
                                                                "solid a mesh cad solid b region tube" + POINT, tube()),
    }.items():
        got, _ = drop(before, modify, text)
        c.below(f"{name}: pressure drop against the right one, relative", abs(got / right - 1), 0.012 if "less than" in name else 1e-6)
    _, run = drop(mesh, "", tube())
    c.true("a wall that the fluid doesn't see: the line to add", "'fix_modify gas solid cad mesh cad'" in run.output)
    _, run = drop(MESH, "solid a mesh cad" + POINT, tube())
    c.true("a mesh that the particles don't feel: a warning", "is no wall for the particles" in run.output)
    rods = []
    for z in (0.0095, 0.0096):
        run = Run(executable, script(f"region rod cylinder y {8.5 * WIDE / 18} {z} 0.0025 INF INF units box", "fix_modify gas solid a region rod", grains=(0.002,)))
        rods.append(column(run.thermo(), "f_gas[4]")[-1])
    c.below("a rod that touches edges of the grid half way, against one that crosses them, pressure drop, relative", abs(rods[0] / rods[1] - 1), 0.05)
    behind_the_wall(c, executable)
    other_bodies_than_the_checkpoints(c, executable)
    c.end()


if __name__ == "__main__":
    main()
