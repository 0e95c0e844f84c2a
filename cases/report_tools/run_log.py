"""What a run's log tells: its scene reports, the fluid's time at DEM steps, shares of CPU time."""
import re


def seconds(text):
    """of 3 h 2 min 4.5 s"""
    return sum(float(n) * {"d": 86400, "h": 3600, "min": 60, "s": 1}[u] for n, u in re.findall(r"([\d.]+) (d|h|min|s)\b", text))


def scenes(log):
    """Scene reports in the log: the fix, pairs of what and value, warnings."""
    found, at = [], None
    for line in log.split("\n"):
        match = re.match(r"twogrid: the scene of fix (\S+)", line)
        if match:
            at = dict(fix=match.group(1), pairs=[], warnings=[])
            found.append(at)
        elif at and line.startswith("  WARNING: "):
            at["warnings"].append(line[11:])
        elif at and re.match(r"  \S", line):
            words = re.split(r"\s{2,}", line.strip(), maxsplit=1)
            at["pairs"].append((words[0], words[1]) if len(words) == 2 else (line[2:24].strip(), line[24:].strip()))
        else:
            at = None
    return found


def clock(log):
    """(DEM step, fluid's time in s) where LIGGGHTS' tables of the last scene have rows, and one step on: between them the time step doesn't change. It is told by
    the script, where the log repeats that, and by the scene report. The fluid begins at 0 with a scene's first table, or goes on from a checkpoint's time."""
    pairs, dt, begin, in_table, scene = [], None, None, False, False
    for line in log.split("\n"):
        told = re.match(r"(?:timestep|  DEM step)\s+([\d.eE+-]+)(?= s,|\s*(?:#|$))", line)
        on = re.match(r"twogrid: the fluid goes on from .*, t = (\S+) s$", line)
        words = line.split()
        if told:
            dt = float(told.group(1))
        elif line.startswith("twogrid: the scene of fix"):
            scene, begin = True, 0.0
        elif on:
            begin = float(on.group(1))
        elif words[:1] == ["Step"]:
            in_table = scene and dt is not None
        elif line.startswith("Loop time"):
            in_table = False
        elif in_table and re.fullmatch(r" +\d+( +[-+.\w]+)* *", line):
            step = int(words[0])
            if begin is not None:
                pairs = [p for p in pairs if begin > 0 and p[0] < step] + [(step, begin)]
                begin = None
            elif step > pairs[-1][0]:
                pairs.append((step, pairs[-1][1] + (step - pairs[-1][0]) * dt))
    return pairs + [(pairs[-1][0] + 1, pairs[-1][1] + dt)] if pairs else []
