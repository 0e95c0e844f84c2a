#!/usr/bin/python3
"""Breaks the code, one line at a time, and notes which test sees it.

    run.py --check              each mutation's text stands exactly once in the sources
    run.py --clean              the tests pass without a mutation; says what each of them costs
    run.py                      the mutations that results.csv lacks
    run.py --first              only against the tests of a few seconds; those that nobody notices get no result
    run.py --long               those that nobody has noticed, against the long tests
    run.py --again --only WHAT  mutations whose name or file has the regular expression WHAT, once more
    run.py --table              the table of README.md from results.csv

Each mutation is made in a git worktree of its own and built in a folder of its own (--scratch), so neither the sources
nor build/ are touched. Only what the next tests need is built; the likeliest and quickest tests come first, and the first
that fails ends the mutation. cmake takes what it wants to know from the environment, for instance
CMAKE_CXX_COMPILER_LAUNCHER=ccache, CMAKE_GENERATOR=Ninja, CMAKE_BUILD_PARALLEL_LEVEL, CXX.
"""
import argparse
import csv
import datetime
import fcntl
import os
import re
import subprocess
import sys
import time

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
LIST, RESULTS, README = (os.path.join(HERE, f) for f in ("mutations.txt", "results.csv", "README.md"))
COLUMNS = ["mutation", "kind", "file", "noticed by", "date", "commit"]
UNNOTICED = "nobody"
LIMIT = 90  # s; a unit test that takes longer than this has noticed that something is wrong
SLOW = 600  # s; the same for a filter of the verification tests

MPIRUN = ["mpirun", "--allow-run-as-root", "--oversubscribe", "--bind-to", "none", "--mca", "mpi_yield_when_idle", "1",
          "--mca", "btl_base_warn_component_unused", "0", "--mca", "btl", "self,vader"]

# The tests of a file's mutations, in this order, until one fails: those of the longest beginning of its path. A target,
# then what it is needed for: patterns of ctest's names, or for verification_tests the ranks and filters of GoogleTest.
FAST = "-Cavity.*:Central.*:StretchedGrid.*:Manufactured.*:UniformFlow.*:VoidFractionJump.*:ViscosityField.*"
FLOWS = [("verification_tests", ["1 " + FAST, "2 " + FAST, "1 VoidFractionJump.*:ViscosityField.*",
                                 "1 UniformFlow.*:StretchedGrid.*", "1 Central.*:Cavity.Reynolds100",
                                 "2 VoidFractionJump.*:UniformFlow.Carries*"])]
ORDERS = [("verification_tests", ["1 Manufactured.*-*FineGrids*"])]
CFD = [("unit_tests", ["^unit/cfd/.*_np1$", "^unit/cfd/.*_np2$"])] + FLOWS
COUPLING = [("unit_tests", ["^unit/coupling/.*_np1$", "^unit/coupling/.*_np2$"])]
BODIES = [("unit_tests", ["^unit/cfd/.*(cut_grid|walls|body|triangle).*_np[12]$"]),
          ("verification_tests", ["1 Bodies.*:BodiesBalance.*-*Annulus", "2 BodiesBalance.*:Bodies.Pipe", "1 BodiesInFlow.*:BodiesInArrays.*:Bodies.Annulus"]),
          ("twogrid", ["^(bodies|bad_bodies)$"])]
FIXES = [("unit_tests", ["^unit/liggghts_fixes/.*_np1$"])]
# System tests, by what they cost.
QUICK = ["^(periodic_sides|fixed_particles|come_and_go|action_reaction|watched_drag|held|outlets)$"]
BALANCES = ["^(between_runs|overfull|bed_end|mixtures|accuracy)$", "^(momentum|continuity)$"]
STAGES = {
    "cfd/": CFD + [("twogrid", QUICK)] + ORDERS + [("twogrid", BALANCES)],
    "cfd/bodies/": BODIES,
    "cfd/momentum/cut_links": BODIES,
    "cfd/fluid/predictor": CFD + BODIES[1:2] + [("twogrid", QUICK)] + ORDERS + [("twogrid", BALANCES)],
    "cfd/parallel/": CFD[:1] + COUPLING + FLOWS + [("twogrid", QUICK + BALANCES)],
    "coupling/": COUPLING + [("twogrid", QUICK + BALANCES)],
    "coupling/checkpoint/": [("unit_tests", ["^unit/coupling/test_state_file_np"]), ("twogrid", ["^checkpoint$"])],
    "liggghts_fixes/": FIXES + [("twogrid", QUICK + ["^ranks$", "^(scripts|skin|balance|restart)$"] + BALANCES +
                                 ["^same_bits$"])],
    "liggghts_fixes/liggghts/balance": [("twogrid", ["^balance$", "^(ranks|skin|scripts|restart)$"] + BALANCES)],
    "liggghts_fixes/contacts/": [("twogrid", ["^same_bits$", "^skin$"] + QUICK + BALANCES)],
}
LONG = [("twogrid", ["^(fixed_bed|ranks|mirror|same_bits|methods|bed_balance|stiff_drag|periodic_settling|intervals)$",
                     "^(script_commands|limits|corners|one_particle|settling|mueller_short|min_fluidisation|skin)$",
                     "^(scripts|balance|restart|rising_sphere|lattice_in_time|keywords)$"])]


def read_list():
    mutations, block = [], {}
    for number, line in enumerate(open(LIST), 1):
        line = line.rstrip("\n")
        if line.startswith("@ "):
            words = [w.strip() for w in line[2:].split("|")]
            if len(words) != 3:
                sys.exit(f"{LIST}:{number}: wanted '@ name | file | kind', found '{line}'")
            block = dict(zip(("name", "file", "kind"), words))
            mutations.append(block)
        elif line[:2] in ("- ", "+ "):
            block[line[0]] = line[2:]
        elif line and not line.startswith("#"):
            sys.exit(f"{LIST}:{number}: wanted '@', '-', '+' or '#' first, found '{line}'")
    names = [m["name"] for m in mutations]
    for name in names:
        if names.count(name) > 1:
            sys.exit(f"{LIST}: two mutations are called '{name}'")
    return mutations


def find(mutation, root):
    """The file with the mutation's text: the one named, or another of its folder, for lines move. Else an error."""
    text = mutation["-"]
    named = os.path.join(root, mutation["file"])
    files = [named] if os.path.exists(named) and text in open(named).read() else []
    if not files:
        for folder, _, names in os.walk(os.path.join(root, mutation["file"].split("/")[0])):
            files += [p for p in (os.path.join(folder, n) for n in names if n.endswith((".h", ".cpp")))
                      if text in open(p).read()]
    count = sum(open(p).read().count(text) for p in files)
    if count != 1:
        raise LookupError(f"'{mutation['name']}': the text stands {count} times in {mutation['file']} or its folder, "
                          f"wanted once: {text}")
    return files[0]


def run(command, **more):
    """With its words; system tests end with the first check that fails."""
    return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          env={**os.environ, "STOP_AT_FIRST_FAILURE": "1"}, **more)


class Copy:
    """A worktree of the sources and its build folder."""

    def __init__(self, scratch):
        self.scratch = scratch
        self.source = os.path.join(scratch, "source")
        self.build = os.path.join(self.source, "build")
        os.makedirs(scratch, exist_ok=True)

    @staticmethod
    def git(where, *words):
        done = run(["git", "-C", where, *words])
        if done.returncode:
            sys.exit(done.stdout)
        return done.stdout.strip()

    def set_up(self, commit):
        self.commit = self.git(ROOT, "rev-parse", commit)
        if os.path.exists(self.source):
            self.git(self.source, "checkout", "--force", "--detach", self.commit)
        else:
            self.git(ROOT, "worktree", "prune")
            self.git(ROOT, "worktree", "add", "--detach", self.source, self.commit)
        done = run(["cmake", "-S", self.source, "-B", self.build, "-DCMAKE_BUILD_TYPE=Release"])
        if done.returncode:
            sys.exit(done.stdout)
        # A unit test that hangs should not cost the minutes that its own limit allows.
        path = os.path.join(self.build, "tests", "CTestTestfile.cmake")
        lists = open(path).read()
        open(path, "w").write(re.sub(r'(\(\[=\[unit/.*TIMEOUT) "\d+"', rf'\1 "{LIMIT}"', lists))

    def make(self, target):
        """What the compiler says if it refuses, else nothing."""
        done = run(["cmake", "--build", self.build, "--target", target])
        return done.stdout if done.returncode else ""

    def noticed_by(self, stages, on=lambda what, seconds: None):
        """The first test that fails, or UNNOTICED."""
        for target, patterns in stages:
            if refusal := self.make(target):
                print(refusal[-2000:], flush=True)
                return "the compiler"
            for pattern in patterns:
                begin = time.time()
                failed = self.verify(*pattern.split()) if target == "verification_tests" else self.ctest(pattern)
                on(pattern, time.time() - begin)
                if failed:
                    return failed
        return UNNOTICED

    def ctest(self, pattern):
        done = run(["ctest", "--test-dir", self.build, "--stop-on-failure", "-j", "1", "-R", pattern])
        failed = re.findall(r"^\s*\d+ - (\S+) \((?!Not Run)([^)]*)\)", done.stdout, re.M)
        if failed:
            return failed[0][0] + (" (time limit)" if failed[0][1] == "Timeout" else "")
        if done.returncode or "No tests were found" in done.stdout:
            sys.exit(f"ctest -R '{pattern}' ended with {done.returncode}:\n{done.stdout[-2000:]}")
        return ""

    def verify(self, ranks, tests):
        """The verification test that fails, with the others of the filter behind it left out where one rank runs."""
        program = [os.path.join(self.build, "tests", "verification_tests"), "--gtest_color=no",
                   "--gtest_filter=" + tests]
        # A rank that stopped at its own failure would leave the others waiting.
        program += ["--gtest_fail_fast"] if ranks == "1" else []
        name = f"verification/{tests} on {ranks}"
        try:
            done = run([*MPIRUN, "-np", ranks, *program], timeout=SLOW)
        except subprocess.TimeoutExpired:
            return name + " (time limit)"
        if not done.returncode:
            return ""
        failed = re.findall(r"^\[  FAILED  \] (\S+) \(", done.stdout, re.M)
        begun = re.findall(r"^\[ RUN      \] (\S+)", done.stdout, re.M)
        if not begun:
            sys.exit(f"{' '.join(program)} ended with {done.returncode}:\n{done.stdout[-2000:]}")
        return f"verification/{(failed or begun[-1:])[0]} on {ranks}"


def first(stages):
    """Unit tests, and of the verification tests the first two filters."""
    return [(t, p[:2]) for t, p in stages if t == "unit_tests" or (t == "verification_tests" and p[0].endswith(FAST))]


class Broken:
    """The sources with a mutation, for as long as a with statement lasts."""

    def __init__(self, mutation, root):
        self.mutation, self.path = mutation, find(mutation, root)

    def __enter__(self):
        self.text = open(self.path).read()
        open(self.path, "w").write(self.text.replace(self.mutation["-"], self.mutation["+"]))

    def __exit__(self, *_):
        open(self.path, "w").write(self.text)


def stages_of(file, long):
    begins = [b for b in STAGES if file.startswith(b)]
    return STAGES[max(begins, key=len)] if not long else LONG


def results():
    if not os.path.exists(RESULTS):
        return {}
    with open(RESULTS, newline="") as f:
        return {row["mutation"]: row for row in csv.DictReader(f)}


def keep(row, lock):
    """Adds a row, or replaces the one of that name; several runs may write at once."""
    files = {m["name"]: m["file"] for m in read_list()}
    with open(lock, "w") as held:
        fcntl.flock(held, fcntl.LOCK_EX)
        rows = results()
        rows[row["mutation"]] = row
        with open(RESULTS + ".new", "w", newline="") as f:
            out = csv.DictWriter(f, COLUMNS, lineterminator="\n")
            out.writeheader()
            # Files move; a row names the present one.
            out.writerows({**r, "file": files.get(r["mutation"], r["file"])} for r in rows.values())
        os.replace(RESULTS + ".new", RESULTS)


def table():
    begin, end = "<!-- table -->\n", "<!-- end of table -->\n"
    known = results()
    lines = ["| mutation | kind | file | noticed by |", "|---|---|---|---|"]
    for m in read_list():
        by = known[m["name"]]["noticed by"] if m["name"] in known else "not run yet"
        lines.append(f"| {m['name']} | {m['kind']} | {m['file']} | {by} |")
    text = open(README).read()
    head, tail = text.split(begin)[0], text.split(end)[1]
    open(README, "w").write(head + begin + "\n".join(lines) + "\n" + end + tail)


def main():
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--check", action="store_true")
    words.add_argument("--table", action="store_true")
    words.add_argument("--scratch", default=os.path.join(ROOT, "build-mutations"), help="folder of the copy and its build")
    words.add_argument("--commit", default="HEAD", help="of the sources that are broken; HEAD by default")
    words.add_argument("--only", default="", help="mutations whose name or file has this regular expression")
    words.add_argument("--again", action="store_true", help="also those that have a result")
    words.add_argument("--first", action="store_true", help="only unit tests and quick verification tests")
    words.add_argument("--long", action="store_true", help="those that nobody has noticed, with the long tests")
    words.add_argument("--clean", action="store_true", help="the tests without a mutation: all of them must pass")
    said = words.parse_args()
    if said.table:
        return table()
    mutations = read_list()
    if said.check:
        bad = 0
        for m in mutations:
            try:
                find(m, ROOT)
            except LookupError as e:
                bad += 1
                print(e)
        print(f"{len(mutations)} mutations, {bad} without their place")
        sys.exit(1 if bad else 0)

    # One of every file first: what is known after a part of the hours then holds for all files.
    files = [m["file"] for m in mutations]
    mutations = [m for _, m in sorted(enumerate(mutations), key=lambda q: files[:q[0]].count(q[1]["file"]))]
    copy = Copy(os.path.abspath(said.scratch))
    copy.set_up(said.commit)
    if said.clean:
        every = []
        for target in ("unit_tests", "verification_tests", "twogrid"):
            patterns = [p for stages in (*STAGES.values(), LONG if said.long else []) for t, ps in stages if t == target
                        for p in ps]
            every.append((target, list(dict.fromkeys(patterns))))
        by = copy.noticed_by(every, lambda what, seconds: print(f"{seconds:4.0f} s  {what}", flush=True))
        sys.exit(f"noticed without a mutation: {by}" if by != UNNOTICED else 0)
    for m in mutations:
        known = results().get(m["name"])
        unseen = known and known["noticed by"] == UNNOTICED
        wanted = not known or said.again or (said.long and unseen)
        if not wanted or not re.search(said.only, m["name"] + "\n" + m["file"]):
            continue
        begin = time.time()
        stages = stages_of(m["file"], said.long and unseen)
        if said.first:
            stages = first(stages)
            if not stages:
                continue
        try:
            with Broken(m, copy.source):
                by = copy.noticed_by(stages)
        except LookupError as e:
            print(e, flush=True)
            continue
        print(f"{m['name']}: {by} ({time.time() - begin:.0f} s)", flush=True)
        if by == UNNOTICED and said.first:
            continue
        if by == UNNOTICED and said.long and unseen:
            by += ", long tests included"
        row = {"mutation": m["name"], "kind": m["kind"], "file": m["file"], "noticed by": by,
               "date": datetime.date.today().isoformat(), "commit": copy.commit[:12]}
        keep(row, os.path.join(copy.scratch, "results.lock"))


if __name__ == "__main__":
    main()
