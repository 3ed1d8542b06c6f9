"""A sweep of theory: its points are calculated, all in one job, and nothing is simulated for it.

Its file has the axes and the variables of a collected sweep. It also has a digest for each point,
so that only points whose arguments changed are calculated again.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from dpd.digest import value_digest
from dpd.errors import UserError, suggestion
from dpd.pipeline.points import check_axes
from dpd.pipeline.sections import ARGUMENTS
from dpd.pipeline.sweep import Axis, axes_of, placed, places
from dpd.sentences import read_section

SIMULATED_ALONE = ("scene", "replicas", "series", "seeds", "derive", "sampling")


@dataclass(frozen=True)
class TheoryPoint:
    """One point: its name, its place on the axes, and the arguments of the calculation."""

    name: str
    labels: tuple
    arguments: dict
    where: str

    @property
    def digest(self) -> str:
        """Of the arguments."""
        return value_digest(self.arguments)


@dataclass(frozen=True)
class TheorySweep:
    """A family of calculations that differ in some arguments.

    Attributes
    ----------
    name : str
    calculation : str
        Its name in `ARGUMENTS`.
    axes : tuple of Axis
    points : tuple of TheoryPoint
    """

    name: str
    calculation: str
    axes: tuple[Axis, ...]
    points: tuple[TheoryPoint, ...]

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


def unfold_theory(
    name: str, given: dict[str, Any], key: str, described: dict[str, dict[str, Any]], seed: int = 1
) -> TheorySweep:
    """All points of a sweep of theory.

    Parameters
    ----------
    name : str
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
    base = given["theory"]
    calculation = _calculation(base, key)
    check_axes(described, 1, key)
    axes = axes_of(described, key)
    points = []
    for at, labels, where in places(axes, key):
        theory = placed(base, described, labels, key, where)
        _calculation(theory, key)
        arguments = read_section(
            ARGUMENTS[calculation], theory[calculation], where, calculation
        ).model_dump(exclude_none=True)
        if seed != 1 and arguments.get("samples"):
            arguments = {"seed": seed, **arguments}
        points.append(TheoryPoint(at, labels, arguments, where))
    return TheorySweep(name, calculation, tuple(axes), tuple(points))


def _calculation(theory: dict[str, Any], key: str) -> str:
    """The one calculation of a theory."""
    known = list(ARGUMENTS)
    unknown = [name for name in theory if name not in known]
    if unknown:
        said = suggestion(unknown[0], known)
        raise UserError(f"{key}.theory: no calculation {unknown[0]!r}; {said}")
    if len(theory) != 1:
        raise UserError(f"{key}.theory: need one calculation; allowed: {', '.join(known)}")
    return next(iter(theory))
