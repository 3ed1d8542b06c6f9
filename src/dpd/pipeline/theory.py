"""A sweep of theory: its points are calculated, all in one job, and nothing is simulated for it.

Its file has the axes and the variables of a collected sweep. It also has a digest for each point,
so that only points whose arguments changed are calculated again.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from typing import Any

from dpd.digest import ROOT, shortened, value_digest
from dpd.errors import UserError, suggestion
from dpd.own import blame
from dpd.page import Calculation
from dpd.pipeline.points import check_axes
from dpd.pipeline.sweep import Axis, axes_of, placed, places
from dpd.sentences import read_section
from dpd.stages import calculations_file

SIMULATED_ALONE = ("scene", "replicas", "series", "seeds", "derive", "sampling")


@dataclass(frozen=True)
class TheoryPoint:
    """One point: its name, its place on the axes, and what is calculated there."""

    name: str
    labels: tuple
    calculation: Calculation
    where: str

    @property
    def digest(self) -> str:
        """Of the arguments."""
        return value_digest(self.calculation.plain())


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
        points = [(point.name, point.digest) for point in self.points]
        axes = [(axis.name, axis.units, axis.long_name) for axis in self.axes]
        return value_digest([self.calculation, axes, points])


def check_kind(given: dict[str, Any], key: str) -> None:
    """Refuse a sweep that has both a scene and a theory, or none, or what belongs to the other.

    Parameters
    ----------
    given : dict
        The sweep as the paper has it.
    key : str
        File and key to name in messages.

    Raises
    ------
    UserError
    """
    if ("scene" in given) == ("theory" in given):
        raise UserError(f"{key}: need either 'scene' or 'theory', and not both")
    strange = SIMULATED_ALONE if "theory" in given else ("theory",)
    kind = "is calculated and has no runs" if "theory" in given else "is simulated"
    for name in strange:
        if name in given:
            raise UserError(f"{key}.{name}: the sweep {kind}; take this key out")


@cache
def calculations_of(paper: str) -> dict[str, type[Calculation]]:
    """What a paper's own file calculates, by the keys of its classes.

    Raises
    ------
    UserError
        If there is no such file, or it cannot be imported.
    """
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


def unfold_theory(
    paper: str, name: str, given: dict[str, Any], key: str, described: dict[str, dict[str, Any]],
    seed: int = 1,
) -> TheorySweep:  # fmt: skip
    """All points of a sweep of theory.

    Parameters
    ----------
    paper, name : str
    given, key
        As in `check_kind`.
    described : dict
        Its axes.
    seed : int
        Of the study, for what is sampled.

    Raises
    ------
    UserError
        If a calculation or an argument is not allowed.
    """
    base, known = given["theory"], calculations_of(paper)
    _key_of(base, known, key)
    check_axes(described, 1, key)
    axes = axes_of(described, key)
    points = []
    for at, labels, where in places(axes, key):
        theory = placed(base, described, labels, key, where)
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
