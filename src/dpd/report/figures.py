"""From sweeps and measurements to a figure's files: picture, PDF, numbers, verdicts, caption."""

import importlib.util
import time

import pandas as pd
import xarray as xr
from matplotlib import pyplot as plt

from dpd.analysis.collect import save
from dpd.analysis.verdicts import COLUMNS, rows
from dpd.digest import ROOT
from dpd.errors import UserError
from dpd.files import replace_whole
from dpd.report import style  # noqa: F401  sets matplotlib's parameters
from dpd.report.captions import caption, label


def load_module(paper, figure):
    """The file of a figure: ``compute(data)``, ``draw(numbers)``, ``measured(numbers)``.

    It may also have ``warnings(numbers)``, sentences, and ``table(numbers)``, a data frame of
    text; both go below its caption. ``describe(numbers)`` says in one or two sentences what is
    seen, for those who cannot see the picture.

    Raises
    ------
    UserError
        If the file is missing.
    """
    path = ROOT / "paper_figures" / paper / f"{figure}.py"
    if not path.is_file():
        raise UserError(f"{path}: a figure named in config/papers/{paper}.yaml has no such file")
    spec = importlib.util.spec_from_file_location(f"{paper}.{figure}", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def make_figure(paper, figure, sources, folder):
    """Write ``figure``.png, .pdf, .nc, .csv and .html, its caption, to a folder.

    Parameters
    ----------
    paper, figure : str
    sources : dict of str to path
        Collected sweeps and measurements.
    folder : path
    """
    begun = time.perf_counter()
    module = load_module(paper, figure)
    data = {name: xr.load_dataset(path, engine="netcdf4") for name, path in sources.items()}
    numbers = module.compute(data)
    table = rows(paper, figure, module.measured(numbers))
    seen = module.describe(numbers) if hasattr(module, "describe") else module.TITLE
    numbers.attrs |= {"paper": paper, "figure": figure, "seen": seen}
    drawn = module.draw(numbers)

    def path(kind):
        return folder / f"{figure}.{kind}"

    replace_whole(path("csv"), lambda draft: table.to_csv(draft, index=False))
    said = caption(figure, module, data, numbers)
    replace_whole(path("html"), lambda draft: draft.write_text(said))
    title = f"{paper}, {label(figure)}: {module.TITLE}"
    about = {"Title": title, "Description": seen}
    replace_whole(path("png"), lambda draft: drawn.savefig(draft, format="png", metadata=about))
    drawn.set_layout_engine("none")  # what it has found for the one holds for the other
    about = {"Title": title, "Subject": seen, "CreationDate": None}
    replace_whole(path("pdf"), lambda draft: drawn.savefig(draft, format="pdf", metadata=about))
    plt.close(drawn)
    numbers.attrs["seconds"] = time.perf_counter() - begun
    save(numbers, path("nc"))


def joined_verdicts(papers, results):
    """The verdict tables of all figures as one.

    Parameters
    ----------
    papers : list of dpd.study.Paper
    results : path
        Folder of the study.

    Returns
    -------
    pandas.DataFrame
        Without rows where no figure has a published number.
    """
    tables = [
        pd.read_csv(results / paper.name / "figures" / f"{figure}.csv")
        for paper in papers
        for figure in paper.figures
    ]
    filled = [table for table in tables if len(table)]
    if not filled:
        return pd.DataFrame(columns=COLUMNS)
    return pd.concat(filled, ignore_index=True)[COLUMNS]
