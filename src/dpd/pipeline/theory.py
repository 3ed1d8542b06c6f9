"""A sweep of theory: its points are calculated, all in one job, and nothing is simulated for it.

Its file has the axes and the variables of a collected sweep.
"""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from dpd.digest import ROOT, shortened, value_digest
from dpd.errors import UserError, suggestion
from dpd.own import blame, blaming
from dpd.page import Calculation, Quantity
from dpd.pipeline.sweep import Axis, SweepFile, axes_of, placed, places
from dpd.scene.yaml import read_section
from dpd.sources import calculations_file, stage_digest

if TYPE_CHECKING:
    from collections.abc import Callable

    import xarray as xr


class TheoryPoint(NamedTuple):
    """One point: its name, its place on the axes, and what is calculated there."""

    name: str
    labels: tuple
    calculation: Calculation
    where: str


@dataclass(frozen=True)
class TheorySweep:
    """A family of calculations, all of one kind, that differ in some arguments."""

    name: str
    paper: str
    axes: tuple[Axis, ...]
    points: tuple[TheoryPoint, ...]

    @property
    def calculation(self) -> str:
        """The key of what is calculated."""
        return self.points[0].calculation.key

    @property
    def digest(self) -> str:
        """Of the calculation, the axes and all points."""
        points = [(p.name, value_digest(p.calculation.plain())) for p in self.points]
        axes = [(axis.name, axis.units, axis.long_name) for axis in self.axes]
        return value_digest([self.calculation, axes, points])


@cache
def calculations_of(paper: str) -> dict[str, type[Calculation]]:
    """What a paper's own file calculates, by the keys of its classes."""
    path = calculations_file(paper)
    short = shortened(path)
    if not path.is_file():
        raise UserError(
            f"{paper}.yaml: a sweep has 'theory', and there is no file "
            f"{short}; write it, with a class for each calculation, as "
            "paper_figures/crgw_2019 has it, or take the sweep out"
        )
    if sys.path[0] != str(ROOT):
        sys.path.insert(0, str(ROOT))
    try:
        module = import_module(f"paper_figures.{paper}.{path.stem}")
    except Exception as problem:  # whatever a file of someone's own may raise
        said = blame(problem, [str(path)]) or f"{short}: {type(problem).__name__}: {problem}"
        raise UserError(said) from None
    found = [each for each in vars(module).values() if isinstance(each, type)]
    return {each.key: each for each in found if issubclass(each, Calculation) and each.key}


def unfold_theory(paper: str, name: str, given: SweepFile, key: str, seed: int = 1) -> TheorySweep:
    """All points of a sweep of theory; ``seed``: of the study, for what is sampled."""
    known, axes, points = calculations_of(paper), axes_of(given), []
    _key_of(given.theory, known, key)
    for at, labels, where in places(axes, key):
        theory = placed(given.theory, given, labels, key, where)
        found = _key_of(theory, known, key)
        calculation = read_section(known[found], theory[found], where, found)
        if seed != 1 and getattr(calculation, "seed", seed) is None:
            calculation = calculation.model_copy(update={"seed": seed})
        points.append(TheoryPoint(at, labels, calculation, where))
    return TheorySweep(name, paper, tuple(axes), tuple(points))


def _key_of(theory, known, key):
    """The one calculation of a theory."""
    unknown = [name for name in theory if name not in known]
    if unknown:
        said = suggestion(unknown[0], known)
        raise UserError(f"{key}.theory: no calculation {unknown[0]!r}; {said}")
    if len(theory) != 1:
        raise UserError(f"{key}.theory: need one calculation; allowed: {', '.join(known)}")
    return next(iter(theory))


def calculate(sweep: TheorySweep, progress: Callable[[int], None] | None = None) -> xr.Dataset:
    """Calculate a sweep: dimensions are its axes, and those of arrays that are calculated.

    ``progress`` is called with the number of points done. A point without a solution is refused
    with its name and why.
    """
    import xarray as xr

    begun, found = time.perf_counter(), []
    for done, point in enumerate(sweep.points, 1):
        found.append(_calculated(point))
        if progress is not None:
            progress(done)
    names = [axis.name for axis in sweep.axes]
    shape = [len(axis.labels) for axis in sweep.axes]
    data = xr.Dataset()
    for axis in sweep.axes:
        about = {"units": axis.units, "long_name": axis.long_name}
        data[axis.name] = (axis.name, list(axis.labels), about)
    for name, first in found[0].items():
        about = {"units": first.units, "long_name": first.long_name}
        if first.dims == (name,):
            data[name] = (name, first.value, about)
            continue
        values = np.array([point[name].value for point in found])
        data[name] = ((*names, *first.dims), values.reshape((*shape, *values.shape[1:])), about)
    data.attrs = {
        "sweep": sweep.name,
        "calculation": sweep.calculation,
        "axes": " ".join(names),
        "description": _description(sweep),
        "sources": stage_digest("calculate", calculations_file(sweep.paper)),
        "points": sweep.digest,
        "seconds": time.perf_counter() - begun,
    }
    return data


def _calculated(point: TheoryPoint) -> dict[str, Quantity]:
    """What a calculation finds at one point, refused if it has no solution or is broken."""
    calculation, place = point.calculation, f"{point.where}: {point.calculation.key}"
    with blaming(calculation, place):
        try:
            found = calculation.calculate()
        except ValueError as problem:
            raise UserError(f"{place}: {problem}") from None
        return {name: Quantity(*value) for name, value in found.items()}


def _description(sweep):
    """What captions say of the sweep."""
    axes = "; ".join(
        f"{axis.long_name} {', '.join(map(str, axis.labels))}"
        if len(axis.labels) <= 6
        else f"{axis.long_name} {axis.labels[0]} to {axis.labels[-1]} ({len(axis.labels)} values)"
        for axis in sweep.axes
    )
    return f"calculated, nothing is simulated: {sweep.calculation.replace('_', ' ')}; {axes}."
