"""Keywords of twogrid, and how choices are written."""
import os
import re

CASES = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
PAGE = os.path.join(CASES, "..", "liggghts_fixes", "script", "README.md")
OTHER_KEYS = {"timestep", "kn", "ranks", "method"}
NOT_CHOICES = {"boundary", "output", "model"}   # of fix_modify: they belong to the scene


class Wrong(Exception):
    """What the user has to change, in one sentence."""


def tables_of(page):
    """First words of the rows of each table of `twogrid -keywords`, or of the page of keywords, which holds the same tables (a test
    compares them): keywords of fix, of fix_modify, names of methods."""
    found, name = {}, None
    for line in page.split("\n"):
        begins = re.match(r"`(fix|fix_modify) ID .*keyword values|\| (method) \|", line)
        if begins:
            name = begins.group(1) or begins.group(2)
            found[name] = []
        row = re.match(r"\| `([^`]*)` \|", line)
        if row and name:
            found[name].append(row.group(1))
        elif line and line[0] not in "|`":
            name = None
    return found


def keywords():
    try:
        with open(PAGE) as f:
            tables = tables_of(f.read())
    except OSError as e:
        raise SystemExit(f"sweep.py: {PAGE} cannot be read ({e.strerror}); its tables hold the keywords")
    return set(tables["fix"]), set(tables["fix_modify"]) - NOT_CHOICES, tables["method"]


FIX_KEYS, MODIFY_KEYS, METHODS = keywords()


def text(value):
    """A choice's value as it stands in a script."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.10g}"
    if isinstance(value, (list, tuple)):
        return " ".join(text(v) for v in value)
    return str(value)


def number(value):
    try:
        return float(value) if not re.fullmatch(r"[+-]?\d+", str(value)) else int(value)
    except ValueError:
        return value


def key_of(name):
    """Choices may be written with _ for a blank (TOML's bare keys)."""
    blank = name.replace("_", " ")
    return blank if blank in MODIFY_KEYS else name
