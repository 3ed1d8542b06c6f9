"""All pages of the repository that are written by a program, wholly or in part."""

import math
import re
from contextlib import suppress
from functools import cache, partial
from html import escape
from pathlib import Path

from dpd.analysis.verdicts import AGREE
from dpd.digests import calculations_file
from dpd.errors import UserError
from dpd.folders import ROOT
from dpd.observe.common.measured import observables
from dpd.page import Observable, find, names
from dpd.page.own import calculations_of
from dpd.pipeline.jobs import PER_JOB, plan
from dpd.pipeline.paper import (
    check_repository,
    read_config,
    read_paper,
    read_study,
)
from dpd.pipeline.paths import LONG_STUDY
from dpd.report import archive
from dpd.report import rows as verdicts
from dpd.report.figures import load_module
from dpd.report.keys import section_rows
from dpd.report.rows import Row
from dpd.report.text import label, typeset
from dpd.report.text import rendered as rendered_from
from dpd.scene.scene import Scene
from dpd.start.common.make import system_of

rendered = partial(rendered_from, folder=Path(__file__).parent)
TIME = re.compile(r"(<!-- time: (\S+) -->).*?(<!-- end -->)")
ARCHIVED = "quick"  # study whose time is recorded
BLOCK = re.compile(r"(<!-- begin: (\S+) counts -->\n).*?(<!-- end -->)", re.S)
FLUID = {
    "dimension": 3, "box": 6, "molecules": [{"architecture": "A 2 B 2", "count": 162}],
    "repulsion": {"A A": 25, "A B": 30, "B B": 25}, "bond": {"stiffness": 50, "length": 0.5},
    "integrator": {"scheme": "gw-vv", "dt": 0.01}, "steps": {"sample": 1000},
}  # fmt: skip
PLANE = FLUID | {"dimension": 2, "box": 18}
WALLED = FLUID | {"walls": {"axis": "y", "repulsion": 25}}
# What changes in a scene, in an observable there, and how to say so where it then has more.
SCENES: tuple[tuple[dict, dict, str], ...] = (
    ({}, {}, ""),
    ({"shear": {"rate": 0.1}}, {}, ", under shear"),
    ({"walls": WALLED["walls"]}, {}, ", between walls"),
    ({"pressure": {"target": 1}}, {}, ", at constant pressure"),
)


def pages() -> dict[Path, str]:
    """Path to text of every such page, as it should be now."""
    check_repository()
    readme = ROOT / "README.md"
    papers = sorted({row["paper"] for study in archive.studies() for row in rows_of_archive(study)})
    return {
        readme: filled(TIME.sub(_timed, readme.read_text())),
        **{archive.FIGURES / name / "README.md": paper_page(name) for name in papers},
    }


def write_pages() -> list[Path]:
    """Write the pages that are not as they should be, and say which."""
    return archive.write_changed(ROOT, {str(path): text.encode() for path, text in pages().items()})


def filled(text: str) -> str:
    """A text with the blocks that `BLOCK` finds made anew, from verdicts that git keeps."""
    link = "[{0}](paper_figures/{0}/README.md)"

    def made(block):
        tables = [rows_of_archive(study) for study in block[2].split("+")]
        return f"{block[1]}{rendered('counts.md.j2', tables=tables, link=link)}{block[3]}"

    return BLOCK.sub(made, text)


def _timed(found):
    """How long a study takes on two cores, by the record of the archived one, if there is one."""
    known, study = archive.manifest_of(ARCHIVED).get("minutes"), found[2]
    if known is None:
        return found[0]
    (work, jobs), (asked, others) = _asked(ARCHIVED), _asked(study)
    minutes = (asked * (known * 120 - jobs * PER_JOB) / work + others * PER_JOB) / 120
    said = f"{minutes:.0f} minutes" if minutes < 120 else f"{minutes / 60:.0f} hours"
    return f"{found[1]}{said}{found[3]}"


@cache
def _asked(study):
    """Bead-steps and jobs of all papers."""
    config = read_config({"study": study})
    papers = [read_paper(name, study) for name in config["papers"]]
    rows = plan(papers, study, config["batch"])
    work = sum(3600 * row["core_hours"] * row["rate"] for row in rows)
    return work, sum(row["jobs"] for row in rows)


def paper_page(name: str) -> str:
    """The page of a paper; `UserError` if CITATION.cff does not know it, or without findings."""
    tables = {}
    for study in archive.studies():
        if own := [row for row in rows_of_archive(study) if row["paper"] == name]:
            tables[study] = own
    paper = read_paper(name, next(iter(tables)), only=[])
    findings = archive.FIGURES / name / "findings.md"
    if not findings.is_file():
        raise UserError(f"{findings}: missing; write what runs show, and why what deviates does")
    if paper.title not in verdicts.citations():
        raise UserError(f"CITATION.cff: references: none has the title {paper.title!r} of a paper")
    link, doi = (verdicts.citations()[paper.title][key] for key in ("link", "doi"))
    known = calculations_of(name) if calculations_file(name).is_file() else {}
    rows = [row for key, each in known.items() for row in section_rows(each, key, "")]
    return rendered(
        "paper.md.j2", keys=rows, name=name, title=paper.title, reference=paper.reference,
        doi=f", [doi:{doi}]({link})" if doi else "",
        findings=_found(name, findings, tables).partition("### Figures"),
        first=next(iter(known), ""),
        studies=[
            (study, read_study(study).description, table, _missing(study, paper))
            for study, table in tables.items()
        ],
        long_study=LONG_STUDY, still_open=_open_rows(paper, tables.get(LONG_STUDY, ())),
        pictures=[(p.stem, load_module(name, p.stem)) for p in archive.pictures(name)],
    )  # fmt: skip


def _missing(study, paper):
    """Figures that the archive of a study lacks, which was stopped before its end."""
    drawn = archive.manifest_of(study).get("figures")
    return [each for each in paper.figures if drawn and f"{paper.name}/{each}" not in drawn]


def _open_rows(paper, rows):
    """Rows that the long study leaves open, each with the core-hours that would decide it.

    Errors by sampling fall with the root of a run's length, and bounds with the length.
    """
    runs, table = archive.runs_of(LONG_STUDY), []
    for row in [row for row in rows if row["mark"] == "n"]:
        entry, sweeps = row["entry"], paper.figures[row["entry"]["figure"]].sweeps
        folders = tuple(f"{paper.name}/runs/{sweep}/" for sweep in sweeps)
        hours = runs.seconds[runs.index.str.startswith(folders)].sum() / 3600
        apart = abs(entry["deviation_sigma"]) * entry["error"]  # from the end of a range
        if row["number"] is not None:  # it and ours must be told from the rival
            rival = 0.0 if math.isnan(entry["rival"]) else entry["rival"]
            apart = min(abs(row["number"] - rival), abs(entry["value"] - rival))
        systematic, longer = entry["systematic"] ** 2, math.nan
        left = (apart / AGREE) ** 2 - systematic  # for what more sampling lowers
        if math.isfinite(entry["resolution"]) and left > 0:
            longer = (entry["error"] ** 2 - systematic) / left
        elif "an upper bound" in entry["note"] and entry["published"].startswith("<"):
            longer = entry["value"] / float(entry["published"].strip("< "))
        known = hours > 0 and math.isfinite(longer)
        table.append((row, typeset(f"{longer * hours:.2g}") if known else "–"))
    return table


def _found(name, path, tables):
    """What findings.md says, with our values of the longest study that has them."""
    rows = [row["entry"] for table in reversed(tables.values()) for row in table]
    text = re.sub(r"(?<=\*\*)(\w+), ", lambda key: f"{label(key[1])}, ", path.read_text())
    text = re.sub(r"\s*<!--.*?-->", "", text, flags=re.S)
    return verdicts.with_values(text, verdicts.by_name(name, rows))


def rows_of_archive(study: str) -> list[Row]:
    """The verdicts of a study that git keeps, as the report shows them."""
    return verdicts.verdict_rows(verdicts.read_rows(archive.ARCHIVE / study / archive.VERDICTS))


def run_table() -> list[tuple[str, ...]]:
    """The variables of run.nc, observable by observable."""
    rows: dict[tuple[str, str], tuple[str, ...]] = {}
    for observable in names(Observable):
        switches: list[tuple[dict, dict, str]] = [
            ({}, {key: True}, f", with `{key}: true`")
            for key, field in find(Observable, observable).model_fields.items()
            if field.default is False
        ]
        for more, settings, where in (*SCENES, *switches):
            for name, (dimensions, _, units, text) in _variables(observable, more, settings):
                row = (observable, name, ", ".join(dimensions), units, escape(text + where))
                rows.setdefault(row[:2], row)
    return list(rows.values())


def _variables(observable, more, settings):
    """What an observable has in the first of some scenes that it can look at, if in any."""
    asked = more | {"observe": [{observable: {"every": 10} | settings}]}
    for base in (FLUID, PLANE, WALLED):
        with suppress(UserError):
            scene = Scene(base | asked, "example")
            return observables(scene, system_of(scene))[0].variables().items()
    return ()
