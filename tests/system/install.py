#!/usr/bin/python3
"""An installation by itself in a path with a space, and libraries that don't fit.

Without this test installed scripts could look for program or tools in the source or in build/, write results into a prefix that all users share, or
break at a space; and a wrong folder, a PETSc of complex numbers, an HDF5 without MPI, a LIGGGHTS of another MPI or other integers could end in the
compiler's words, or in a program that crashes. What is installed is that of the build at hand, moved away from where it was installed to; the faulty
libraries are stand-ins: a folder with one changed header or an empty library.

    install.py EXECUTABLE RANKS
"""
import os
import re
import shutil
import subprocess
import tempfile

from harness import Checks, arguments

SOURCE = os.path.abspath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))


def say(*command, env=None, **more):
    """Exit code and all that it says, without line breaks of CMake's."""
    clean = {k: v for k, v in os.environ.items() if not re.match(r"TWOGRID|LIGGGHTS_|PETSC_|HDF5_|Eigen3_", k)}
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace", timeout=200, env={**clean, **(env or {})}, **more)
    return done.returncode, re.sub(r"\s+", " ", done.stdout)


def read_only(folder):
    """Ordinary users may not write; root may, so that what was written is looked for as well."""
    for at, _, names in os.walk(folder):
        for name in names:
            path = os.path.join(at, name)
            os.chmod(path, os.stat(path).st_mode & ~0o222)
        os.chmod(at, 0o555)


def files_of(folder):
    return {os.path.join(at, n) for at, _, names in os.walk(folder) for n in names if "__pycache__" not in at}


def runs_from_its_prefix(c, executable, scratch):
    prefix, first = os.path.join(scratch, "a prefix"), os.path.join(scratch, "first")
    code, said = say("cmake", "--install", os.path.dirname(executable), "--prefix", first)
    c.true(f"installed: code {code}{'' if code == 0 else ' ' + said[-400:]}", code == 0)
    os.rename(first, prefix)
    read_only(prefix)
    before, cases, here = files_of(prefix), os.path.join(prefix, "share", "twogrid", "cases"), os.path.join(scratch, "some where")
    os.mkdir(here)
    named = [f for f in before if f.endswith((".py", ".sh", ".slurm", "run", "new", "list")) and SOURCE in open(f, errors="replace").read()]
    c.true(f"no script names the source's folder{': ' + named[0] if named else ''}", not named)
    code, said = say(os.path.join(cases, "run"), "first_bed", "--short", "--ranks", "2", cwd=here)
    out = os.path.join(here, "out", "first_bed", "run_short")
    passed = len(re.findall("PASS  ?", said))
    c.true(f"run first_bed: code {code}, {passed} checks passed, report in ./out/first_bed{'' if code == 0 else said[-600:]}",
           code == 0 and passed >= 4 and os.path.exists(os.path.join(out, "report.html")))
    code, said = say(os.path.join(cases, "new"), "mine", "--like", "first_bed", cwd=here)
    mine = os.path.join(here, "mine")
    c.true(f"new makes ./mine, which its owner may write: code {code}", code == 0 and os.stat(os.path.join(mine, "in.mine")).st_mode & 0o200 != 0)
    code, said = say(os.path.join(cases, "run"), mine, "--ranks", "1", "-var", "settle", "10", "-var", "tend", "0.002", "-var", "tavg", "0.001", cwd=scratch, env={"TWOGRID_NO_PICTURES": "1", "TWOGRID_NO_REPORT": "1"})
    c.true("its results lie beside it: " + ", ".join(sorted(os.listdir(os.path.join(mine, "out")))), len(os.listdir(os.path.join(mine, "out"))) == 1)
    code, said = say(os.path.join(cases, "gallery.py"), cwd=here)
    with open(os.path.join(here, "out", "gallery.html"), encoding="utf-8") as f:
        c.true(f"the gallery shows the run in ./out: code {code}", code == 0 and "run_short" in f.read())
    code, said = say(os.path.join(cases, "sweep.py"), os.path.join(cases, "studies", "terminal_velocity"), "--count", cwd=here)
    c.true(f"a study knows its runs: {said}", code == 0 and int(said) > 1)
    with open(os.path.join(here, "in.short"), "w") as f:
        f.write("print done\n")
    code, said = say(os.path.join(cases, "batch", "leg.sh"), "leg", "in.short", cwd=here)
    c.true(f"leg.sh finds the program: code {code}", code == 0)
    new = files_of(prefix) - before
    c.true(f"nothing was written into the prefix{': ' + sorted(new)[0] if new else ''}", not new)


def configure(scratch, name, *words, env=None):
    return say("cmake", "--preset", "cluster", "-G", "Ninja", "-B", os.path.join(scratch, name), *words, cwd=SOURCE, env=env)


def wrong_folders(c, scratch):
    empty = os.path.join(scratch, "an empty folder")
    os.mkdir(empty)
    code, said = configure(scratch, "b1", f"-DLIGGGHTS_ROOT={empty}", f"-DEigen3_ROOT={empty}", env={"PETSC_DIR": empty, "HDF5_ROOT": empty})
    for what in ("PETSc is not in PETSC_DIR=", "HDF5 is not in HDF5_ROOT=", "LIGGGHTS is not in LIGGGHTS_ROOT=", "Eigen is not in Eigen3_ROOT="):
        c.true(f"wrong folders, in one go: {what}...", code != 0 and what + empty in said)
    if shutil.which("clang++"):
        code, said = configure(scratch, "b4", "-DCMAKE_CXX_COMPILER=clang++")
        c.true("clang is taken", code == 0)


def stand_in(scratch, name, code, **headers):
    """A prefix with lib/libNAME.so made of code, and headers of a line each."""
    prefix = os.path.join(scratch, "prefix of " + name)
    for folder in ("include", "lib"):
        os.makedirs(os.path.join(prefix, folder))
    for header, line in headers.items():
        with open(os.path.join(prefix, "include", header + ".h"), "w") as f:
            f.write(line + "\n")
    with open(os.path.join(prefix, "code.cpp"), "w") as f:
        f.write(code)
    subprocess.run(["mpicxx", "-shared", "-fPIC", "-o", os.path.join(prefix, "lib", f"lib{name}.so"), os.path.join(prefix, "code.cpp")], check=True)
    return prefix


def libraries_that_do_not_fit(c, executable, scratch):
    with open(os.path.join(os.path.dirname(executable), "compile_commands.json")) as f:
        liggghts = next(d for d in re.findall(r"-isystem (\S+)", f.read()) if os.path.exists(os.path.join(d, "lammps.h")))
    petsc = stand_in(scratch, "petsc", "", petscksp="#define PETSC_USE_COMPLEX 1", petscconf="")
    hdf5 = stand_in(scratch, "hdf5", 'extern "C" void H5open() {}', hdf5='#include "H5pubconf.h"', H5pubconf='#define H5_VERSION "1.10.8"')
    other_mpi = stand_in(scratch, "liggghts", "namespace LAMMPS_NS { struct LAMMPS { LAMMPS(int, char**, int); }; LAMMPS::LAMMPS(int, char**, int) {} }")
    os.symlink(liggghts, os.path.join(other_mpi, "include", "liggghts"))
    code, said = configure(scratch, "b2", f"-DLIGGGHTS_ROOT={other_mpi}", f"-DHDF5_ROOT={hdf5}", f"-DPETSC_DIR={petsc}")
    for what in ("its numbers are complex", "HDF5: it was built without MPI", "was built with another MPI than"):
        c.true(f"libraries that don't fit, in one go: {what}", code != 0 and what in said)
    os.rename(other_mpi, os.path.join(scratch, "other"))
    # Its own integers have 64 bits: the function has another name to the linker.
    other_integers = stand_in(scratch, "liggghts", "#include <mpi.h>\nnamespace LAMMPS_NS { struct LAMMPS { LAMMPS(int, char**, MPI_Comm); ~LAMMPS(); };"
                              "LAMMPS::LAMMPS(int, char**, MPI_Comm) {} LAMMPS::~LAMMPS() {} struct Modify { void addstep_compute(long); };"
                              "void Modify::addstep_compute(long) {} struct Domain { void unmap(double*, long); }; void Domain::unmap(double*, long) {} }")
    os.symlink(liggghts, os.path.join(other_integers, "include", "liggghts"))
    code, said = configure(scratch, "b3", f"-DLIGGGHTS_ROOT={other_integers}")
    c.true("another one: LIGGGHTS counts in other integers", code != 0 and "counts in other integers" in said)


def main():
    executable, _ = arguments()
    scratch = tempfile.mkdtemp(prefix="install_")
    try:
        c = Checks("an installation by itself")
        runs_from_its_prefix(c, os.path.abspath(executable), scratch)
        wrong_folders(c, scratch)
        libraries_that_do_not_fit(c, os.path.abspath(executable), scratch)
    finally:
        subprocess.run(["chmod", "-R", "u+w", scratch])
        shutil.rmtree(scratch)
    c.end()


if __name__ == "__main__":
    main()
