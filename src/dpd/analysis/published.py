"""Published numbers, which stand in paper_figures/PAPER/published.yaml alone; files of figures."""

import math
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field

from dpd.digest import paper_folder, shortened
from dpd.errors import UserError, suggestion
from dpd.page import Refusals, Section, setting
from dpd.scene.yaml import read_section, read_yaml


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
        if self.shown_in and len(set(self.shown_in)) < len(self.shown_in):
            yield "shown_in", "names a file twice; keep one"
        if self.range is not None and self.limits is None:
            yield "", "the key 'limits' is missing: who set the range"


class Shown(dict):
    """Numbers by name that one figure may show; any other name is refused with a sentence."""

    def __init__(self, numbers, paper, figure):
        super().__init__(numbers)
        self.paper, self.figure = paper, figure

    def __missing__(self, name):
        file, known = published_file(self.paper), published(self.paper)
        if name in known:
            raise UserError(
                f"{file}: {name}: {self.figure} shows it; write 'shown_in: [{self.figure}]' there, "
                "so that the figure is drawn again when the number changes"
            )
        raise UserError(
            f"{file}: {self.figure} shows {name!r}, which is not there; {suggestion(name, known)}"
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


def entries_of(paper: str, figure: str) -> dict[str, dict[str, Any]]:
    """What published.yaml says of the numbers that a figure measures, and of those it shows."""
    return {
        name: entry
        for name, entry in published(paper).items()
        if figure in (entry["figure"], *entry.get("shown_in", ()))
    }


def shown_by(file: str) -> Shown:
    """Published numbers that a figure, by its ``__file__``, measures, or that are `shown_in` it."""
    paper, figure = Path(file).parent.name, Path(file).stem
    shown = Shown({}, paper, figure)
    for name, entry in entries_of(paper, figure).items():
        low, high = entry.get("range", (None, None))
        given = {k: entry.get(k) for k in ("value", "error", "rounding", "rival")}
        given |= {"low": low, "high": high}
        shown[name] = Number(**{k: number for k, number in given.items() if number is not None})
    return shown
