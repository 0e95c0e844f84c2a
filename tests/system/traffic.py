#!/usr/bin/python3
"""What the coupling sends between four ranks, counted by tests/bench/mpi_count: the paper's claim that the two-grid method needs less
than exact intersection and porous cube on the fine grid.

Without this test a coupling that moves whole fields, or more with every release, would pass: results stay the same.
Wanted: bytes and messages a rank and coupling no more than a tenth above those of cases/studies/traffic/table.csv; a tenth
of the bytes of exact intersection, a thirtieth of the porous cube's.
Usage: traffic.py EXECUTABLE MPI_COUNT_LIBRARY
"""
import csv
import os
import sys

from harness import Checks

STUDY = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "cases", "studies", "traffic")
sys.path.insert(0, STUDY)
import traffic  # noqa: E402

RANKS = 4


def main():
    executable, library = (os.path.abspath(a) for a in sys.argv[1:3])
    with open(os.path.join(STUDY, "table.csv")) as f:
        table = {r["method"]: r for r in csv.DictReader(f) if int(r["ranks"]) == RANKS}
    c = Checks("messages between ranks")
    symbols = traffic.Symbols(executable)
    sent = {}
    for method in ("two-grid, centroid (the paper)", "exact on the fine grid", "porous cube of 4 d"):
        counts, _ = traffic.measure(executable, library, RANKS, method, traffic.SHORT, symbols)
        messages, sent[method] = counts["coupling"].mean(axis=0)[:2] / (traffic.SHORT / traffic.EVERY)
        c.true(f"{method}: something was counted", messages > 0 and counts["fluid"].sum() > 0 and counts["dem"].sum() > 0)
        c.below(f"{method}: messages over the table's", messages / float(table[method]["coupling_messages"]), 1.1)
        c.below(f"{method}: bytes over the table's", sent[method] / float(table[method]["coupling_bytes"]), 1.1)
    two_grid, exact, cube = sent.values()
    c.below("bytes, two-grid over exact", two_grid / exact, 0.1)
    c.below("bytes, two-grid over porous cube", two_grid / cube, 1 / 30)
    c.end()


if __name__ == "__main__":
    main()
