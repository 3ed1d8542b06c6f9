"""What a page is: it says everything about one thing, and the house asks it.

A page registers by being a subclass of its kind with a key. The key is the name of its file, so
reading a scene imports no page that the scene does not name. Nothing at the top of a page imports
kernels: they come with the first sample.
"""

from __future__ import annotations

import importlib
import os
from collections.abc import Iterator, Mapping
from enum import Enum
from pathlib import Path
from typing import Any, ClassVar

Refusals = Iterator[tuple[str, str]]  # a key inside of its settings, or none, and what is wrong

MOST_SAMPLES = 10**7  # of one series: half a gigabyte or more
MOST_BINS = 10**6  # of a histogram, which is kept for each of some blocks of the run


class Change(Enum):
    """What a part of a scene does to the world that others take for granted.

    The value says why a page that has said nothing of it cannot stand it.
    """

    SLIDES = "takes the images of the box to stay where they are"
    STRETCHES = "takes the box to keep its size"
    ENDS = "takes the fluid to repeat along every axis"
    FLOWS = "holds in equilibrium only"
    JUMPS = "needs a force without jumps"


class Page:
    """A page; pages of a kind stand in one folder."""

    folder: ClassVar[Path]  # of the pages of this kind, each in a file that is called by its key
    package: ClassVar[str]
    key: ClassVar[str] = ""
    stands: ClassVar[frozenset[Change]] = frozenset()  # changes that it was made for
    cannot: ClassVar[Mapping[Change, str]] = {}  # why not, where `Change` does not say it best
    _pages: ClassVar[dict[str, type[Page]]]

    @classmethod
    def allows(cls, change: Change) -> bool:
        """Whether it can stand a change."""
        return change in cls.stands and change not in cls.cannot

    def __init_subclass__(cls, key: str = "", **options: Any) -> None:
        super().__init_subclass__(**options)
        if key:
            cls.key = key
            cls._pages[key] = cls


class Observable(Page):
    """Something that is measured while a system runs; see `dpd.observe`.

    Attributes
    ----------
    interval : float
        tau between samples where a scene does not say: a fraction of the time in which a bead
        moves its own size. What moves faster says so.
    dimensions : tuple of int
        In which it can be measured.
    needs_bonds : bool
        Whether there is nothing to measure where every molecule is a single bead.
    is_series : bool
        Whether every sample is kept.
    bins_of : str
        What its bins divide: ``range``, a setting, or ``box``; or none.
    suffix : str
        Of the file of its own that it writes beside the result; or none.
    """

    folder = Path(__file__).parent / "observe"
    package = "dpd.observe"
    interval: ClassVar[float] = 0.8
    dimensions: ClassVar[tuple[int, ...]] = (2, 3)
    needs_bonds: ClassVar[bool] = False
    is_series: ClassVar[bool] = False
    bins_of: ClassVar[str] = ""
    suffix: ClassVar[str] = ""
    _pages: ClassVar[dict[str, type[Page]]] = {}

    every: int
    arrays: dict[str, Any]

    def variables(self) -> dict[str, tuple[tuple[str, ...], Any, str, str]]:
        """What it has measured: name to (dimensions, array, units, long_name)."""
        raise NotImplementedError

    @classmethod
    def steps_between(cls, settings: dict[str, Any], dt: float, sample: int) -> int:
        """Steps between samples where the scene does not say, of so many that are sampled."""
        return round(cls.interval / dt)

    @classmethod
    def refuses(cls, scene: Any, settings: dict[str, Any]) -> Refusals:
        """What it cannot measure in a scene that is otherwise allowed."""
        return iter(())


def names(kind: type[Page]) -> list[str]:
    """Keys of all pages of a kind; nothing is imported."""
    files = (name for name in os.listdir(kind.folder) if name.endswith(".py"))
    return sorted(name.removesuffix(".py") for name in files if not name.startswith("_"))


def module_of(kind: type[Page], key: str) -> str:
    """The module of a page."""
    return f"{kind.package}.{key}"


def find(kind: type[Page], key: str) -> Any:
    """A page by its key, which there is."""
    if key not in kind._pages:
        importlib.import_module(module_of(kind, key))
    return kind._pages[key]


def refusals(page: type[Observable], scene: Any, made: Mapping[Change, str]) -> Refusals:
    """All that an observable has against a scene; the changes that are made, by a key of the scene.

    Yields
    ------
    tuple of str
        A key of its settings, or none where the observable itself cannot be; and what is wrong.
    """
    settings = scene.observe[page.key]
    if scene.dimension not in page.dimensions:
        yield "", f"{page.key!r} is measured in {page.dimensions[0]} dimensions only"
    if page.needs_bonds and not any(len(kind.beads) > 1 for kind in scene.molecules):
        yield "", f"{page.key!r} has nothing to measure: every molecule is a single bead"
    for change, key in made.items():
        if not page.allows(change):
            why = page.cannot.get(change, change.value)
            yield "", f"{page.key!r} {why}; not allowed with {key!r}"
    yield from _sizes(page, scene, settings)
    yield from page.refuses(scene, settings)


def _sizes(page, scene, settings):
    """Samples and bins that are too many, and intervals and bins that are too long."""
    every, steps = settings["every"], scene.watched(page.key)
    if every > steps:
        yield "every", f"{every} steps is longer than the run; allowed: 1 to {steps}"
    if page.is_series and steps // every > MOST_SAMPLES:
        least = -(-steps // MOST_SAMPLES)
        yield (
            "every",
            f"{every} makes {steps // every} samples; allowed: <= {MOST_SAMPLES}, every >= {least}",
        )
    if page.bins_of:
        bin, end = settings["bin"], settings.get("range", max(scene.box))
        if bin > end:
            yield "bin", f"{bin:g} is more than the {page.bins_of}; allowed: <= {end:g}"
        if end / bin > MOST_BINS:
            least = end / MOST_BINS
            yield (
                "bin",
                f"{bin:g} makes {end / bin:.3g} bins; allowed: <= {MOST_BINS}, bin >= {least:g}",
            )
