"""What pages of the site are filled with: tables and examples out of the sources, and a gallery.

`python -m docs.site` runs the shipped scenes and keeps a picture of each, with how long it took.
"""

import argparse
import csv
import re
import time
from functools import cache
from pathlib import Path
from textwrap import fill
from typing import Any
from urllib.parse import unquote

import yaml
from PIL import Image

import dpd
from docs.pages import rendered, run_table
from dpd.analysis.verdicts import Entry
from dpd.commands.main import new_parser
from dpd.folders import PACKAGE, ROOT
from dpd.page import Observable, Term, find, names
from dpd.pipeline.paper import Config, PaperFile
from dpd.report import rows as verdicts
from dpd.report.keys import Row, rows_of, scene_rows, text_of
from dpd.report.text import with_error
from dpd.scene.scene import Scene
from dpd.scene.sections import Basics

FILLED = "reference/", "gallery", "index", "theory/claims"  # templates: names, or beginnings
GALLERY = Path(__file__).parent / "gallery"
TIMES = GALLERY / "times.csv"


def fill_page(app: Any, name: str, source: list[str]) -> None:
    """Fill a page that is a template, when Sphinx reads it."""
    if name.startswith(FILLED):
        source[0] = rendered(f"{name}.md", **values())


def check_links(folder: Path) -> None:
    """Refuse a page whose links to files of the site lead nowhere."""
    for page in folder.rglob("*.html"):
        for target in re.findall(r'(?:href|src)="(?!\w+:)([^"#?]+)', page.read_text()):
            if not (page.parent / unquote(target)).exists():
                raise SystemExit(f"{page}: there is no {target}")


@cache
def values() -> dict[str, Any]:
    """What templates may name."""
    from docs.papers import archived_counts

    sections = {"config": Config, "paper": PaperFile, "scene": Basics}
    keys = {name: rows_of(model, "") for name, model in sections.items()}
    return {
        "counts": archived_counts, "commands": commands(), "scenes": scenes(),
        "keys": keys | {"published": rows_of(Entry, "NAME.")}, "run": run_table(),
        "text": {name: text_of(model) for name, model in sections.items()},
        "chapters": chapters(), "ours": ours,
        "about": {key: text_of(find(Observable, key)) for key in names(Observable)},
    }  # fmt: skip


def ours(paper: str, name: str, times: float = 1) -> str:
    """Our value of a published number and its error, in the study of its page."""
    from docs.papers import rows_of

    row = verdicts.by_name(paper, [row["entry"] for row in rows_of(paper)])[name]
    return with_error(times * float(row["value"]), times * float(row["error"]))


def chapters() -> dict[str, dict[str, tuple[str, list[Row]]]]:
    """Keys of a scene by chapter and section, each with an example, if a scene has one."""
    found: dict[str, dict[str, tuple[str, list[Row]]]] = {}
    terms, shown = {*names(Term)}, examples()
    for row in scene_rows():
        top = row.key.removeprefix("observe[].").split(".")[0].removesuffix("[]")
        observed = row.key.startswith("observe[].")
        chapter = "Observables" if observed else "Forces and motion" if top in terms else "System"
        example = shown.get(top, f"observe: [{top}]" if observed else "")
        _, rows = found.setdefault(chapter, {}).setdefault(top, (example, []))
        rows.append(row)
    return found


def examples() -> dict[str, str]:
    """Sections of the shipped scenes, and what else papers have, as YAML."""
    shown: dict[str, str] = {}
    for path in [*sorted((PACKAGE / "scenes").glob("*.yaml")), ROOT / "docs" / "examples.yaml"]:
        scene = yaml.safe_load(path.read_text())
        observed = [each for each in scene.pop("observe", []) if isinstance(each, dict)]
        shown.setdefault("observe", "observe: [thermo, {rdf: {range: 2}}]")
        for key, value in scene.items():
            flow = None if isinstance(value, dict | list) else False
            text = yaml.safe_dump({key: value}, default_flow_style=flow, sort_keys=False, width=90)
            shown.setdefault(key, text.strip())
        for each in observed:
            text = yaml.safe_dump([each], default_flow_style=True, sort_keys=False, width=90)
            shown.setdefault(next(iter(each)), f"observe: {text.strip()}")
    return shown


def commands() -> list[tuple[str, str, str, list[tuple[str, str]]]]:
    """Commands, each with its usage, what it does, and its arguments."""
    parser = new_parser([])
    actions = next(each for each in parser._actions if isinstance(each, argparse._SubParsersAction))
    found = []
    for name, each in actions.choices.items():
        rows = [
            (", ".join(action.option_strings) or str(action.metavar or action.dest),
             (action.help or "") % {"default": action.default})
            for action in each._actions if action.dest != "help"
        ]  # fmt: skip
        usage = each.format_usage().partition(f" {name} ")[2].split()
        line = fill(" ".join(["dpd", name, *usage]), 90, subsequent_indent="    ")
        found.append((name, line, each.description or "", rows))
    return found


def scenes() -> list[dict[str, str]]:
    """The shipped scenes: name, what their comments say, text, and how long they take."""
    kept = {row["scene"]: row for row in csv.DictReader(TIMES.open())} if TIMES.is_file() else {}
    found = []
    for path in sorted((PACKAGE / "scenes").glob("*.yaml")):
        lines = path.read_text().splitlines()
        said = [line.removeprefix("# ") for line in lines if line.startswith("#")]
        row = {"name": path.stem, "title": said[0], "said": " ".join(" ".join(said[1:]).split())}
        found.append(row | {"text": "\n".join(lines[len(said) :])} | kept.get(path.stem, {}))
    return found


def write_gallery() -> None:
    """Run all scenes, draw each where it ends, and keep how long it took on one core."""
    GALLERY.mkdir(exist_ok=True)
    rows = []
    for path in sorted((PACKAGE / "scenes").glob("*.yaml")):
        scene, picture = Scene.read(path), GALLERY / f"{path.stem}.png"
        for _ in range(2):  # the first compiles kernels
            begun = time.perf_counter()
            run = dpd.run(scene, output=GALLERY / "run.nc", overwrite=True, progress=False)
            seconds = time.perf_counter() - begun
        dpd.draw(run, size=7).savefig(picture, dpi=110)
        with Image.open(picture) as image:
            image.convert("RGB").quantize(64).save(picture, optimize=True)
        rows.append((path.stem, scene.beads, sum(scene.steps), f"{seconds:.1f}"))
        for left in GALLERY.glob("run.*"):
            left.unlink()
    with TIMES.open("w", newline="") as file:
        csv.writer(file).writerows([("scene", "beads", "steps", "seconds"), *rows])


if __name__ == "__main__":
    write_gallery()
