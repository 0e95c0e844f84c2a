#!/usr/bin/env python3
"""Breaks the code, one line at a time, and notes which test sees it.

    run.py --check              each mutation's text stands exactly once in the sources
    run.py --clean              the tests pass without a mutation
    run.py                      the mutations that results.csv lacks
    run.py --long               those that nobody has noticed, against the long tests too
    run.py --again --only TEXT  mutations whose name or file holds TEXT, once more
    run.py --build 20           builds the next 20, while ...
    run.py --test               ... one or more of these test what is built
    run.py --table              the table of README.md from results.csv

Each mutation is made in a git worktree of its own and built in a folder of its own (--scratch), so neither the sources
nor build/ are touched. The tests go from the quick to the slow; the first that fails ends the mutation. cmake takes what
it wants to know from the environment, for instance CMAKE_CXX_COMPILER_LAUNCHER=ccache, CMAKE_GENERATOR=Ninja, CXX.
"""
import argparse
import csv
import datetime
import fcntl
import os
import re
import shutil
import subprocess
import sys
import time

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
LIST, RESULTS, README = (os.path.join(HERE, f) for f in ("mutations.txt", "results.csv", "README.md"))
COLUMNS = ["mutation", "kind", "file", "noticed by", "date", "commit"]
UNNOTICED = "nobody"
LIMIT = 90  # s; a unit test that takes longer than this has noticed that something is wrong

# What is built, and the tests that are then run, in this order, until one fails.
UNIT = [("unit_tests", ["^unit/(cfd|coupling)/.*_np1$", "^unit/(cfd|coupling)/.*_np2$"])]
VERIFICATION = [("verification_tests", ["^verification_np1$", "^verification_flows_np2$"])]
STAGES = {
    "cfd": UNIT + [("twogrid", ["^(come_and_go|action_reaction)$", "^(outlets|momentum|continuity)$"])] + VERIFICATION,
    "coupling": UNIT + [("twogrid", ["^(fixed_particles|come_and_go|action_reaction|watched_drag|held)$",
                                     "^(between_runs|overfull|accuracy|bed_end|mixtures)$",
                                     "^(momentum|continuity)$"])],
    "liggghts_fixes": [("unit_tests", ["^unit/liggghts_fixes/.*_np1$"]),
                       ("twogrid", ["^(scripts|fixed_particles|come_and_go|action_reaction|held|skin|between_runs)$",
                                    "^(momentum|continuity|restart|balance)$", "^same_bits$"])],
}
LONG = [("twogrid", ["^(fixed_bed|ranks|mirror|same_bits|methods|bed_balance|stiff_drag|periodic_settling|intervals)$",
                     "^(script_commands|limits|corners|one_particle|settling|mueller_short|min_fluidisation|skin)$"])]


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
    return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **more)


class Copy:
    """A worktree at HEAD, its build folder, and the mutants that were built: a folder each, of the programs and of
    ctest's lists, so that tests run while the next mutant is built."""

    def __init__(self, scratch):
        self.source = os.path.join(scratch, "source")
        self.build = os.path.join(self.source, "build")
        self.built, self.tested = os.path.join(scratch, "built"), os.path.join(scratch, "tested")
        for folder in (self.built, self.tested):
            os.makedirs(folder, exist_ok=True)

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

    def make(self, mutation, stages):
        """Builds a mutant; its folder, or None if it does not compile."""
        path = find(mutation, self.source) if mutation else None
        text = open(path).read() if path else ""
        try:
            if path:
                open(path, "w").write(text.replace(mutation["-"], mutation["+"]))
            targets = sorted({target for target, _ in stages})
            done = run(["cmake", "--build", self.build, "--target", *targets])
        finally:
            if path:
                open(path, "w").write(text)
        if done.returncode:
            print(done.stdout[-2000:], flush=True)
            return None
        name = slug(mutation)
        there, made = os.path.join(self.built, name), os.path.join(self.built, name + ".new")
        for folder, _, names in os.walk(self.build):
            to = os.path.normpath(os.path.join(made, os.path.relpath(folder, self.build)))
            if "CTestTestfile.cmake" in names:
                os.makedirs(to, exist_ok=True)
                lists = open(os.path.join(folder, "CTestTestfile.cmake")).read()
                # A unit test that hangs should not cost the minutes that its own limit allows.
                lists = re.sub(r'(\(\[=\[unit/.*TIMEOUT) "\d+"', rf'\1 "{LIMIT}"', lists)
                lists = lists.replace(self.build, os.path.join(self.tested, name))
                open(os.path.join(to, "CTestTestfile.cmake"), "w").write(lists)
                for target in targets:
                    if target in names:
                        shutil.copy2(os.path.join(folder, target), to)
        open(os.path.join(made, "commit"), "w").write(self.commit)
        shutil.rmtree(there, ignore_errors=True)
        os.rename(made, there)
        return there

    def claim(self, mutation):
        """The folder of a mutant that is built and that no other run tests, or None."""
        there = os.path.join(self.tested, slug(mutation))
        try:
            os.rename(os.path.join(self.built, slug(mutation)), there)
        except OSError:
            return None
        return there


def slug(mutation):
    return re.sub(r"[^a-z0-9]+", "-", mutation["name"].lower()).strip("-") if mutation else "none"


def noticed_by(folder, stages):
    """The first test that fails, or UNNOTICED."""
    for _, patterns in stages:
        for pattern in patterns:
            done = run(["ctest", "--test-dir", folder, "--stop-on-failure", "-j", "1", "-R", pattern])
            failed = re.findall(r"^\s*\d+ - (\S+) \((?!Not Run)([^)]*)\)", done.stdout, re.M)
            if failed:
                return failed[0][0] + (" (time limit)" if failed[0][1] == "Timeout" else "")
            if done.returncode:
                sys.exit(f"ctest -R '{pattern}' ended with {done.returncode}:\n{done.stdout[-2000:]}")
    return UNNOTICED


def results():
    if not os.path.exists(RESULTS):
        return {}
    with open(RESULTS, newline="") as f:
        return {row["mutation"]: row for row in csv.DictReader(f)}


def keep(row):
    """Adds a row, or replaces the one of that name; several runs may write at once."""
    with open(RESULTS + ".lock", "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        rows = results()
        rows[row["mutation"]] = row
        with open(RESULTS + ".new", "w", newline="") as f:
            out = csv.DictWriter(f, COLUMNS, lineterminator="\n")
            out.writeheader()
            out.writerows(rows.values())
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
    words.add_argument("--scratch", default=os.path.join(ROOT, "build-mutations"), help="folder of copies and builds")
    words.add_argument("--commit", default="HEAD", help="of the sources that are broken; HEAD by default")
    words.add_argument("--only", default="", help="mutations whose name or file holds this text")
    words.add_argument("--again", action="store_true", help="also those that have a result")
    words.add_argument("--long", action="store_true", help="those that nobody has noticed, with the long tests")
    words.add_argument("--clean", action="store_true", help="the tests without a mutation: all of them must pass")
    words.add_argument("--build", type=int, default=0, metavar="N", help="only build, the next N")
    words.add_argument("--test", action="store_true", help="only test what --build has built")
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
    if not said.test:
        copy.set_up(said.commit)
    if said.clean:
        everything = [stage for stages in STAGES.values() for stage in stages] + (LONG if said.long else [])
        if not copy.make(None, everything) or not (folder := copy.claim(None)):
            sys.exit("does not build")
        print(f"without a mutation: noticed by {noticed_by(folder, everything)}", flush=True)
        return shutil.rmtree(folder)
    count = 0
    for m in mutations:
        known = results().get(m["name"])
        unseen = known and known["noticed by"] == UNNOTICED
        if said.only not in m["name"] and said.only not in m["file"]:
            continue
        if not (said.again or (said.long and unseen) or not known):
            continue
        stages = STAGES[m["file"].split("/")[0]]
        if said.long:
            stages = LONG if unseen else stages + LONG
        row = {"mutation": m["name"], "kind": m["kind"], "file": m["file"],
               "date": datetime.date.today().isoformat()}
        if not said.test:
            if said.build and any(os.path.exists(os.path.join(d, slug(m))) for d in (copy.built, copy.tested)):
                continue
            try:
                if not copy.make(m, stages):
                    keep({**row, "noticed by": "the compiler", "commit": copy.commit[:12]})
                    continue
            except LookupError as e:
                print(e, flush=True)
                continue
            count += 1
            if said.build:
                print(f"built: {m['name']}", flush=True)
                if count == said.build:
                    break
                continue
        folder = copy.claim(m)
        if not folder:
            continue
        begin = time.time()
        by = noticed_by(folder, stages)
        if by == UNNOTICED and said.long:
            by += ", long tests included"
        print(f"{m['name']}: {by} ({time.time() - begin:.0f} s)", flush=True)
        keep({**row, "noticed by": by, "commit": open(os.path.join(folder, "commit")).read()[:12]})
        shutil.rmtree(folder)


if __name__ == "__main__":
    main()
