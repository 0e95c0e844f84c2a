#!/usr/bin/python3
"""A case of the user's own from cases/new runs as a job, is compared, and fails on half the drag; cases/list knows of every case.

Without this test a copied case could still read or write in the old one's folder, a job could start on other ranks or variables than cases/run
does, or be done without its verdict; a misspelt choice could be run as if it were one, a run that was ended be judged as if it had come to its end; choices of the user could lose against those of --short; and a comparison could pass whatever the drag. The
job is started by a stand-in for sbatch, which runs the script at once (a real Slurm: slurm.py). Half the drag: a run is compared with the law of a
gas that is twice as dense and viscous, for which the laws give exactly twice the force.

    own_case.py EXECUTABLE RANKS
"""
import os
import re
import shutil
import subprocess
import tempfile
import time

import h5py

from harness import Checks, arguments

CASES = os.path.abspath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "cases"))
SBATCH = """#!/bin/sh
# sbatch --parsable [--ntasks=N] SCRIPT WORDS...
[ "$1" = --parsable ] || exit 1; shift
export SLURM_NTASKS=2 SLURM_JOB_ID=7 SLURM_SUBMIT_DIR="$PWD"
case $1 in --ntasks=*) SLURM_NTASKS=${1#*=}; shift ;; esac
cp "$1" spooled; shift
bash spooled "$@" >bed_7.out 2>&1 </dev/null; echo $? >code
echo 7
"""


def say(*command, **more):
    return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace", timeout=120, **more)


def every_case_is_listed(c):
    done = say(os.path.join(CASES, "list"), env={**os.environ, "COLUMNS": "200"})
    names = sorted(n for n in os.listdir(CASES) if os.path.exists(os.path.join(CASES, n, "case.sh")))
    rows = {line.split()[0]: re.split(r"  +", line) for line in done.stdout.split("\n")[2:] if line[:1].strip()}
    c.true(f"cases/list has {len(rows)} cases (wanted: {len(names)})", done.returncode == 0 and sorted(rows) == names)
    # case, what it is, --short, run, --long, memory, compared with
    gaps = [n for n, r in rows.items() if len(r) != 7 or "-" in (r[1], r[3], r[5], r[6])]
    c.true(f"each says what it is, its time, its memory, what it is compared with{': not ' + ', '.join(gaps) if gaps else ''}", not gaps)


def copies_are_whole(c, scratch):
    """Of every case: no trace of the old name, all scripts in order."""
    wrong = []
    for name in (n for n in sorted(os.listdir(CASES)) if os.path.exists(os.path.join(CASES, n, "case.sh"))):
        done = say(os.path.join(CASES, "new"), "copy_of_it", "--like", name, "--in", scratch)
        folder = os.path.join(scratch, "copy_of_it")
        for file in sorted(os.listdir(folder)) if done.returncode == 0 else [""]:
            path = os.path.join(folder, file)
            if not file:
                wrong.append(f"{name}: {done.stdout.strip()}")
            elif file.endswith(".py"):
                wrong += [f"{name}/{file}"] * (say("/usr/bin/python3", "-m", "py_compile", path).returncode != 0)
            elif file.endswith((".sh", ".slurm", ".pbs")):
                wrong += [f"{name}/{file}"] * (say("bash", "-n", path).returncode != 0)
            if file and os.path.isfile(path) and file != "README.md":
                with open(path, errors="replace") as f:
                    text = f.read()
                wrong += [f"{name} is named in {file}"] * (re.search(rf"(?<![a-z_]){name}(?![a-z])", text) is not None)
        wrong += [] if os.path.exists(os.path.join(folder, "in.copy_of_it")) else [f"{name}: no script"]
        shutil.rmtree(folder, ignore_errors=True)
    c.true("copies of all cases have their new name" + "".join(f"; {w}" for w in wrong), not wrong)


def refusals(c, scratch):
    for words, sentence in ((["own_bed", "--like", "first_bed", "--in", scratch], "is there"), (["other", "--like", "no_such_bed"], "cases/list"),
                            (["a/b", "--like", "first_bed"], "is no name"), (["round_bed", "--like", "first_bed", "--in", scratch], "is a case of")):
        done = say(os.path.join(CASES, "new"), *words)
        c.true(f"new {words[0]}: {done.stdout.strip()[-100:]}", done.returncode == 1 and sentence in done.stdout and "Traceback" not in done.stdout)
    for words, sentence in ((["no_such_bed"], "no case"), (["first_bed", "--shrot"], "--shrot"), (["first_bed", "--ranks"], "wants a value"), (["jetting_bed", "--slurm", "--out", "x"], "--slurm"),
                            (["first_bed", "--ranks", "0"], "--ranks 0"), (["first_bed", "--ranks", "two"], "--ranks two"), (["first_bed", "-var", "UU", "3"], "no choice UU"),
                            (["first_bed", "-var", "U", "0.4", "0.5"], "2 values"), (["first_bed", "-var", "U", "0.4", "--short"], "behind -var"), (["first_bed", "--compare", "--out", scratch], "holds no run")):
        done = say(os.path.join(CASES, "run"), *words)
        c.true(f"run {' '.join(words)}: {done.stdout.strip().splitlines()[0][:100]}", done.returncode == 2 and sentence in done.stdout)


def job(c, scratch, executable):
    tools = os.path.join(scratch, "tools")
    os.mkdir(tools)
    with open(os.path.join(tools, "sbatch"), "w") as f:
        f.write(SBATCH)
    os.chmod(os.path.join(tools, "sbatch"), 0o755)
    own = os.path.join(scratch, "own_bed")
    environment = {**os.environ, "TWOGRID_NO_PICTURES": "1", "TWOGRID": os.path.abspath(executable), "PATH": tools + ":" + os.environ["PATH"]}
    done = say(os.path.join(CASES, "run"), own, "--short", "--slurm", "--ranks", "1", "-var", "tend", "0.045", "-var", "settle", "2000", env=environment)
    out = os.path.join(own, "out", "job_7")
    with open(os.path.join(own, "bed_7.out"), errors="replace") as f:
        said = f.read()
    with open(os.path.join(own, "code")) as f:
        code = f.read().strip()
    if not c.true(f"the job ends with {code}: {done.stdout.strip()[:120]}", done.returncode == 0 and code == "0" and out in done.stdout):
        print(said[-3000:])
        c.end()
    with open(os.path.join(out, "verdict.txt")) as f:
        verdict = f.read()
    c.true(f"its verdict: {verdict.count('PASS')} PASS, {verdict.count('FAIL')} FAIL", verdict.count("PASS") >= 5 and "FAIL" not in verdict)
    with h5py.File(os.path.join(out, "own_bed.h5")) as f:
        end, ranks = f["fluid"][sorted(f["fluid"])[-1]]["time"][()], f["record"].attrs["ranks"][0]
    c.true(f"choices of the user come before those of --short: frames up to {end:.4f} s on {ranks} rank (wanted: 0.045 on 1)", abs(end - 0.045) < 2e-4 and ranks == 1)
    return out


def gallery(c, scratch):
    path = os.path.join(scratch, "gallery.html")
    done = say(os.path.join(CASES, "gallery.py"), os.path.join(scratch, "own_bed"), "--out", path)
    with open(path, encoding="utf-8") as f:
        text = f.read()
    part = text[text.find('<section id="own_bed">'):]
    c.true(f"{done.stdout.strip()}: {text.count('<section')} sections, the own case's with PASS, its movie and its report", done.returncode == 0 and
           text.count("<section") == 2 + len(re.findall(r'<section id="(?!top|own_bed)', text)) > 7 and "PASS" in part and "image/webp" in part and "own_bed/out/job_7/report.html" in part)


def two_of_a_name(c, scratch):
    """A case of one's own that has the name of one of the project's: a path is that path."""
    say(os.path.join(CASES, "new"), "first_bed", "--like", "first_bed", "--in", scratch)
    for name, of in (("./first_bed", os.path.join(scratch, "first_bed")), ("first_bed", os.path.join(CASES, "first_bed"))):
        done = say(os.path.join(CASES, "run"), name, "-var", "no_such_choice", "1", cwd=scratch)
        c.true(f"{name} where one stands is {of}", os.path.join(os.path.realpath(of), "in.first_bed") in done.stdout)


def ended_and_continued(c, scratch, executable):
    """A signal to cases/run reaches the program; what there is of the run is no verdict on it; --continue brings it to its end."""
    out, run = os.path.join(scratch, "ended"), os.path.join(CASES, "run")
    environment = {**os.environ, "TWOGRID_NO_REPORT": "1", "TWOGRID_NO_PICTURES": "1", "TWOGRID": os.path.abspath(executable)}
    words = ["--ranks", "1", "--out", out]
    choices = ["-var", "settle", "1000", "-var", "tavg", "0.005", "-var", "tend", "0.5"]
    process = subprocess.Popen([run, "first_bed", *words, *choices], env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    begin = time.time()
    while not os.path.exists(os.path.join(out, "first_bed.h5")) and process.poll() is None and time.time() - begin < 60:
        time.sleep(0.05)
    process.terminate()
    said, _ = process.communicate(timeout=60)
    c.true(f"a run that is ended: code {process.returncode}, {said.strip().splitlines()[-1][:80]}", process.returncode == 1 and "--continue" in said)
    compared = say(run, "first_bed", "--compare", "--out", out, env=environment)
    c.true(f"compared: {compared.stdout.splitlines()[0]}", compared.returncode == 1 and "has not come to its end" in compared.stdout)
    done = say(run, "first_bed", *words, "--continue", *choices, env=environment)
    c.true(f"continued: code {done.returncode}, {done.stdout.count('PASS')} PASS", done.returncode == 0 and done.stdout.count("PASS") >= 5 and os.path.exists(os.path.join(out, "log.liggghts.1")))
    with h5py.File(os.path.join(out, "first_bed.h5"), "r+") as f:
        last = f["particles"][sorted(f["particles"])[-1]]
        last["radius"][:] *= 1.2
    compared = say(run, "first_bed", "--compare", "--out", out, env=environment)
    c.true(f"other grains: {[line for line in compared.stdout.splitlines() if 'FAIL' in line]}", compared.returncode == 1 and "1.44" in compared.stdout and "compare.py" in compared.stdout)
    compared = say(run, "liquid_bed", "--compare", "--out", out, env=environment)
    c.true("the run of another case: a sentence", compared.returncode == 1 and "another case" in compared.stdout and "Traceback" not in compared.stdout)


def half_the_drag(c, scratch, out):
    with h5py.File(os.path.join(out, "own_bed.h5"), "r+") as f:
        for key in ("density", "viscosity"):
            f["record"].attrs[key] = 2 * f["record"].attrs[key]
    done = say(os.path.join(CASES, "run"), os.path.join(scratch, "own_bed"), "--short", "--compare", "--out", out, env={**os.environ, "TWOGRID_NO_REPORT": "1", "TWOGRID_NO_PICTURES": "1"})
    lines = [line for line in done.stdout.split("\n") if line.startswith("FAIL")]
    c.true(f"half the drag: {'; '.join(lines)}", done.returncode == 1 and len(lines) == 1 and "drag" in lines[0] and "0.5" in lines[0])


def main():
    executable, _ = arguments()
    c = Checks("cases of one's own")
    with tempfile.TemporaryDirectory(prefix="twogrid cases ") as scratch:  # a path with a space
        every_case_is_listed(c)
        copies_are_whole(c, scratch)
        done = say(os.path.join(CASES, "new"), "own_bed", "--like", "first_bed", "--in", scratch)
        if c.true(f"cases/new: {done.stdout.splitlines()[0] if done.stdout else ''}", done.returncode == 0):
            refusals(c, scratch)
            out = job(c, scratch, executable)
            two_of_a_name(c, scratch)
            ended_and_continued(c, scratch, executable)
            gallery(c, scratch)
            half_the_drag(c, scratch, out)
    c.end()


if __name__ == "__main__":
    main()
