"""Pages of what is measured while a system runs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, ClassVar

from dpd.page.base import PACKAGE, Change, Page, Refusals, interval_setting

if TYPE_CHECKING:
    from pathlib import Path
    from typing import Self

Given = tuple[tuple[str, ...], str, str]  # of a variable: dimensions, units, long_name
KINDS = "sample", "block", "largest", "run", "last", "frame", "lag", "part"  # of Observable.gives
MOST_SAMPLES = 10**7  # of one series: half a gigabyte or more
MOST_BINS = 10**6  # of a histogram, which is kept for each of some blocks of the run


class Observable(Page):
    """Something that is measured while a system runs; see `dpd.observe`."""

    folder = PACKAGE / "observe"
    package = "dpd.observe"
    _pages: ClassVar[dict[str, type[Page]]] = {}

    # What it writes, by name: dimensions, units, long_name. The first dimension says what is kept
    # of what `measure` finds: "sample", all of it; "block", means over blocks of the run;
    # "largest", the largest in each block, of numbers of 0 or more; "run", the mean over the run;
    # "last", what was found last; "frame", means over `average` samples each; "lag", averages over
    # pairs of samples that lie some time apart, see `compare`. One of a name that begins with an
    # underscore is kept for `finish` alone.
    gives: ClassVar[Mapping[str, Given]] = {}
    only_with: ClassVar[Mapping[str, Change]] = {}  # those that only scenes have that change so
    # Names in the file of the dimension of "sample", "frame" or "lag", and of their times; if not
    # given, KEY_sample and KEY_time, KEY_lag and KEY_lag_time.
    over: ClassVar[Mapping[str, tuple[str, str]]] = {}
    from_first: ClassVar[bool] = False  # whether times of samples are those since the first one
    single: ClassVar[frozenset[str]] = frozenset()  # names of what is kept in single precision
    compared: ClassVar[tuple[str, ...]] = ()  # dimensions of what lags compare, molecules last
    # Whether it measures sums over beads and pairs, which kernels take of many samples at once:
    # `measure` then gets `dpd.observe.common.measured.Sampled`, and what it finds has an axis of
    # samples in front. Every sample is kept.
    of_sums: ClassVar[bool] = False
    # tau between samples where a scene does not say: a fraction of the time in which a bead moves
    # its own size. What moves faster says so.
    interval: ClassVar[float] = 0.8
    dimensions: ClassVar[tuple[int, ...]] = (2, 3)  # in which it can be measured
    needs_bonds: ClassVar[bool] = False  # or there is nothing to measure
    bins_of: ClassVar[str] = ""  # what its bins divide: "range", a setting, or "box"; or none
    suffix: ClassVar[str] = ""  # of the file of its own that it writes beside the result; or none

    every: int = interval_setting("Steps between samples.")

    def shaped(self, now: Any) -> Self:
        """Itself, with what follows from the configuration in which a run begins."""
        return self

    def given(self, scene: Any) -> dict[str, Given]:
        """Those of ``gives`` that it has in a scene."""
        missing = {name for name, change in self.only_with.items() if change not in scene.made}
        return {name: given for name, given in self.gives.items() if name not in missing}

    def axes(self, scene: Any) -> Mapping[str, Any]:
        """Coordinates of what it gives, by dimension: values, units, long_name; or their number.

        Those along other dimensions than their name say them behind that. ``axis`` and ``axis2``,
        ``bead``, ``molecule``, ``kind`` (of molecules) and ``species`` are there already.
        """
        return {}

    def keeps(self, scene: Any) -> Mapping[str, Any]:
        """Arrays that stay from sample to sample, as ``now.kept``, and in checkpoints."""
        return {}

    def measure(self, now: Any) -> Any:
        """What it sees in a `dpd.observe.common.snapshot.Snapshot`: each of ``gives`` by name.

        A number or an array for one that gives a single variable. What is compared over lags has
        the name ``compared``, if there is anything else. What a scene does not have is left out.
        """
        raise NotImplementedError

    def compare(self, now: Any, then: Any) -> Any:
        """A sample with some earlier ones, which have an axis in front: a result for each molecule.

        A (earlier, quantities, molecules) array; quantities are those over ``lag`` that it gives.
        Beside their means it may give how many pairs of samples end in each part of the run, and
        the sums of each quantity over these, mean over molecules: over ``part`` and ``lag``, in
        this order.
        """
        raise NotImplementedError

    def finish(self, scene: Any, found: dict[str, Any]) -> Mapping[str, Any]:
        """What of that goes into the file, where it is not that: as ratios of means."""
        return found

    def needs_forces(self) -> bool:
        """Whether it reads forces or energies, if it measures sums."""
        return False

    def opened(self, path: Path) -> Any:
        """The file of its own, ``now.file``."""
        return None

    def file_bytes(self, scene: Any) -> int:
        """Its size in the end."""
        return 0

    def steps_between(self, scene: Any) -> int:
        """Steps between samples where the scene does not say."""
        return round(self.interval / scene.dt)

    def watched(self, scene: Any) -> int:
        """Steps of the run that it looks at."""
        return int(scene.steps.sample)

    def refusals(self, scene: Any, made: Mapping[Change, str]) -> Refusals:
        """All that it has against a scene; the changes that are made, by a key of the scene."""
        if scene.dimension not in self.dimensions:
            yield "", f"{self.key!r} is measured in {self.dimensions[0]} dimensions only"
        if self.needs_bonds and not any(len(kind.beads) > 1 for kind in scene.molecules):
            yield "", f"{self.key!r} has nothing to measure: every molecule is a single bead"
        for change, key in made.items():
            if why := self.why_not(change):
                yield "", f"{self.key!r} {why}; not allowed with {key!r}"
        yield from self._sizes(scene)
        yield from self.refuses(scene)

    def _sizes(self, scene):
        """Samples and bins that are too many, and intervals and bins that are too long."""
        every, steps = self.every, self.watched(scene)
        if every > steps:
            yield "every", f"{every} steps is longer than the run; allowed: 1 to {steps}"
        is_series = self.suffix or any(kind == "sample" for (kind, *_), _, _ in self.gives.values())
        if is_series and steps // every > MOST_SAMPLES:
            text = f"{every} makes {steps // every} samples; allowed: <= {MOST_SAMPLES}"
            yield "every", f"{text}, every >= {-(-steps // MOST_SAMPLES)}"
        if self.bins_of:
            bin, end = self.bin, getattr(self, "range", max(scene.box))
            if bin > end:
                yield "bin", f"{bin:g} is more than the {self.bins_of}; allowed: <= {end:g}"
            if end / bin > MOST_BINS:
                text = f"{bin:g} makes {end / bin:.3g} bins; allowed: <= {MOST_BINS}"
                yield "bin", f"{text}, bin >= {end / MOST_BINS:g}"
