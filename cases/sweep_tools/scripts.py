"""LIGGGHTS scripts: their commands, and choices written into them."""
from .keywords import FIX_KEYS, MODIFY_KEYS, Wrong


def logical_lines(script):
    """Commands of a script, lines joined where they end with &; each a list of its physical lines."""
    out, open_line = [], False
    for line in script.split("\n"):
        if open_line:
            out[-1].append(line)
        else:
            out.append([line])
        open_line = line.rstrip().endswith("&")
    return out


def words_of(lines):
    joined = " ".join(l.split("#")[0].rstrip().rstrip("&") for l in lines)
    return joined.split()


def script_variables(script):
    return {w[1] for w in map(words_of, logical_lines(script)) if len(w) > 2 and w[0] == "variable"}


def rewrite(script, choices, path):
    """The script with the choices written in; a Wrong if there is no place for one."""
    lines = logical_lines(script)
    fix = [i for i, l in enumerate(lines) if (w := words_of(l)) and len(w) > 3 and w[0] == "fix" and w[3] == "twogrid"]
    modify = {k: v for k, v in sorted(choices.items(), key=lambda c: c[0] != "method") if k in MODIFY_KEYS}
    if len(fix) != 1 and any(k in MODIFY_KEYS or k in FIX_KEYS for k in choices):
        raise Wrong(f"{path} has {len(fix)} lines 'fix ID group twogrid', one is wanted for choices of it")
    inserted = {}
    if fix:
        words = words_of(lines[fix[0]])
        for key in FIX_KEYS & set(choices):
            value = choices[key].split()
            if key in words[4:]:
                at = words.index(key, 4)
                end = next((i for i in range(at + 1, len(words)) if words[i] in FIX_KEYS), len(words))
                words[at + 1:end] = value
            else:
                words += [key] + value
        if FIX_KEYS & set(choices):
            lines[fix[0]] = [" ".join(words)]
        if modify:
            run = next((i for i in range(fix[0] + 1, len(lines)) if words_of(lines[i])[:1] in (["run"], ["rerun"])), None)
            if run is None:
                raise Wrong(f"{path} has no 'run' after its fix twogrid")
            inserted[run] = [f"fix_modify {words[1]} {k} {v}" for k, v in modify.items()]
    for key, test in (("timestep", lambda w: w[:1] == ["timestep"]),
                      ("kn", lambda w: w[:1] == ["fix"] and w[3:5] == ["property/global", "kn"])):
        if key not in choices:
            continue
        found = [i for i, l in enumerate(lines) if test(words_of(l))]
        if not found:
            raise Wrong(f"{path} has no line that sets {key}")
        for i in found:
            w = words_of(lines[i])
            if key == "timestep":
                w[1] = choices[key]
            else:
                first = 7 if w[5] == "peratomtypepair" else 6
                w[first:] = [choices[key]] * (len(w) - first)
            lines[i] = [" ".join(w)]
    return "\n".join("\n".join(inserted.get(i, []) + l) for i, l in enumerate(lines))
