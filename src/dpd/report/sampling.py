"""How long our runs are beside those of the paper, and whether that is enough."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from dpd.analysis.verdicts import NOT_REACHED, SIMULATED
from dpd.report.captions import NARROW_SPACE, label
from dpd.report.notation import typeset
from dpd.report.text import with_range

if TYPE_CHECKING:
    from collections.abc import Sequence

    import pandas as pd

    from dpd.pipeline.study import Paper
    from dpd.report.judged import Row

# Of time: a number of steps is rounded when a duration becomes one.
SHORTER = 0.999


@dataclass(frozen=True)
class Shorter:
    """A point that is sampled for less time than in the paper, or in a smaller system, as text.

    ``share`` is our time in units of the paper's.
    """

    paper: str
    sweep: str
    point: str
    time: str
    paper_time: str
    share: str
    system: str
    where: str


@dataclass(frozen=True)
class Reached:
    """Of the published numbers in the figures that a sweep feeds: how many are decided.

    ``shares`` are our standard errors of those, in units of the published error or rounding, and
    ``open`` the rows that are not decided.
    """

    paper: str
    sweep: str
    figures: str
    decided: str
    shares: str
    open: list


def shorter_points(paper: Paper) -> list[Shorter]:
    """Points of a paper's sweeps that have less sampling than the paper says it had.

    Parameters
    ----------
    paper : dpd.pipeline.study.Paper

    Returns
    -------
    list of Shorter
    """
    found = []
    for said in paper.sampling:
        if "steps" not in said and "duration" not in said:
            continue
        for sweep in said["sweeps"]:
            for name, scenes in _by_point(paper.sweeps[sweep], said.get("at", {})).items():
                ours = sum(scene.steps.sample * _dt(scene) for scene in scenes)
                theirs = _time(said, scenes[0])
                system, smaller = _system(said, scenes[0])
                if ours < SHORTER * theirs or smaller:
                    found.append(
                        Shorter(
                            paper.name, sweep, name, _number(ours),
                            ("≥ " if said.get("at_least") else "") + _number(theirs),
                            f"{ours / theirs:.2g}", system, typeset(said["where"]),
                        )
                    )  # fmt: skip
    return found


def not_said(paper: Paper) -> list[str]:
    """Sweeps for which the paper does not say how long it sampled."""
    return [
        name
        for said in paper.sampling
        if "steps" not in said and "duration" not in said
        for name in said["sweeps"]
    ]


def _by_point(sweep, at):
    """Scenes of each point that has the labels asked for, by its name, its replicas together."""
    points = {}
    for point in sweep.points:
        place = {axis.name: value for axis, value in zip(sweep.axes[:-1], point.labels)}
        if all(place[axis] in labels for axis, labels in at.items()):
            name = ", ".join(f"{axis.replace('_', ' ')} {value}" for axis, value in place.items())
            points.setdefault(name, []).append(point.scene)
    return points


def _number(time):
    """A time in tau, thousands apart."""
    return f"{time:,.0f}".replace(",", NARROW_SPACE)


def _dt(scene):
    return scene.dt


def _time(said, scene):
    """Time in tau that the paper sampled; its step is ours where it gives none."""
    time = said["duration"] if "duration" in said else said["steps"] * said.get("dt", _dt(scene))
    return time * said.get("runs", 1)


def _system(said, scene):
    """Our size and the paper's in words, and whether ours is smaller."""
    sizes = {"beads": scene.beads, "molecules": sum(kind.count for kind in scene.molecules)}
    for kind, ours in sizes.items():
        if kind in said:
            theirs = said[kind]
            return f"{ours} of {theirs} {kind}" if ours != theirs else "the same", ours < theirs
    return "not said", False


def reached(paper: Paper, table: pd.DataFrame, rows: Sequence[Row]) -> list[Reached]:
    """What the figures could decide that are fed by sweeps with shorter points.

    Parameters
    ----------
    paper : dpd.pipeline.study.Paper
    table : pandas.DataFrame
        Verdicts.
    rows : list of dpd.report.judged.Row
        The same as text, in the same order.

    Returns
    -------
    list of Reached
    """
    found = []
    for sweep in dict.fromkeys(point.sweep for point in shorter_points(paper)):
        figures = [name for name, figure in paper.figures.items() if sweep in figure.sweeps]
        own = table[
            (table.paper == paper.name) & table.figure.isin(figures) & (table.kind == SIMULATED)
        ]
        is_open = own.verdict == NOT_REACHED
        found.append(
            Reached(
                paper.name, sweep, ", ".join(label(name) for name in figures),
                f"{len(own) - is_open.sum()} of {len(own)}", _shares(own[~is_open]),
                [rows[place] for place in own.index[is_open]],
            )
        )  # fmt: skip
    return found


def _shares(decided):
    """Our standard errors in units of the published error or rounding, whichever is larger."""
    allowed = np.fmax(decided.published_error, decided.rounding).astype(float)
    shares = (decided.error / allowed).to_numpy(dtype=float)
    shares = shares[np.isfinite(shares)]
    if not len(shares):
        return ""
    return with_range(np.median(shares), shares.min(), shares.max())
