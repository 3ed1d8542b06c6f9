"""The report: one self-contained page, of a study that is done or of one that still runs."""

import base64
import math
import os
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

import numpy as np
from markupsafe import Markup
from PIL import Image, ImageOps

from dpd import files
from dpd.files import replace_whole
from dpd.folders import ROOT, paper_folder
from dpd.pipeline.paper import Paper, read_paper
from dpd.pipeline.paths import Results, commit, library_versions
from dpd.report import rows as verdicts
from dpd.report.rows import LEADS, Row, count
from dpd.report.text import NUMBERED, label, named, rendered, span, typeset, whole

DATA_FILES = ("page.html", "parts.html", "page.css")  # read here: part of the report's digest
WIDE, THUMB = 1500, (260, 200)  # pixels of a picture of several panels, and of a thumbnail
COLOURS = 128  # of a picture in the page
LEAST, MOST = 0.5, 2.0  # ends of the axis of ours over published
BINS = np.arange(-6, 6.5, 0.5)  # of z
SHORTER = 0.999  # of a time: a number of steps is rounded when a duration becomes one
WITNESS = ROOT / "results" / "archive" / "witness.txt"  # see `benchmarks.witness`
TIMES = {"steps", "duration"}  # by which a paper says how long it sampled


def write_page(
    study: str, description: str, papers: Sequence[Paper], folder: str | Path, path: str | Path,
    archived: str | Path | None = None,
) -> None:  # fmt: skip
    """Write the report of a study, from its figures so far, beside verdicts of an archived one."""
    results = Results(str(folder))
    figures = [(paper.name, name) for paper in papers for name in paper.figures]
    made = [each for each in figures if os.path.isfile(results.figure(*each, "csv"))]
    done = len(made) == len(figures)
    rows = verdicts.verdict_rows(
        verdicts.read_rows(*(results.figure(*each, "csv") for each in made)),
        verdicts.read_rows(archived) if archived else (),
    )
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        there = {each: Path(results.figure(*each, "png")) for each in made}
        there = {each: path for each, path in there.items() if path.is_file()}
        pictures = dict(zip(there, pool.map(_picture, there.values())))
    at = Path(path).parent
    shown = [_paper(paper, study, results, rows, pictures, at, done) for paper in papers]
    kinds = {kind: [row for row in rows if row["kind"] == kind] for kind in verdicts.KINDS}
    page = rendered(
        "page.html", study=study, description=description, papers=shown,
        rows=sorted(rows, key=verdicts.worst_first),
        long_study=any(row["archived"] for row in rows),
        counts={kind: count(of) for kind, of in kinds.items()},
        witness=WITNESS.read_text().splitlines() if WITNESS.is_file() else [],
        glance=glance(kinds["simulated"], shown), versions=library_versions(), commit=commit(),
        made=datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
        progress={} if done else {
            "figures": len(made), "of": len(figures),
            "runs": sum(  # more are there after an edit, of former points
                min(runs, len([*Path(results.runs(paper.name, sweep)).glob("*/run.nc")]))
                for paper in papers for sweep, runs in paper.runs.items()
            ),
            "planned": sum(sum(paper.runs.values()) for paper in papers),
        },
    )  # fmt: skip
    replace_whole(path, lambda draft: draft.write_text(page, encoding="utf-8"))


def _paper(paper, study, results, rows, pictures, at, done):
    """A paper as the page shows it: sentences that hold in this study, and all of its figures."""
    sampled = {sweep for each in paper.sampling for sweep in each["sweeps"]}
    if done and sampled - paper.sweeps.keys():
        paper = replace(paper, sweeps=read_paper(paper.name, study, only=sampled).sweeps)
    cited = verdicts.citations().get(paper.title, {})
    cited = {"name": named(paper.name), "doi": "", "link": ""} | cited
    own = [row for row in rows if row["paper"] == paper.name]
    found = verdicts.by_name(paper.name, (row["entry"] for row in own))
    said = {each.key: each for each in verdicts.sentences(paper.name)}
    holds = {key for key, each in said.items() if each.holds(study, found)}
    figures = []
    for name in paper.figures:
        shown = [row for row in own if row["entry"]["figure"] == name]
        figure = _figure(paper.name, name, results, pictures.get((paper.name, name)), at)
        numbered, note = NUMBERED.match(name), said.get(name)
        topic = note.name if note else name[numbered.end() if numbered else 0 :].replace("_", " ")
        figures.append(figure | {
            "label": f"Fig. {numbered[1]}" if numbered else topic[:1].upper() + topic[1:],
            "topic": typeset(topic) if numbered else "",
            "says": typeset(note.text) if note else "",
            "ours": verdicts.with_values(note.ours, found) if name in holds else "",
            "rows": shown,
            "count": count(row for row in shown if row["kind"] == "simulated"),
            "others": count(row for row in shown if row["kind"] != "simulated"),
        })  # fmt: skip
        for row in shown:
            row["source"] = f"{cited['name']}, {figures[-1]['label']}"
    units = [row for row in own if row["kind"] == "simulated"]
    return cited | {
        "key": paper.name, "title": paper.title, "reference": paper.reference,
        "units": sorted(units, key=lambda row: "rdn".index(row["mark"])), "count": count(units),
        "figures": figures, "says": [
            (LEADS[key], key, verdicts.with_values(said[key].text, found))
            for key in LEADS if key in holds
        ],
        "checks": list(_checks(paper.name, results)) if done else [],
        "shorter": shorter_points(paper) if done else [],
        "not_said": [
            name for each in paper.sampling if not TIMES & each.keys() for name in each["sweeps"]
        ],
    }  # fmt: skip


def _figure(paper, name, results, picture, at):
    """A figure's picture, title and caption, and its files from where the page stands."""
    path = Path(results.figure(paper, name, "png"))
    title = picture["title"].removeprefix(f"{paper}, {label(name)}: ") if picture else ""
    caption = path.with_suffix(".html")
    kinds = {"PDF": ".pdf", "numbers (NetCDF)": ".nc", "verdicts (CSV)": ".csv"}
    files = {said: path.with_suffix(kind) for said, kind in kinds.items()} | {
        "scenes (YAML)": ROOT / "config" / "papers" / f"{paper}.yaml",
        "source (Python)": paper_folder(paper) / f"{name}.py",
    }
    return {
        "id": f"{paper}-{name}", "title": typeset(title.removesuffix(".")), "picture": picture,
        "caption": Markup(caption.read_text(encoding="utf-8")) if caption.is_file() else "",
        "target": os.path.relpath(path),
        "files": {
            said: os.path.relpath(file, at).replace(os.sep, "/")
            for said, file in files.items() if file.is_file()
        },
    }  # fmt: skip


def _picture(path):
    """A figure's picture and thumbnail as data, kept beside it, and what it says of itself."""
    small, thumb = (path.with_suffix(f".{kind}.webp") for kind in ("small", "thumb"))
    with Image.open(path) as image:
        if not thumb.is_file() or thumb.stat().st_mtime_ns < path.stat().st_mtime_ns:
            # The colours that cover most: the means of many would turn rare ones gray.
            few = image.convert("RGB").quantize(
                COLOURS, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE
            )
            # From the top left, where the first panel is: all of them could not be made out.
            panel = ImageOps.fit(image.convert("RGB"), THUMB, centering=(0, 0))
            for target, drawn, options in (
                (small, few.convert("RGB"), {"lossless": True}), (thumb, panel, {"quality": 65}),
            ):  # fmt: skip
                replace_whole(target, partial(drawn.save, format="webp", method=4, **options))
        src, thumb = (
            f"data:image/webp;base64,{base64.b64encode(each.read_bytes()).decode()}"
            for each in (small, thumb)
        )
        return {
            "title": image.info.get("Title", ""), "alt": image.info.get("Description", ""),
            "src": src, "thumb": thumb, "width": image.width, "height": image.height,
            "wide": image.width > WIDE,
        }  # fmt: skip


def glance(rows: Iterable[Row], papers: Sequence[Row]) -> Row:
    """All numbers in two plots, in per cent: ours over published, and z beside the normal law."""
    chosen = [r for r in rows if r["number"] is not None and r["mark"] != "n"]
    lanes, y = [], 16
    for paper in papers:
        own = [r for r in chosen if r["paper"] == paper["key"] and math.isfinite(r["ratio"])]
        lane = {"name": paper["name"], "top": y, "points": []}
        for row in sorted(own, key=lambda row: row["ratio"]):
            far = row["mark"] == "d" and abs(row["ratio"] - 1) > 0.1
            y += 5 * far
            low, high = (row["ratio"] + sign * row["ratio_error"] for sign in (-1, 1))
            lane["points"].append({
                "row": row, "y": y + 22, "far": far, "x": _on_axis(row["ratio"]),
                "x1": _on_axis(low), "x2": _on_axis(high),
            })  # fmt: skip
            y += 12 if far else 7
        if own:
            y += 28
            lanes.append(lane)
    decided = [row for row in chosen if math.isfinite(row["z"])]
    z = np.array([row["z"] for row in decided])
    r, d = (
        np.histogram(np.clip([row["z"] for row in decided if row["mark"] == mark], -6, 6), BINS)[0]
        for mark in "rd"
    )
    x = np.linspace(-6, 6, 121)
    normal = len(z) * 0.5 * np.exp(-(x**2) / 2) / np.sqrt(2 * np.pi)
    top = 1.08 * max(normal.max(), (r + d).max(), 1)
    points = [point for lane in lanes for point in lane["points"]]
    return {
        "lanes": lanes, "height": y, "bars": list(zip(r.tolist(), d.tolist())),
        "top": top, "points": len(points), "n": len(z),
        "ticks": [(t, _on_axis(t)) for t in (0.5, 0.7, 0.8, 0.9, 1, 1.1, 1.25, 1.5, 2)],
        "near": sum(abs(point["row"]["ratio"] - 1) < 0.05 for point in points),
        "curve": " ".join(f"{100 * (a + 6) / 12:.2f},{100 - 100 * n / top:.2f}"
                          for a, n in zip(x, normal)),
        "inside": [round(100 * float((abs(z) <= k).mean())) if len(z) else 0 for k in (1, 2)],
    }  # fmt: skip


def _on_axis(ratio):
    """Place of ours over published on a logarithmic axis, in per cent."""
    within = max(LEAST, min(MOST, ratio))
    return round(100 * math.log(within / LEAST) / math.log(MOST / LEAST), 2)


def _checks(name, results):
    """Temperature and momentum of the runs of each sweep, and how many and how long they are."""
    for path in sorted(Path(results.sweep(name, "sweep")).parent.glob("*.nc")):
        data, _ = files.read(path)
        if "kT" in data:  # it is simulated
            kT = f"{data['kT'].min():.4f} to {data['kT'].max():.4f}"
            beads, steps = (span(data[key], counted=False) for key in ("beads", "steps"))
            momentum = typeset(f"{data['momentum_per_bead'].max():.1e}")
            yield path.stem.replace("_", " "), data["kT"].size, beads, steps, kT, momentum


def shorter_points(paper: Paper) -> list[Row]:
    """Points sampled for less time, in tau, than in the paper, or in a smaller system, as text."""
    found = []
    for said in paper.sampling:
        for sweep in said["sweeps"] if TIMES & said.keys() else ():
            for name, scenes in _by_point(paper.sweeps[sweep], said.get("at", {})).items():
                scene = scenes[0]
                ours = sum(scene.steps.sample * scene.dt for scene in scenes)
                steps = said.get("steps", 0) * said.get("dt", scene.dt)  # ours where it gives none
                theirs = said.get("duration", steps) * said.get("runs", 1)
                system, smaller = _system(said, scene)
                if ours < SHORTER * theirs or smaller:
                    at_least = "≥ " if said.get("at_least") else ""
                    found.append({
                        "sweep": sweep, "point": name, "time": whole(ours),
                        "paper_time": at_least + whole(theirs), "share": f"{ours / theirs:.2g}",
                        "system": system, "where": typeset(said["where"]),
                    })  # fmt: skip
    return found


def _by_point(sweep, at):
    """Scenes of each point that has the labels asked for, by its name, its replicas together."""
    points = {}
    for point in sweep.points:
        place = {axis.name: value for axis, value in zip(sweep.axes[:-1], point.labels)}
        if all(place[axis] in labels for axis, labels in at.items()):
            name = ", ".join(f"{axis.replace('_', ' ')} {value}" for axis, value in place.items())
            points.setdefault(name, []).append(point.scene)
    return points


def _system(said, scene):
    """Our size and the paper's in words, and whether ours is smaller."""
    sizes = {"beads": scene.beads, "molecules": sum(kind.count for kind in scene.molecules)}
    for kind, ours in sizes.items():
        if kind in said:
            theirs = said[kind]
            return f"{ours} of {theirs} {kind}" if ours != theirs else "the same", ours < theirs
    return "not said", False
