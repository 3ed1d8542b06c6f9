"""The page of one run: what was measured, panel by panel, and what of it is off."""

import base64
from collections.abc import Iterator
from contextlib import suppress
from io import BytesIO
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dpd.analysis.collect import load
from dpd.analysis.diffusion import HALF, displacements, end_to_end
from dpd.analysis.statistics import COVERAGE, averaged, block_mean_and_error, mean_and_error
from dpd.errors import UserError
from dpd.files import replace_whole
from dpd.report.draw import draw
from dpd.report.style import BLACK, BLUE, LOOK, OF_SPECIES, points
from dpd.report.text import line_of, rendered, span, typeset, with_error
from dpd.runs.result import scene_of
from dpd.scene.scene import Scene

POINTS = 400  # of a line over time, each the mean of what lies between
SURE = 3.0  # standard errors, from which on two numbers differ
FEWEST = 20.0  # independent samples, from which on an error is known well
SIZE, DPI = (3.5, 2.5), 160  # of a panel: inches, pixels per inch


class Quantity(NamedTuple):
    """A mean of a run."""

    name: str
    units: str
    mean: float
    error: float
    time: float  # of correlation, in tau; NaN of means over blocks
    independent: float  # samples; NaN where not known
    halves: float  # first half less second one, in errors that the second lets expect
    asked: float  # what the scene sets it to; NaN if nothing


def write_run_page(path: Path, output: Path) -> None:
    """Write the page of a run, from its file alone; `UserError` if that is not one of a run."""
    run = load(path, "name the run.nc of a run")
    scene = scene_of(path, run.attrs)
    for variable in run.variables.values():
        units = variable.attrs.get("units", "1").replace("dimension", str(scene.dimension))
        variable.attrs["units"] = "" if units == "1" else units
    found = [*quantities(run, scene)]
    with mpl.rc_context(LOOK):
        drawn = [*over_time(run, scene), *profiles(run, scene), *over_lags(run, scene)]
        panels = [(typeset(title), _image(figure)) for title, figure in drawn]
        picture = ""
        with suppress(UserError):  # a run of a study keeps no configuration
            picture = _image(draw(path, size=12))
    page = rendered(
        "run.html", name=path.name, picture=picture, panels=panels, quantities=found,
        line=typeset(f"{line_of([scene])}."), off=list(map(typeset, off(run, found))), sure=SURE,
        with_error=with_error, facts={
            "beads": span(run.attrs["beads"]), "steps": span(run.attrs["steps"]),
            "τ sampled": f"{scene.steps.sample * scene.dt:.6g}",
            "million bead-steps a second": f"{run.attrs['bead_steps_per_second'] / 1e6:.3g}",
        },
    )  # fmt: skip
    replace_whole(output, lambda draft: draft.write_text(page, encoding="utf-8"))


def quantities(run: xr.Dataset, scene: Scene) -> Iterator[Quantity]:
    """Means of all series, and of what has one number for each block, or a few."""
    for name, values, times in _series(run):
        mean, error, memory = mean_and_error(values)
        asked = scene.kT if name == "kT" and len(scene.stages) == 1 else np.nan
        yield _quantity(run[name], values, mean, error, memory * times[0], asked=asked)
    for variable in run.data_vars.values():
        over, *rest = (*variable.dims, "")[: max(1, variable.ndim)]
        if str(over).startswith("block") and not any(_is_axis(run, each) for each in rest):
            columns = variable.values.reshape(len(variable), -1).T
            for k, column in enumerate(columns):
                of = f", {_label(variable, k, scene)}" if len(columns) > 1 else ""
                if column.any():  # single beads have no size
                    yield _quantity(variable, column, *block_mean_and_error(column), of=of)


def _quantity(variable, values, mean, error, time=np.nan, of="", asked=np.nan):
    half = len(values) // 2
    later, expected, _ = mean_and_error(values[half:])
    halves = (values[:half].mean() - later) / (2**0.5 * expected) if expected > 0 else np.nan
    independent = values.var() / error**2 if error > 0 else np.nan
    name = _title(variable) + of
    return Quantity(name, variable.units, mean, error, time, independent, halves, asked)


def off(run: xr.Dataset, found: list[Quantity]) -> Iterator[str]:
    """Sentences on what a person should know before the numbers are used."""
    if warning := run.attrs.get("warning"):
        yield warning
    if run.attrs["lost_step"] >= 0:
        yield f"the run broke at step {run.attrs['lost_step']}, and holds nothing from there on"
    if moved := [f"{each.name} ({each.halves:+.1f})" for each in found if abs(each.halves) > SURE]:
        yield (
            "the halves of the run differ by more standard errors than chance would make it: "
            f"{'; '.join(moved)}. Let it equilibrate for longer"
        )
    for each in found:
        if abs(each.mean - each.asked) > SURE * each.error:
            mean = with_error(each.mean, each.error)
            yield f"{each.name}: {mean}, and {each.asked:g} is set; try half the time step"
    if few := [each.name for each in found if each.independent < FEWEST]:
        yield (
            f"fewer than {FEWEST:g} independent samples, too few to know an error well: "
            f"{'; '.join(few)}. Run longer, as with dpd extend"
        )


# Panels: each variable of a run is one, by what it extends over.


def over_time(run: xr.Dataset, scene: Scene) -> Iterator[tuple[str, Figure]]:
    """Series, with their means, and what the scene sets them to."""
    for name, values, times in _series(run):
        size = -(-len(values) // POINTS)
        figure, axes = _panel("time / tau", run[name])
        axes.plot(averaged(times, size), averaged(values, size), color=BLUE, lw=0.7)
        axes.axhline(values.mean(), color=BLACK, label="mean")
        if name == "kT" and len(scene.stages) == 1:
            axes.axhline(scene.kT, color=BLACK, ls="--", label="set")
        axes.legend()
        yield _title(run[name]), figure


def profiles(run: xr.Dataset, scene: Scene) -> Iterator[tuple[str, Figure]]:
    """Means over blocks of what has an axis: distributions, g(r), densities."""
    for variable in run.data_vars.values():
        over, *between, axis = (*variable.dims, "", "")[: max(2, variable.ndim)]
        if not str(over).startswith("block") or not _is_axis(run, axis) or len(between) > 1:
            continue
        mean, error = block_mean_and_error(variable.values)
        figure, axes = _panel(f"{str(axis).replace('_', ' ')} / {run[axis].units}", variable)
        for k, (y, e) in enumerate(zip(np.atleast_2d(mean), np.atleast_2d(error))):
            colour, x = OF_SPECIES[k % len(OF_SPECIES)], run[axis].values
            axes.plot(x, y, color=colour, label=_label(variable, k, scene) if between else None)
            axes.fill_between(x, y - COVERAGE * e, y + COVERAGE * e, color=colour, alpha=0.3, lw=0)
        if between:
            axes.legend()
        yield _title(variable), figure


def over_lags(run: xr.Dataset, scene: Scene) -> Iterator[tuple[str, Figure]]:
    """What is compared over times apart: means over molecules; of displacements D(t), too."""
    runs = run.assign(scene=((), run.attrs["scene"])).expand_dims("replica")
    for name, variable in run.data_vars.items():
        time = f"{variable.dims[0]}_time" if variable.ndim == 2 else ""
        if time not in run:
            continue
        t, mean = run[time].values, variable.values.mean(axis=1)
        error: Any = np.full(len(t), np.nan)
        moves = name in ("msd_inner", "msd_centre")  # whose errors know what molecules do together
        if (moves or name == "end_correlation") and variable.shape[1] > 1:
            kind = str(name).removeprefix("msd_")
            found = displacements(runs, kind, HALF) if moves else end_to_end(runs)[0]
            t, (mean, error) = found.time, found.derived(lambda g: g)
        seen = (t > 0) & (mean > 0)
        for per_time in (False, True) if moves else (False,):
            over = 2 * scene.dimension * t[seen] if per_time else 1.0
            figure, axes = _panel("time apart / tau", variable)
            points(axes, t[seen], mean[seen] / over, error[seen] / over)
            axes.set(xscale="log", yscale="linear" if per_time else "log")
            if per_time:
                axes.set_ylabel("D(t) = square / (2 d t)")
            yield _title(variable) + (": D(t)" if per_time else ""), figure


def _series(run):
    """Names, values and times of all that has one number for each sample."""
    for name, variable in run.data_vars.items():
        over = str(variable.dims[0]) if variable.ndim == 1 else ""
        times = over.removesuffix("sample") + "time"
        is_series = over.endswith("sample") and times in run and name != times
        if is_series and np.isfinite(variable.values).all():
            yield name, variable.values, run[times].values


def _is_axis(run, name):
    """Whether a dimension has places, as bins and layers have, and not names or numbers alone."""
    return name in run.coords and np.issubdtype(run[name].dtype, np.floating)


def _label(variable, k, scene):
    """What the k-th of some curves or numbers is of."""
    over = variable.dims[1]
    if over == "kind":
        return str(scene.data["molecules"][k]["architecture"])
    return str(variable[over].values[k]) if over in variable.coords else f"{over} {k + 1}"


def _title(variable):
    return str(variable.attrs.get("long_name", variable.name))


def _panel(along, variable):
    figure = Figure(figsize=SIZE)
    axes = figure.subplots()
    axes.set(xlabel=along, ylabel=variable.units)
    return figure, axes


def _image(figure):
    with BytesIO() as image:
        figure.savefig(image, format="png", dpi=DPI)
        return f"data:image/png;base64,{base64.b64encode(image.getvalue()).decode()}"
