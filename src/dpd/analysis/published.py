"""Published numbers, which stand in paper_figures/published.yaml alone."""

import math
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from dpd.digest import ROOT
from dpd.errors import UserError
from dpd.scene.schema import read_yaml, suggestion, validate

PUBLISHED = ROOT / "paper_figures" / "published.yaml"


@dataclass(frozen=True)
class Number:
    """A published number, as a figure draws it and as captions say it.

    Attributes
    ----------
    value, error, rounding, rival : float
        NaN where published.yaml gives none.
    low, high : float
        Ends of the range that the text allows; NaN where an end is open, or there is no range.
    """

    value: float = math.nan
    error: float = math.nan
    rounding: float = math.nan
    rival: float = math.nan
    low: float = math.nan
    high: float = math.nan

    def __str__(self):
        """Value, and error if one is printed: ``0.101 ± 0.001``."""
        return f"{self.value:g}" + ("" if math.isnan(self.error) else f" ± {self.error:g}")


class Shown(dict):
    """Numbers by name that one figure may show; any other name is refused with a sentence."""

    def __init__(self, numbers, paper, figure):
        super().__init__(numbers)
        self.paper, self.figure = paper, figure

    def __missing__(self, name):
        known = published(self.paper)
        if name in known:
            raise UserError(
                f"{PUBLISHED}: {self.paper}.{name}: {self.figure} shows it; write 'shown_in: "
                f"[{self.figure}]' there, so that the figure is drawn again when the number changes"
            )
        raise UserError(
            f"{PUBLISHED}: {self.paper}: {self.figure} shows {name!r}, which is not there; "
            f"{suggestion(name, known)}"
        )


def published(paper: str) -> dict[str, dict[str, Any]]:
    """Published numbers of a paper, if it has any: name to what published.yaml says of it.

    Raises
    ------
    UserError
        If an entry is not as src/dpd/schemas/published.yaml has it.
    """
    return _all_published().get(paper, {})


@cache
def _all_published():
    table = read_yaml(PUBLISHED)
    validate(table, "published", str(PUBLISHED))
    return table


def entries_of(paper: str, figure: str) -> dict[str, dict[str, Any]]:
    """What published.yaml says of the numbers that a figure measures, and of those it shows."""
    return {
        name: entry
        for name, entry in published(paper).items()
        if figure in (entry["figure"], *entry.get("shown_in", ()))
    }


def shown_by(file: str) -> Shown:
    """Published numbers that a figure file may show: those that it measures, and `shown_in` it.

    Parameters
    ----------
    file : str
        ``__file__`` of the figure file.

    Returns
    -------
    Shown
        Name to `Number`.
    """
    path = Path(file)
    paper, figure = path.parent.name, path.stem
    entries = entries_of(paper, figure)
    return Shown({name: _number(entry) for name, entry in entries.items()}, paper, figure)


def _number(entry):
    given = {name: entry[name] for name in ("value", "error", "rounding", "rival") if name in entry}
    ends = zip(("low", "high"), entry.get("range", ()))
    return Number(**given, **{name: end for name, end in ends if end is not None})
