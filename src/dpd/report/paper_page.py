"""The page of a paper, paper_figures/PAPER/README.md: verdicts, findings and pictures."""

from functools import cache

import yaml

from dpd.digest import ROOT
from dpd.errors import UserError
from dpd.pipeline.paths import LONG_STUDY
from dpd.pipeline.study import read_paper, read_study
from dpd.pipeline.theory import calculations_of
from dpd.report.archive import FIGURES, manifest_of, pictures, read_archive, studies
from dpd.report.captions import label
from dpd.report.figure_file import load_module
from dpd.report.keys import section_rows
from dpd.report.markdown import counts, deviations, figure_counts, key_table
from dpd.report.notation import typeset
from dpd.stages import calculations_file

HEAD = """# {title}

{reference}{doi}

`python -m dpd readme` writes this page from the verdict tables in `results/archive`, from the
captions in the figure files and from [findings.md](findings.md). Edit those.

The paper's sweeps stand in [config/papers/{name}.yaml](../../config/papers/{name}.yaml), its
published numbers in [published.yaml](published.yaml). To make its figures:
`snakemake --cores 2 --config papers='[{name}]'`.
"""
STUDY = """## What the study `{study}` finds

{description}

{counts}

*Held against simulation*: numbers and claims that the paper prints, compared with our runs.
*Closed forms*: numbers that it prints, compared with a formula. *Own checks*: numbers that it does
not print.

What deviates, with our standard error, and the difference in combined standard errors of both:

{deviations}

All figures, with the verdicts on their numbers, own checks included:

{figures}
"""


def papers_with_pages() -> list[str]:
    """Papers that an archived study has verdicts on."""
    return sorted({paper for study in studies() for paper in read_archive(study).paper})


def paper_page(name: str) -> str:
    """The page of a paper as Markdown.

    Parameters
    ----------
    name : str

    Raises
    ------
    UserError
        If the paper has no findings, or CITATION.cff does not know its title.
    """
    tables = {study: _verdicts(study, name) for study in studies()}
    tables = {study: table for study, table in tables.items() if len(table)}
    paper = read_paper(name, next(iter(tables)), only=[])
    modules = {figure: load_module(name, figure) for figure in paper.figures}
    head = HEAD.format(
        name=name, title=paper.title, reference=paper.reference, doi=_doi(paper.title)
    )
    kept = [picture.stem for picture in pictures(name)]
    parts = [
        head,
        *(_study(name, study, table, modules) for study, table in tables.items()),
        f"## Findings\n\n{typeset(_findings(name))}",
        *([_calculations(name)] if calculations_file(name).is_file() else []),
        *(["## Pictures\n"] if kept else []),
        *(_picture(figure, load_module(name, figure)) for figure in kept),
    ]
    return "\n".join(parts)


def _verdicts(study, name):
    table = read_archive(study)
    return table[table.paper == name]


def _study(name, study, table, modules):
    """What a study finds."""
    missing = [figure for figure in modules if f"{name}/{figure}" in _missing(study)]
    titles = {figure: m.TITLE for figure, m in modules.items() if figure not in missing}
    text = STUDY.format(
        study=study,
        description=read_study(study).description,
        counts=counts(table),
        deviations=deviations(table),
        figures=figure_counts(table, titles),
    )
    if study == LONG_STUDY:
        folder = f"results/archive/{study}/{name}"
        text += f"\nPictures and their numbers are in [{folder}](../../{folder})."
        if missing:
            text += f" Not made yet: {', '.join(label(figure) for figure in missing)}."
        text += "\n"
    return text


def _calculations(name):
    """What its sweeps of theory calculate."""
    known = calculations_of(name)
    rows = [row for key, each in known.items() for row in section_rows(each, key, "")]
    return f"""## Calculations

What its sweeps with `theory` calculate, by the classes in [calculations.py](calculations.py). An
axis may set any argument, as `set: {next(iter(known))}.ARGUMENT`.

{key_table(rows)}
"""


def _missing(study):
    """Figures that an archive lacks, as its study was stopped before its end."""
    return manifest_of(study).get("figures_missing", ())


def _picture(figure, module):
    """A picture with the figure's own caption."""
    return (
        f"![{label(figure)}: {module.TITLE}]({figure}.png)\n\n"
        f"**{label(figure)}. {typeset(module.TITLE)}** {typeset(module.PAPER_SHOWS)}\n"
    )


def _findings(name):
    path = FIGURES / name / "findings.md"
    if not path.is_file():
        raise UserError(
            f"{path}: there is no such file; write what the runs have shown, and why what deviates "
            "does"
        )
    return path.read_text()


@cache
def _references():
    entries = yaml.safe_load((ROOT / "CITATION.cff").read_text())["references"]
    return {entry["title"]: entry.get("doi") for entry in entries}


def _doi(title):
    """A link to the paper, to be put behind its reference; nothing if it has none."""
    if title not in _references():
        raise UserError(
            f"CITATION.cff: references: none has the title {title!r} of a paper in config/papers"
        )
    doi = _references()[title]
    return f", [doi:{doi}](https://doi.org/{doi})" if doi else ""
