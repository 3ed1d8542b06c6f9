"""config/README.md, written from the schemas."""

from dpd.scene.schema import schema

INTRODUCTION = """# Configuration

Written by `python -m dpd document -o config/README.md` from the files in `config/schema`;
edit those.

- `config.yaml` says which study of which papers `snakemake` builds.
- `papers/` holds one file a paper: its sweeps and its figures, at the paper's own sizes.
- `studies/` changes sampling, sizes and axes of those sweeps.
- `scenes/` holds systems to run alone: `python -m dpd run config/scenes/fluid.yaml -o run.nc`.

## To edit a sweep

Change the `values` of an axis in the paper's file or, if the study replaces them, in the study's.
`python -m dpd show STUDY PAPER SWEEP` says which file each value comes from, and `snakemake` says
it when you have edited, since the last commit, a value that its study replaces. Only new points are
run.

## To rename a sweep

The seeds of a sweep follow from its name, so a sweep with another name has other noise: all its
points run again. To keep the runs that you have:

1. rename it in the paper's file, in the `sweeps` of its figures, in every study that names it and
   in the figure files that read it, and give it its former name as `seeds: OLD_NAME`;
2. `mv results/STUDY/PAPER/runs/OLD_NAME results/STUDY/PAPER/runs/NEW_NAME`, for each study.

Then `snakemake` gathers the runs again and simulates nothing. It keeps no record of files that were
moved; if the sweep is edited later, runs that no longer belong to it are refused, with the command
that makes them again. Two sweeps of a paper must not have the same seeds.

## Whole molecules

A scene with a density gets the nearest whole number of molecules. If that misses the density by
more than 1 % the scene is refused, with a box and a count that fit.
"""
PARTS = ("config", "study", "paper", "scene")


def config_readme():
    """The page as Markdown."""
    parts = [INTRODUCTION]
    for name in PARTS:
        rules = schema(name)
        parts.append(f"## {rules['title']}\n\n{rules['description']}\n")
        parts.append("| key | allowed | default | meaning |\n| --- | --- | --- | --- |")
        parts[-1] += "".join(f"\n{line}" for line in _rows(rules, "")) + "\n"
    return "\n".join(parts)


def _rows(rules, prefix):
    """Table rows of an object's keys, parents before children."""
    lines = []
    required = rules.get("required", [])
    named = dict(rules.get("properties", {}))
    if isinstance(rules.get("additionalProperties"), dict):
        named["NAME"] = rules["additionalProperties"]
    for key, rule in named.items():
        path = f"{prefix}{key}"
        default = rule.get("default", "required" if key in required else "")
        default = "" if default in ({}, []) else default
        if "description" in rule:
            cells = (f"`{path}`", _allowed(rule), str(default), rule["description"])
            lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
        lines += _rows(rule, f"{path}.")
        items = rule.get("items", {})
        for branch in [items, *items.get("oneOf", [])]:
            lines += _rows(branch, f"{path}[].")
    return lines


def _allowed(rule):
    """What a value may be, in few words."""
    if "enum" in rule:
        return ", ".join(map(str, rule["enum"]))
    if "oneOf" in rule:
        return " or ".join(_allowed(branch) for branch in rule["oneOf"])
    kind = rule.get("type", "")
    kind = kind if isinstance(kind, str) else " or ".join(kind)
    kind = {"object": "mapping", "array": "list"}.get(kind, kind)
    limits = (("minimum", ">="), ("exclusiveMinimum", ">"), ("maximum", "<="))
    return kind + ",".join(f" {sign} {rule[key]:.12g}" for key, sign in limits if key in rule)
