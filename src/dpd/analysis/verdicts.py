"""Published numbers, which stand in paper_figures/PAPER/published.yaml alone, against ours."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from pydantic import Field

from dpd.errors import UserError
from dpd.folders import paper_folder, shortened
from dpd.page import Refusals, Section, setting
from dpd.scene.yaml import read_section, read_yaml

if TYPE_CHECKING:
    import pandas as pd

COLUMNS = [
    "paper", "figure", "quantity", "where", "kind", "limits", "published", "published_error",
    "rounding", "rival", "value", "error", "systematic", "degrees", "deviation_sigma", "resolution",
    "verdict", "note",
]  # fmt: skip
REPLICATED, DEVIATES, NOT_REACHED = "replicated", "deviates", "not reached at this scale"
AGREE = 2.0  # combined standard errors
BOUND = "an upper bound, at 95 %"  # as notes say it


@dataclass(frozen=True)
class Number:
    """A published number, or range, as figures show it; NaN for what is not given."""

    value: float = math.nan
    error: float = math.nan
    rounding: float = math.nan
    rival: float = math.nan
    low: float = math.nan
    high: float = math.nan

    def __str__(self):
        """Value, and error if one is printed: ``0.101 ± 0.001``."""
        return f"{self.value:g}" + ("" if math.isnan(self.error) else f" ± {self.error:g}")


class Entry(Section):
    """A number or claim of published.yaml that a figure's runs are held against."""

    figure: str = setting("The figure file that measures it.")
    shown_in: list[str] | None = setting("Other figure files that show it.", None)
    quantity: str = setting("What it is, in words and symbols of the field.")
    where: str = setting("Section, equation, figure or table that prints it.")
    kind: Literal["simulated", "closed form", "check"] = setting(
        "simulated: printed, and held against simulation. closed form: printed, and held against a "
        "formula. check: our own, not printed.", "simulated",
    )  # fmt: skip
    value: float | None = setting("The number.", None)
    error: float | None = setting(
        "Its standard error: printed, or measured by us, and then limits are ours.", None, ge=0
    )
    rounding: float | None = setting(
        'Half of its last printed digit, or of what a word like "about" allows.', None, ge=0
    )
    rival: float | None = setting(
        "A value that a run must be able to tell from it, or it decides nothing; 0 if none is "
        "named.", None,
    )  # fmt: skip
    range: Annotated[list[float | None], Field(min_length=2, max_length=2)] | None = setting(
        "Lowest and highest value that the claim allows, null for an open end.", None
    )
    limits: Literal["text", "ours"] | None = setting(
        "Who set the range, the rounding or the error: the text, or we.", None
    )
    note: str | None = setting("How the text is read.", None)
    pending: str | None = setting("Why nothing is held against it yet.", None)

    def conflicts(self) -> Refusals:
        """A value or a range, and who has set the latter."""
        if (self.value is None) == (self.range is None):
            yield "", "needs a value or a range, and not both"
        if self.range is not None and self.limits is None:
            yield "", "the key 'limits' is missing: who set the range"


class Shown(dict):
    """Numbers by name that one figure may show; any other name is refused with a sentence."""

    def __init__(self, paper, figure):
        super().__init__()
        self.paper, self.figure = paper, figure

    def __missing__(self, name):
        raise UserError(  # it is to be drawn again when that number changes, and no other
            f"{published_file(self.paper)}: {self.figure} shows {name!r}, and no number of that "
            f"name has 'figure: {self.figure}' or 'shown_in: [{self.figure}]'"
        )


def figure_path(paper: str, figure: str) -> Path:
    """The file of a figure. Raises `UserError` if it is missing."""
    path = paper_folder(paper) / f"{figure}.py"
    if not path.is_file():
        raise UserError(
            f"{paper}.yaml: figures.{figure}: there is no file {shortened(path)}; "
            "write it, with the functions of one of its neighbours, or take the figure out"
        )
    return path


def published_file(paper: str) -> Path:
    """Where a paper's published numbers stand, if it has any."""
    return paper_folder(paper) / "published.yaml"


@cache
def published(paper: str) -> dict[str, dict[str, Any]]:
    """Published numbers of a paper, if it has any: name to an `Entry` as published.yaml has it."""
    path = published_file(paper)
    table = read_yaml(path) if path.is_file() else {}
    for name, entry in table.items():
        read_section(Entry, entry, str(path), str(name))
    return table


def shown_by(file: str) -> Shown:
    """Published numbers that a figure, by its ``__file__``, measures, or that are `shown_in` it."""
    paper, figure = Path(file).parent.name, Path(file).stem
    shown = Shown(paper, figure)
    for name, entry in published(paper).items():
        if figure in (entry["figure"], *entry.get("shown_in", ())):
            given = {k: entry[k] for k in ("value", "error", "rounding", "rival") if k in entry}
            ends = zip(("low", "high"), entry.get("range", ()))
            shown[name] = Number(**given, **{k: end for k, end in ends if end is not None})
    return shown


@dataclass(frozen=True)
class Measured:
    """Our number for a published one."""

    value: float
    error: float  # one standard error; NaN where the run is too short for one
    note: str = ""  # how it was found, for the table
    undecided: str = ""  # why this run cannot decide; empty if it can
    bound: bool = False  # whether the value is only an upper bound, at 95 %: it has no error
    # The part of the error that more sampling, or another seed, would not change: of points that do
    # not follow the law that is fitted, of a choice of fluids, of bins, of printed numbers.
    systematic: float = 0.0

    @property
    def by_sampling(self) -> float:
        """The rest of the error, which another seed would change."""
        return float(np.sqrt(max(self.error**2 - self.systematic**2, 0.0)))


@dataclass(frozen=True)
class Judgement:
    """What comes of holding a measurement against a published number."""

    verdict: str
    deviation: float = np.nan  # in combined standard errors; NaN where undecided
    resolution: float = np.nan  # the smallest that this run would have called one: two of those
    reason: str = ""  # why nothing was decided; empty otherwise


def judge(entry: Mapping[str, Any], measured: Measured) -> Judgement:
    """Compare one published number, as an `Entry` has it, with ours.

    A value is replicated within two combined standard errors, and at most two of those without
    rounding further off than the rounding of the published one. That decides nothing if the run
    cannot tell it from its rival, another value (0 if none is named): if two combined errors reach
    that far, or if it agrees with the rival, too. A range is replicated where our 95 % interval
    lies inside, deviates where it lies outside, and is undecided where it reaches across a limit.
    An upper bound is replicated inside, and undecided elsewhere.
    """
    if measured.undecided:
        return Judgement(NOT_REACHED, reason=measured.undecided)
    if not np.isfinite(measured.value):
        return Judgement(NOT_REACHED, reason="no run in this study")
    if measured.bound and measured.value <= entry.get("range", [None, -np.inf])[1]:
        return Judgement(REPLICATED)
    if measured.bound:
        return Judgement(NOT_REACHED, reason="an upper bound, which reaches beyond the range")
    if np.isnan(measured.error):
        return Judgement(NOT_REACHED, reason="the run is too short for an error")
    if "range" in entry:
        low, high = (
            end if limit is None else limit for limit, end in zip(entry["range"], (-np.inf, np.inf))
        )
        outside = max(low - measured.value, measured.value - high)  # negative inside
        reach = AGREE * measured.error
        if abs(outside) < reach:
            reason = "two standard errors reach across a limit of the range"
            return Judgement(NOT_REACHED, outside / measured.error, reach, reason)
        if outside <= 0:
            return Judgement(REPLICATED, 0.0, reach)
        return Judgement(DEVIATES, outside / measured.error if measured.error else np.inf, reach)
    difference = measured.value - entry["value"]
    # Rounding is a uniform error of half a last digit either way.
    rounding, errors = entry.get("rounding", 0.0), np.hypot(entry.get("error", 0.0), measured.error)
    combined = np.hypot(errors, rounding / np.sqrt(3.0))
    if combined > 0:
        deviation = difference / combined
    else:
        deviation = np.inf * difference if difference else 0.0
    resolution = AGREE * combined
    rival = entry.get("rival", 0.0)
    apart = abs(entry["value"] - rival)
    agrees = abs(difference) <= max(rounding, min(resolution, rounding + AGREE * errors))
    if agrees and apart and resolution > apart:
        reason = f"two standard errors reach from {entry['value']:g} to {rival:g}"
        return Judgement(NOT_REACHED, deviation, resolution, reason)
    if agrees and apart and abs(measured.value - rival) <= AGREE * measured.error:
        reason = f"within two standard errors of {entry['value']:g} and of {rival:g}"
        return Judgement(NOT_REACHED, deviation, resolution, reason)
    return Judgement(REPLICATED if agrees else DEVIATES, deviation, resolution)


def rows(
    paper: str, figure: str, measured: Mapping[str, Measured], degrees: Mapping[str, float]
) -> pd.DataFrame:
    """Verdict rows of one figure, in the order of published.yaml.

    ``degrees``: of freedom of their errors, as far as known. Raises `UserError` if a measured name
    is not published, or a published number has no counterpart and no reason for that.
    """
    import pandas as pd  # the Snakefile, which reads published numbers, does without

    entries = {k: e for k, e in published(paper).items() if e["figure"] == figure}
    if unknown := set(measured) - set(entries):
        raise UserError(f"{published_file(paper)}: {figure} measures {sorted(unknown)}, not listed")
    table = []
    for name, entry in entries.items():
        if name not in measured and "pending" not in entry:
            raise UserError(f"{published_file(paper)}: {name}: {figure} does not measure it")
        ours = measured.get(name) or Measured(np.nan, np.nan, "", entry["pending"])
        found = judge(entry, ours)
        bound = BOUND if ours.bound else ""
        notes = [entry.get("note"), bound, ours.note, found.reason]
        table.append({"kind": "simulated", "limits": "text"} | entry | {
            "paper": paper,
            "published": entry["value"] if "value" in entry else _range_text(entry["range"]),
            "published_error": entry.get("error", np.nan),
            "value": ours.value,
            "error": np.nan if ours.bound else ours.error,
            "systematic": ours.systematic,
            "degrees": round(degrees.get(name, np.nan), 1),
            "deviation_sigma": round(float(found.deviation), 2),
            "resolution": found.resolution,
            "verdict": found.verdict,
            "note": "; ".join(note for note in notes if note),
        })  # fmt: skip
    return pd.DataFrame(table, columns=COLUMNS)


def _range_text(limits):
    low, high = limits
    if low is None:
        return f"< {high:g}"
    return f"> {low:g}" if high is None else f"{low:g} to {high:g}"
