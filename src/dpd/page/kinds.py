"""Pages of each kind: of what is measured, of first configurations, of what acts on beads."""

from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any, ClassVar, Self

from pydantic import ConfigDict

from dpd.page.base import (
    LARGEST_SEED,
    MOST_STEPS,
    Change,
    Page,
    Refusals,
    Section,
    check_table,
    inside,
    is_table,
    setting,
)  # fmt: skip

Given = tuple[tuple[str, ...], str, str]  # of a variable: dimensions, units, long_name
NEEDED = ("integrator", "repulsion", "thermostat")  # terms in every scene
KINDS = "sample", "block", "largest", "run", "last", "frame", "lag", "part"  # of Observable.gives
MOST_SAMPLES = 10**7  # of one series: half a gigabyte or more
SHARE = 0.05  # of a run's time, for what is measured as often as a page decides
MOST_BINS = 10**6  # of a histogram, which is kept for each of some blocks of the run


class Observable(Page):
    """Something that is measured while a system runs; see `dpd.observe`."""

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
    needs_forces: ClassVar[bool] = False  # and whether forces or energies are among them
    # Steps between samples where a scene does not say: those of `interval`, in tau, a fraction of
    # the time in which a bead moves its own size; more where samples would take longer than a
    # twentieth of the run. `cost` is how many steps of a run a sample takes as long as, as `dpd
    # bench` measures it.
    interval: ClassVar[float] = 0.8
    cost: ClassVar[float] = 4.0
    dimensions: ClassVar[tuple[int, ...]] = (2, 3)  # in which it can be measured
    needs_bonds: ClassVar[bool] = False  # or there is nothing to measure
    bins_of: ClassVar[str] = ""  # what its bins divide: "range", a setting, or "box"; or none
    suffix: ClassVar[str] = ""  # of the file of its own that it writes beside the result; or none

    every: int = setting(  # 0: `interval` decides
        "Steps between samples. If not given, so many that they take a twentieth of a run at most.",
        0, ge=1, le=MOST_STEPS,
    )  # fmt: skip

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

        Of a single variable the number or array itself. What is compared over lags has the name
        ``compared``, if there is anything else. What a scene does not have is left out.
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

    def opened(self, path: Path) -> Any:
        """The file of its own, ``now.file``."""
        return None

    def steps_between(self, scene: Any) -> int:
        """Steps between samples where the scene does not say."""
        return max(round(self.interval / scene.dt), round(self.cost_in(scene) / SHARE))

    def cost_in(self, scene: Any) -> float:
        """Steps of a run in a scene that a sample takes as long as."""
        return self.cost

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
        # Samples and bins that are too many, and intervals and bins that are too long.
        every, steps = self.every, self.watched(scene)
        if every > steps:
            yield "every", f"{every} steps is longer than the run; allowed: 1 to {steps}"
        is_series = self.suffix or any(kind == "sample" for (kind, *_), _, _ in self.gives.values())
        if is_series and steps // every > MOST_SAMPLES:
            text = f"{every} makes {steps // every} samples; allowed: <= {MOST_SAMPLES}"
            yield "every", f"{text}, every >= {-(-steps // MOST_SAMPLES)}"
        if self.bins_of:
            bin, end = (getattr(self, name, max(scene.box)) for name in ("bin", "range"))
            if bin > end:
                yield "bin", f"{bin:g} is more than the {self.bins_of}; allowed: <= {end:g}"
            if end / bin > MOST_BINS:
                text = f"{bin:g} makes {end / bin:.3g} bins; allowed: <= {MOST_BINS}"
                yield "bin", f"{text}, bin >= {end / MOST_BINS:g}"
        yield from self.refuses(scene)


class StartForces(Section):
    """Forces of growth and relaxation; under the keys of terms stand settings that differ."""

    model_config = ConfigDict(extra="allow")
    gamma: float | None = setting("Friction.", None, ge=0, le=1e6)


class Relax(Section):
    """Steps with gw-vv before the run, shared by all runs from the same start."""

    steps: int = setting("Steps of relaxation.", ge=1, le=10**9)
    dt: float = setting("Their time step.", unit="tau", ge=1e-9, le=10)


class Start(Page):
    """The first configuration."""

    package = "dpd.start"
    _pages: ClassVar[dict[str, type[Page]]] = {}
    # Steps of the engine that take about as long as it does, beside those of ``relax``. Where it
    # takes any, forces act in it, and a job of its own makes it for all runs that share it.
    work: ClassVar[int] = 0
    joins: ClassVar[int] = 3  # beads that laws along bonds join at most which act in it
    completes: ClassVar[tuple[str, ...]] = ()  # keys of a scene that it can give, see `system`

    method: str = setting("How beads are placed.", "random")
    kT: float | None = setting(
        "Temperature of the first velocities, if not the thermostat's.", None, ge=1e-6, le=1e6
    )
    seed: int | None = setting(
        "Seed of the start, if not that of the run.", None, ge=0, le=LARGEST_SEED
    )
    forces: StartForces = setting(
        "Forces of growth and relaxation, where they are not those of the run: gamma, and under "
        "their key settings of a rigid core, of bonds and of angles, as {bond: {stiffness: 100}}.",
        StartForces,
    )  # fmt: skip
    relax: Relax | None = setting(str(Relax.__doc__), None)

    def conflicts(self) -> Refusals:
        if self.forces != StartForces() and not self.acts:
            text = "has no effect: nothing is relaxed or grown; add start.relax, as {steps: 1000, "
            yield "forces", f"{text}dt: 0.01}}, or remove the key"

    @property
    def acts(self) -> bool:
        """Whether forces act while it is made."""
        return bool(self.work) or self.relax is not None

    def system(self, where: str, words: Collection[str]) -> dict[str, Any]:
        """Values of what it ``completes``, where a scene of these words has none."""
        return {}

    def own(self) -> dict[str, Any]:
        """The settings that this page has and not every start, as plain data."""
        return {key: each for key, each in self.plain().items() if key not in Start.model_fields}

    def decides(self, scene: Any) -> dict[str, Any]:
        """What decides the places of beads, beside box, molecules, seed and walls."""
        return {"settings": self.own()}

    def positions(self, scene: Any, rng: Any) -> Any:
        """(beads, dimension) array of places, molecule after molecule, each from 0 to the box.

        The random numbers, `numpy.random.Generator`, are of the start's seed.
        """
        raise NotImplementedError

    def velocities(self, scene: Any, rng: Any) -> Any:
        """(beads, dimension) array in r_c / tau, about a flow of shear; None for thermal ones."""
        return None

    def make(self, scene: Any, progress: Any, say: Any) -> Any:
        """A `dpd.engine.state.State`, of one that does more than to place beads.

        ``progress``, or None, is called with the number of beads in molecules, then of steps more;
        ``say`` with a sentence for what a person should know.
        """
        return None

    def stand_in(self) -> dict[str, Any]:
        """A start that takes no time, for what only compiles kernels or times them."""
        return {"seed": self.seed or 1} if self.work else self.plain()

    def tiny(self, scene: Any) -> dict[str, Any]:
        """What to change in a scene so that it compiles all kernels of the start in no time."""
        return {}


class Term(Page):
    """Something that acts on beads or on the box; its key is a section of the scene."""

    package = "dpd.physics"
    _pages: ClassVar[dict[str, type[Page]]] = {}
    stands = frozenset(Change)
    makes: ClassVar[frozenset[Change]] = frozenset()  # what it does to the world; see `changes`
    barostat_axes: ClassVar[str] = ""  # along which it stretches the box: "all", one, or none
    # what it is there for, by which the axes come first that the fluid changes across
    mainly: ClassVar[Change | None] = None
    in_kernels: ClassVar[bool] = True  # whether kernels know it
    in_start: ClassVar[bool] = False  # whether it acts while a start grows and relaxes
    own_in_start: ClassVar[bool] = False  # and has other settings there, under ``start.forces``
    joins: ClassVar[int] = 0  # beads along bonds that a law of it joins; 0 if it is none of bonds
    # why scheme ``auto``, whose table was measured without it, cannot choose a step
    untried: ClassVar[str] = ""
    keeps_apart: ClassVar[bool] = False  # beads that attract each other: repulsions may be < 0
    usual: ClassVar[float | str] = "..."  # an example from its tables; "" if values may be missing
    # Why it cannot act in LAMMPS. Nothing where its lines do, or the table of what acts between
    # pairs beyond the soft repulsion.
    not_in_lammps: ClassVar[str] = "has no lines here for an input of LAMMPS"
    # What captions say of it, with its settings in braces; what stands in brackets is left out
    # where they are as by default. If not given, its settings by name; None for nothing.
    caption: ClassVar[str | None] = ""

    def changes(self, scene: Any) -> frozenset[Change]:
        """What it does to the world in a scene."""
        return self.makes

    def may_become(self, other: Any) -> bool:
        """Whether it may have the settings of another one of its kind while the system runs."""
        return True

    def unknown(self, scene: Any) -> Refusals:
        """Tables by pairs, or along bonds, that do not fit the species."""
        there = scene.species_along(self.joins) if self.joins else scene.pairs
        for name, table in self.tables().items():
            yield from inside(name, check_table(table, scene, there, self.usual))

    def completed(self, scene: Any) -> Self:
        """Itself, with what its settings leave to the scene."""
        return self

    def gap(self, scene: Any, axis: int) -> float:
        """How far behind the box, on either side of an axis, there is room for beads, in r_c."""
        return 0.0

    def room(self, scene: Any) -> tuple[float, ...]:
        """The least distances that images of a bead may have along each axis, in r_c."""
        return tuple(scene.period)

    def across(self, scene: Any) -> tuple[int, ...]:
        """The axes across which the fluid changes because of it."""
        return ()

    def brakes(self, scene: Any) -> bool:
        """Whether it takes up momentum, along all axes, by a friction with what is no bead."""
        return False

    def repulsions(self, scene: Any) -> Mapping[str, float]:
        """Largest repulsions a_ij that it gives, by pairs of species as "A B"."""
        return {}

    def notes(self, scene: Any) -> Iterator[str]:
        """Sentences for a person on what it makes of the scene."""
        return iter(())

    def controlled_pressure(self, values: Mapping[str, Any]) -> tuple[Any, float]:
        """The series of a pressure that it holds, out of what a run measured; and at what value."""
        return None, 0.0

    def tables(self) -> dict[str, dict[str, Any]]:
        """Its tables by the names of their settings; a bare one by no name."""
        return {name if name != self.bare else "": each for name, each in self if is_table(each)}

    def between(self, one: str, other: str) -> Self:
        """Itself, with the numbers of one pair of species in the place of its tables."""
        pair, back = f"{one} {other}", f"{other} {one}"
        numbers = {key: each.get(pair, each.get(back)) for key, each in self.tables().items()}
        return self.model_copy(update={key or self.bare: value for key, value in numbers.items()})

    def records(self, scene: Any) -> dict[str, Any]:
        """What kernels get of it, by names of `dpd.engine.state.System`."""
        return {}

    def lammps(self, scene: Any) -> list[str] | str:
        """Its lines in an input of LAMMPS, see `dpd.lammps.input`; or why it cannot act there."""
        return self.not_in_lammps or []


class PairForce(Term):
    """A conservative force between pairs of a user's own, beside the repulsion.

    In its formulas a setting is the number of the pair at hand (``self.depth``), r is the distance
    in r_c, and w = 1 - r. They are plain Python with `math`, and end at the cutoff, r = 1.
    Functions that they call are marked with `part`.
    """

    not_in_lammps = ""
    in_start = True
    usual: ClassVar[float | str] = 1
    untried = "schemes were measured without {key!r}; take gw-vv and try dt"

    def force(self, r: float, w: float) -> float:
        """Minus the slope of the energy, in kT / r_c; positive where beads are pushed apart."""
        raise NotImplementedError

    def energy(self, r: float, w: float) -> float:
        """Energy in kT."""
        raise NotImplementedError

    def numbers(self, scene: Any) -> dict[str, Any]:
        """What formulas see as ``self``: numbers, columns by pairs of species, larger arrays."""
        return {
            name: scene.by_pair(each).ravel() if is_table(each) else each
            for name, each in self if is_table(each) or isinstance(each, int | float)
        }  # fmt: skip


class BondedForce(Term):
    """Laws along bonds, of two beads or of three in a row: one for all, or by their species."""

    in_start = True
    own_in_start = True
    joins = 2
    nowhere: ClassVar[str] = (  # where molecules have none of the bonds, or angles, that it is for
        "every molecule is a single bead; remove the key, or give an architecture of several "
        "beads, as 'A 10'"
    )

    def unknown(self, scene: Any) -> Refusals:
        if scene.species_along(self.joins):
            yield from super().unknown(scene)
        else:
            yield "", self.nowhere

    def laws(self, scene: Any) -> dict[str, Any]:
        """Pages of numbers by the species that they join; one for all by no name."""
        law = getattr(self, self.bare) if self.bare else self
        if isinstance(law, dict):
            return law
        if self.bare or not self.tables():
            return {"": law}
        return {" ".join(pair): self.between(*pair) for pair in scene.species_along(2)}


class BondForce(BondedForce):
    """A law of bonds; a scene names one of those that there are.

    As in a `PairForce` a setting is the number of the bond at hand, and formulas are plain Python
    with `math`; r is the length in r_c. A page may have a ``curvature(r)``, the slope of the slope
    of the energy, instead of a difference of forces.
    """

    untried = "schemes were measured with 'bond', not {key!r}; take gw-vv and try dt"
    example: ClassVar[str] = ""  # of its section, for who needs bonds and has none

    def force(self, r: float) -> float:
        """Minus the slope of the energy, in kT / r_c; positive where the ends are pushed apart."""
        raise NotImplementedError

    def energy(self, r: float) -> float:
        """Energy in kT."""
        raise NotImplementedError

    def at_rest(self) -> float:
        """Length of bonds in a random start, in r_c: that of least energy; 0 if any may do."""
        from dpd.page.laws import least_energy

        return least_energy(self)
