"""From sweeps and measurements to a figure's files: picture, PDF, numbers, verdicts, caption."""

import json
import time

import pandas as pd
import xarray as xr
from matplotlib import pyplot as plt
from matplotlib.figure import Figure

from dpd.analysis.collect import save
from dpd.analysis.verdicts import COLUMNS, rows
from dpd.errors import UserError
from dpd.files import replace_whole
from dpd.report import style  # noqa: F401  sets matplotlib's parameters
from dpd.report.figure_file import blamed_on, load_module, wanted
from dpd.scene import Scene

ERRORS = (
    "Error bars: 95 % intervals, 1.96 standard errors. Those of series take the integrated "
    "autocorrelation time into account, those of profiles come from blocks of the run, and both "
    "are carried through to what is derived from them. They are widened by Student's t where few "
    "independent samples have fixed them. Hollow, without a bar: the run is too short for an "
    "error (fewer than about 20 correlation times)."
)


def make_figure(paper, figure, sources, folder):
    """Write ``figure``.png, .pdf, .nc, .csv and .md to a folder.

    Parameters
    ----------
    paper, figure : str
    sources : dict of str to path
        Collected sweeps and measurements.
    folder : path

    Raises
    ------
    UserError
        If a source is missing, or the figure's file is broken.
    """
    begun = time.perf_counter()
    module = load_module(paper, figure)
    data = {name: _load(path) for name, path in sources.items()}
    with blamed_on(module, "compute"):
        numbers = wanted(module, "compute", module.compute(data), xr.Dataset)
    with blamed_on(module, "measured"):
        table = rows(paper, figure, wanted(module, "measured", module.measured(numbers), dict))
    with blamed_on(module, "describe"):
        seen = module.describe(numbers) if hasattr(module, "describe") else module.TITLE
    numbers.attrs |= {"paper": paper, "figure": figure, "seen": seen}
    with blamed_on(module, "draw"):
        drawn = wanted(module, "draw", module.draw(numbers), Figure)
    with blamed_on(module, "the caption"):
        text = caption(module, data, numbers)

    def path(kind):
        return folder / f"{figure}.{kind}"

    replace_whole(path("csv"), lambda draft: table.to_csv(draft, index=False))
    replace_whole(path("md"), lambda draft: draft.write_text(text))
    replace_whole(path("png"), lambda draft: drawn.savefig(draft, format="png"))
    drawn.set_layout_engine("none")  # what it has found for the one holds for the other
    undated = {"CreationDate": None}
    replace_whole(path("pdf"), lambda draft: drawn.savefig(draft, format="pdf", metadata=undated))
    plt.close(drawn)
    numbers.attrs["seconds"] = time.perf_counter() - begun
    save(numbers, path("nc"))


def _load(path):
    """A sweep or a measurement."""
    if not path.is_file():
        raise UserError(f"{path}: there is no such file; let snakemake make it")
    return xr.load_dataset(path, engine="netcdf4")


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
        Without rows where no figure has a published number, or there is no figure.
    """
    tables = [
        pd.read_csv(results / paper.name / "figures" / f"{figure}.csv")
        for paper in papers
        for figure in paper.figures
    ]
    # Without an empty one: it would turn numbers of the others into text.
    filled = [table for table in tables if len(table)]
    if not filled:
        return pd.DataFrame(columns=COLUMNS)
    return pd.concat(filled, ignore_index=True)[COLUMNS]


def caption(module, data, numbers):
    """Title, what the paper shows, then system, parameters, samples, seeds, errors.

    Below that what the figure warns of, and its table.
    """
    parts = [f"**{module.TITLE}** {module.PAPER_SHOWS}"]
    parts += [f"*{name}*: {_line(source)}" for name, source in data.items()]
    parts.append(getattr(module, "ERRORS", ERRORS))
    if hasattr(module, "warnings"):
        parts += [f"**Warning.** {sentence}" for sentence in module.warnings(numbers)]
    if hasattr(module, "table"):
        table = module.table(numbers)
        rows = [table.columns, ["---"] * table.shape[1], *table.values]
        parts.append("\n".join(f"| {' | '.join(map(str, row))} |" for row in rows))
    return "\n\n".join(parts) + "\n"


def _line(source):
    """One sentence on a sweep or a measurement."""
    return source.attrs["description"] if "description" in source.attrs else _sweep_line(source)


def _sweep_line(sweep):
    """One sentence on a sweep: system, integrator, points, samples, seeds."""
    scenes = [Scene(json.loads(str(text)), "sweep") for text in sweep.scene.values.ravel()]
    scene = scenes[0].data
    axes = [name for name in sweep.kT.dims if name != "replica"]
    swept = "; ".join(f"{name} {_values(sweep[name].values)}" for name in axes)
    low, high = (int(v) for v in (sweep.steps.min(), sweep.steps.max()))
    steps = f"{low}" if low == high else f"{low} to {high}"
    beads = f"{int(sweep.beads.min())}"
    if sweep.beads.min() != sweep.beads.max():
        beads += f" to {int(sweep.beads.max())}"
    integrator, thermostat = scene["integrator"], scene["thermostat"]
    edges = scene["box"] if isinstance(scene["box"], list) else [scene["box"]] * scene["dimension"]
    text = (
        f"{beads} beads in {' x '.join(f'{e:g}' for e in edges)} r_c{_missed(scenes)}, "
        f"a {', '.join(f'{pair} {a:g}' for pair, a in scene['repulsion'].items())}, "
        f"{'Langevin ' if thermostat['kind'] == 'langevin' else ''}gamma {thermostat['gamma']:g}, "
        f"{thermostat['noise']} noise, {integrator['scheme']}, "
        f"dt {integrator['dt']:g}"
    )
    if integrator["scheme"] != "euler":
        text += f", lambda {integrator['lambda']:g}"
    if "core" in scene:
        text += f", core radius {scene['core']['radius']:g}, force {scene['core']['force']:g}"
        if scene["core"]["smooth"]:
            text += f", smoothed over {scene['core']['smooth']:g}"
    if "bond" in scene:
        text += f", bonds C {scene['bond']['stiffness']:g}, rest length {scene['bond']['length']:g}"
    text += f", {steps} steps with equilibration, {sweep.sizes['replica']} replica(s)"
    text += f", noise seeds {int(sweep.seed.min())} to {int(sweep.seed.max())}"
    return text + (f"; first of the points over {swept}." if swept else ".")


def _missed(scenes):
    """What whole molecules make of a density that they cannot meet; of the worst scene."""
    missed = [density for scene in scenes for density in scene.missed_densities]
    if not missed:
        return ""
    worst = max(missed, key=lambda density: density.share)
    most = "at worst " if len(scenes) > 1 else ""
    return f" ({most}density {worst.found:.4g} of whole molecules in place of {worst.asked:g})"


def _values(values):
    return ", ".join(f"{v:g}" if isinstance(v, float) else str(v) for v in values.tolist())
