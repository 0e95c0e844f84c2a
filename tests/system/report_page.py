#!/usr/bin/python3
"""cases/report.py: the page of a whole run, of a log alone, of a damaged and a bare output file; in headless Chromium where there is one.

Without this test a page could lack a section in silence, show broken or empty pictures, want the network, be wider than a phone, say PASS for
a check that failed, draw a wrong frequency or a wrong share of the cost, or not come about at all for a run that was killed. Wanted values:
what the run's own files say, and a sine of known frequency. Without Chromium (tests/run.sh installs it) the page is read by Python's parser only.

    report_page.py EXECUTABLE RANKS
"""
import base64
import html.parser
import io
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import types

import h5py
import numpy as np
from PIL import Image

import browser
from harness import Checks, arguments

CASES = os.path.abspath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "cases"))
sys.path.insert(0, CASES)
import report  # noqa: E402
import verdict  # noqa: E402
from report_tools import figures, run_log, sections  # noqa: E402
from report_tools.run_folder import RunFolder  # noqa: E402

SECTIONS = ["head", "verdict", "movie", "setup", "compared", "fields", "profiles", "pressure", "ledger", "cost", "not-modelled", "scene", "origin"]


class Page(html.parser.HTMLParser):
    """Text and pictures of each section, and all that the page would fetch."""

    def __init__(self, path):
        super().__init__()
        self.sections, self.at, self.pictures, self.fetched, self.open = {}, None, {}, [], []
        with open(path, encoding="utf-8") as f:
            self.raw = f.read()
        self.feed(self.raw)

    def handle_starttag(self, tag, attributes):
        a = dict(attributes)
        if tag == "section":
            self.at = a["id"]
            self.sections[self.at], self.pictures[self.at] = "", []
        if tag == "img":
            self.pictures[self.at].append(a["src"])
        self.fetched += [v for k, v in attributes if k in ("src", "href", "srcset") and not v.startswith(("data:", "#"))]
        if tag not in ("img", "br", "meta", "link"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        if not self.open or self.open.pop() != tag:
            self.fetched.append(f"</{tag}> out of place")

    def handle_data(self, data):
        if self.at:
            self.sections[self.at] += data + " "


def page_of(folder, *only):
    """As report.py makes it, perhaps some of its sections only; what could not be drawn is a failure."""
    run, all_of_them = RunFolder(folder), report.SECTIONS
    report.SECTIONS = [s for s in all_of_them if not only or s[0] in only]
    text, failed = report.report(run)
    report.SECTIONS = all_of_them
    path = os.path.join(folder, "report.html")
    with open(path, "w", encoding="utf-8") as f:
        f.write(text)
    return Page(path), failed


def log_of(folder):
    with open(os.path.join(folder, "log.liggghts"), errors="replace") as f:
        return f.read()


def whole_run(c, executable, out):
    done = subprocess.run([os.path.join(CASES, "run"), "first_bed", "--short", "--ranks", "1", "--out", out, "-var", "settle", "1500", "-var", "tend", "0.045", "-var", "tavg", "0.02"], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, errors="replace", env={**os.environ, "TWOGRID": os.path.abspath(executable), "TWOGRID_NO_PICTURES": "1"}, timeout=100)
    last = done.stdout.strip().split("\n")[-1]
    if not c.true(f"a case's run ends with {last}", done.returncode == 0 and last == f"report: {os.path.join(out, 'report.html')}"):
        print(done.stdout[-3000:])
        c.end()
    page = Page(os.path.join(out, "report.html"))
    c.true(f"sections: {len(page.sections)}, tags closed, nothing is fetched {page.fetched[:3]}", list(page.sections) == SECTIONS and not page.fetched and not page.open and "<script" not in page.raw)
    pictures = {s: [Image.open(io.BytesIO(base64.b64decode(p.split(",")[1]))) for p in v] for s, v in page.pictures.items()}
    c.true("pictures: " + ", ".join(f"{s} {len(v)}" for s, v in pictures.items() if v), [len(pictures[s]) for s in ("movie", "setup", "fields", "profiles", "pressure")] == [1, 1, 3, 3, 2])
    c.true("none is of one colour", all(np.ptp(np.asarray(p.convert("L"))) > 100 for v in pictures.values() for p in v))
    film = pictures["movie"][0]
    frames = []
    for i in range(getattr(film, "n_frames", 1)):
        film.seek(i)
        frames.append(np.asarray(film.convert("L"), dtype=float))
    moved = [np.mean(np.abs(b - a) > 40) for a, b in zip(frames, frames[1:])]
    c.true(f"the movie has {len(frames)} frames (wanted: 4), pixels that change {', '.join(f'{100 * m:.1f}' for m in moved)} %", len(frames) == 4 and min(moved) > 0.005)
    with open(os.path.join(out, "verdict.txt")) as f:
        passed = f.read().count("PASS")
    c.true(f"verdict: {passed} times PASS, as in verdict.txt", page.sections["verdict"].count("PASS") == passed >= 5)
    share = re.search(r"shares of CPU time: DEM ([\d.]+) %", log_of(out)).group(1)
    c.true(f"cost: DEM {share} %, as in the log", re.search(rf"DEM +{share} %", page.sections["cost"]))
    c.true("nothing that doesn't belong together", 'class="failed"' not in page.raw)
    c.true("what was not modelled", "turbulence" in page.sections["not-modelled"] and "particle cells" in page.sections["not-modelled"])
    with open(os.path.join(out, "status.json")) as f:
        book = json.load(f)["ledger"]
    c.true("ledger, as in status.json", f"{book['continuity_error']:.2g}" in page.sections["ledger"])
    return page


def frequency_and_failure(c, run, scratch):
    """A sine of 80 Hz in place of the pressure, a check that failed, a run that is said to have ended in an error."""
    other = os.path.join(scratch, "other")
    shutil.copytree(run, other)
    path = os.path.join(other, "pressure.txt")
    table = np.loadtxt(path)
    t = (table[:, 0] - table[0, 0]) * 1.5e-5
    with open(path, "w") as f:
        f.write("# Time-averaged data for fix drop\n# TimeStep f_gas[4]\n")
        f.writelines(f"{s:.0f} {100 + 7 * np.sin(2 * np.pi * 160 * x):.9g}\n" for s, x in zip(table[:, 0], t))
    with open(os.path.join(other, "verdict.txt"), "a") as f:
        f.write("FAIL  a thing: 3 <b> & 4 (wanted 5)\n")
    with open(os.path.join(other, "status.json")) as f:
        status = json.load(f)
    status.update(state="error", error="a sentence of the program")
    with open(os.path.join(other, "status.json"), "w") as f:
        json.dump(status, f)
    page, _ = page_of(other, "head", "verdict", "pressure")
    found = re.findall(r"resolution ([\d.]+) Hz", page.sections["pressure"])
    c.true(f"of a failed run: its sentence, its verdict; {found}", "a sentence of the program" in page.sections["head"] and "3 <b> & 4" in page.sections["verdict"] and
           page.sections["verdict"].count("FAIL") == 1)
    f, power, _ = figures.spectrum(100 + 7 * np.sin(2 * np.pi * 160 * 7.5e-4 * np.arange(600)), 7.5e-4)
    c.below("spectrum of a sine of 160 Hz: its frequency, in resolutions", abs(f[np.argmax(power)] - 160) / f[0], 1)
    c.below("its power against 7^2/2, relative", abs(np.sum(power) * f[0] / 24.5 - 1), 0.05)


def changed_time_step(c, run, scratch):
    """The fluid's time at DEM steps: of frames after whose second the time step is halved; of a log with a change, a comment and what a run repeats that goes on from a checkpoint."""
    folder = os.path.join(scratch, "halved")
    shutil.copytree(run, folder)
    with h5py.File(os.path.join(folder, "first_bed.h5"), "r+") as f:
        del f["average"]
        frames = [f["fluid"][n] for n in sorted(f["fluid"])]
        begin, middle = frames[0]["step"][()], frames[1]["step"][()]
        at = frames[1]["time"][()]
        for frame in frames[2:]:
            frame["time"][()] = at + 0.75e-5 * (frame["step"][()] - middle)
    steps = np.array([begin, middle, middle + 1000, middle + 2500])
    wanted = 1.5e-5 * (steps - begin) - 0.75e-5 * np.maximum(steps - middle, 0)
    c.below("time at steps before and after the time step is halved, by the frames, s", np.abs(RunFolder(folder).time_of(steps) - wanted).max(), 1e-9)
    text = page_of(folder, "pressure")[0].sections["pressure"]
    c.true(f"the spectrum is of the rows at equal distances alone: {re.findall('Spectrum from .*?,', text)}", "51 points of 60" in text)
    log = log_of(run)
    scene = log.index("twogrid: the scene of fix")
    report = log[scene:log.index("Setting up run", scene)]
    table = lambda *steps: "    Step   gas[4] \n" + "".join(f"{s:8.0f}   7.5e1 \n" for s in steps) + "Loop time of 1\n"
    halved = report + table(begin, middle) + "timestep  0.75e-5 # half\n" + table(middle, middle + 2000)
    with open(os.path.join(folder, "log.liggghts"), "w") as f:
        f.write("LIGGGHTS (Version x)\n" + halved)
    os.remove(os.path.join(folder, "first_bed.h5"))
    c.below("by the log", np.abs(RunFolder(folder).time_of(steps) - wanted).max(), 1e-9)
    went_on = report + "twogrid: the fluid goes on from x/gas.h5, t = 0.3 s\n" + table(begin, middle)
    c.below("of a log that goes on at 0.3 s", np.abs(np.array(run_log.clock(went_on))[:, 1] - 0.3 - 1.5e-5 * np.array([0, middle - begin, middle - begin + 1])).max(), 1e-9)


def rows_of_means(c, run, scratch):
    """The mean pressure drop is of the rows that cases/verdict.py takes: the one that ends where the means begin is not among them. Too few of them give no spectrum."""
    folder = os.path.join(scratch, "rows")
    shutil.copytree(run, folder)
    steps = np.loadtxt(os.path.join(folder, "pressure.txt"))[:, 0]
    begin = float(RunFolder(folder).time_of(steps[-31]))
    with h5py.File(os.path.join(folder, "first_bed.h5"), "r+") as f:
        f["average"].attrs["from"] = begin
    r = RunFolder(folder)
    bed = types.SimpleNamespace(step=1.5e-5, begin=begin + 1.5e-5 * float(r.clock[0, 0]))  # its steps count from the fluid's first
    c.true(f"rows of the means: {r.averaged(steps).sum()} (wanted: 30)", r.averaged(steps).sum() == 30 and np.array_equal(r.averaged(steps), verdict.Bed.averaged(bed, steps[:, None])))
    page, _ = page_of(folder, "pressure")
    c.true("no spectrum of so few", len(page.pictures["pressure"]) == 1 and "there are 30 after the means begin" in page.sections["pressure"])


def two_runs(c, run, scratch):
    """A run with gravity along y and a log of another name, whose path has blanks, beside what a failed one has left; an output file older than the log; one whose log is gone."""
    folder = os.path.join(scratch, "two")
    shutil.copytree(run, folder)
    at = lambda name: os.path.join(folder, name)
    with open(at("log.of mine"), "w") as f:
        f.write(log_of(folder).replace("0 0 -9.81 m/s2", "0 -9.81 0 m/s2"))
    os.rename(at("status.json"), at("of mine.status.json"))
    with open(at("of mine.status.json")) as f:
        status = json.load(f)
    with open(at("log.liggghts"), "w") as f:
        f.write("LIGGGHTS (Version x)\nERROR: another run\n")
    with open(at("status.json"), "w") as f:
        json.dump(dict(status, state="error", error="another run", started="2100-01-01T00:00:00Z", date="2100-01-01T00:00:01Z"), f)
    with h5py.File(at("first_bed.h5"), "r+") as f:
        f["record"].attrs["command_line"] = "twogrid -in /own cases/in.Bett größe -log log.of mine -var out . "
    page, failed = page_of(folder, "head", "fields", "scene", "cost")
    c.true(f"a log of another name {failed}", "finished" in page.sections["head"] and "another run" not in page.sections["head"] and "Ergun" in page.sections["scene"] and "DEM" in page.sections["cost"])
    c.true("gravity along y: that z is taken as up", "gravity is 0 -9.81 0 m/s2" in page.sections["fields"])
    c.true("the title is the script's name, with its blank", "<h1>in.Bett größe</h1>" in page.raw)
    os.remove(at("log.of mine"))
    page, _ = page_of(folder, "head")
    c.true("its log gone", "log.of mine, is not here" in page.sections["head"] and "of one run, scene, ledger and cost of another" in page.sections["head"])


def curves(c):
    """How far a curve is from what it is compared with: a line and measured points that reach beyond the run, a run of one point, one that shares no range."""
    line, points = dict(label="line", x=[4, 2, 0], y=[8, 4, 0], line=True), dict(label="points", x=[-5, 0.5, 1, 9], y=[50, 1.5, 2.5, 50])
    for what, x, wanted_line, wanted_points in (("a curve that the line covers in part", [0, 1, 2, 9], [1, 1, 1], [0.5, 0.5, -31]), ("the same backwards", [9, 2, 1, 0], [1, 1, 1], [0.5, 0.5, -31]),
                                                ("one point", [1], [1], [0.5]), ("one beyond", [20], [], [])):
        mean = [2 * v + 1 for v in x]
        off = [sections.differences(dict(x=x, mean=mean), r) for r in (line, points)]
        c.true(f"{what}: off the line by {off[0][0]}, off points by {off[1][0]}, left out {off[0][2]} and {off[1][2]}", all(
            len(o[0]) == len(w) and np.allclose(np.sort(o[0]), np.sort(w)) and o[2] == n - len(w) for o, w, n in zip(off, (wanted_line, wanted_points), (len(x), 4))))
        text = sections.curve(dict(title="t", x_label="x", y_label="y / (m/s)", x=x, mean=mean, error=None, references=[line]))
        c.true("and it is said", ("no difference" in text) if not wanted_line else f"difference {wanted_line[0]:g} m/s" in text and ("left out" in text) == (len(x) > len(wanted_line)))


def little(c, run, scratch):
    """A log alone; an output file cut in two; one without frames or means; nothing."""
    folder = os.path.join(scratch, "log only")
    os.mkdir(folder)
    shutil.copy(os.path.join(run, "log.liggghts"), os.path.join(folder, "log.of_a_run"))
    page, failed = page_of(folder)
    texts = page.sections
    c.true(f"a log alone {failed}", not failed and list(texts) == SECTIONS and all("No " in texts[s] for s in ("verdict", "movie", "setup", "fields", "profiles")) and
           "Ergun" in texts["scene"] and "DEM" in texts["cost"] and "turbulence" in texts["not-modelled"] and len(page.pictures["pressure"]) == 1)
    log = re.sub(r"(?ms)^fix +gas all twogrid.*?^Setting up", "Setting up", log_of(run))  # as of particles alone
    with open(os.path.join(folder, "log.of_a_run"), "w") as f:
        f.write(log[:log.index("twogrid: run of")] + "Loop time of 1 on 1 procs for 1 steps with 1234 atoms\n")
    texts = page_of(folder)[0].sections
    c.true("particles alone: their number, and that there is no fix twogrid", re.search(r"1.234 +grains", texts["head"]) and all("no fix twogrid" in texts[s] for s in ("scene", "cost", "pressure")))
    shutil.copy(os.path.join(run, "log.liggghts"), os.path.join(folder, "log.of_a_run"))
    os.rename(os.path.join(folder, "log.of_a_run"), os.path.join(folder, "log.of_a_run.1"))
    with open(os.path.join(folder, "log.of_a_run"), "w") as f:
        f.write("LIGGGHTS (Version x)\ntwogrid: goes on from the checkpoint y\n" + log_of(run))
    c.true("of two legs", "of 2 of 2 legs" in page_of(folder, "cost")[0].sections["cost"] and RunFolder(folder).costs()[1] > 1.9 * RunFolder(run).costs()[1])
    os.remove(os.path.join(folder, "log.of_a_run.1"))
    with open(os.path.join(run, "first_bed.h5"), "rb") as f:
        data = f.read()
    for name, part in (("cut in two", data[:len(data) // 2]), ("empty", b"")):
        with open(os.path.join(folder, "first_bed.h5"), "wb") as f:
            f.write(part)
        page, failed = page_of(folder)
        c.true(f"an output file that is {name} {failed}", not failed and ("can't be read" in page.sections["head"]) and "turbulence" in page.sections["not-modelled"])
    os.remove(os.path.join(folder, "first_bed.h5"))
    for what in (["average", "particles"], ["fluid", "particles", "average"]):
        shutil.copy(os.path.join(run, "first_bed.h5"), os.path.join(folder, "first_bed.h5"))
        with h5py.File(os.path.join(folder, "first_bed.h5"), "r+") as f:
            for group in what:
                del f[group]
        page, failed = page_of(folder)
        c.true(f"without {', '.join(what)} {failed}: {len(page.pictures['setup'])} picture of the set-up", not failed and len(page.pictures["setup"]) == 1)
        os.remove(os.path.join(folder, "first_bed.h5"))
    os.remove(os.path.join(folder, "log.of_a_run"))
    done = subprocess.run([os.path.join(CASES, "report.py"), folder], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=100)
    c.true(f"nothing: {done.stdout.strip()}", done.returncode == 1 and "neither a log nor an output file" in done.stdout and "Traceback" not in done.stdout)


def can_t_be_written(c, run, scratch):
    """A sentence, no traceback, where the page's place is taken by a folder or its folder isn't there."""
    folder = os.path.join(scratch, "taken")
    shutil.copytree(run, folder)
    os.remove(os.path.join(folder, "first_bed.h5"))
    os.remove(os.path.join(folder, "report.html"))
    os.mkdir(os.path.join(folder, "report.html"))
    for out in ([], ["--out", os.path.join(scratch, "no such folder", "a.html")]):
        done = subprocess.run([os.path.join(CASES, "report.py"), folder, *out], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=100)
        c.true(f"can't be written: {done.stdout.strip()}", done.returncode == 1 and done.stdout.startswith("report: ") and "--out" in done.stdout and "Traceback" not in done.stdout)


def in_browser(c, pages):
    if not browser.program():
        c.note("no Chromium here: not looked at in one")
        return
    with browser.Browser() as b:
        for path in pages:
            for width, height in ((390, 844), (1280, 900))[:2 if path == pages[0] else 1]:
                said, asked = b.open(path, width, height)
                wide = b.evaluate("document.documentElement.scrollWidth")
                broken = b.evaluate("[...document.images].filter(i => !(i.complete && i.naturalWidth > 0 && i.getBoundingClientRect().width > 50)).length")
                n = b.evaluate("document.images.length")
                small = b.evaluate("[...document.querySelectorAll('p,td,th,li,figcaption,span,b')].filter(e => parseFloat(getComputedStyle(e).fontSize) < 12).length")
                c.true(f"{os.path.basename(os.path.dirname(path))} at {width} pixels: {n} pictures, {broken} broken, {wide} wide, {small} texts below 12 pixels, console {said}, network {asked}",
                       wide <= width and broken == 0 and small == 0 and not said and not asked)


def main():
    executable, _ = arguments()
    c = Checks("the report of a run")
    with tempfile.TemporaryDirectory(prefix="twogrid_report_") as scratch:
        run = os.path.join(scratch, "run")
        whole_run(c, executable, run)
        frequency_and_failure(c, run, scratch)
        two_runs(c, run, scratch)
        rows_of_means(c, run, scratch)
        curves(c)
        changed_time_step(c, run, scratch)
        little_page = os.path.join(scratch, "log only", "report.html")
        little(c, run, scratch)
        can_t_be_written(c, run, scratch)
        in_browser(c, [os.path.join(run, "report.html"), os.path.join(scratch, "other", "report.html"), little_page])
    c.end()


if __name__ == "__main__":
    main()
