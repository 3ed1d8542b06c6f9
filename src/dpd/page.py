"""What a page is: it says everything about one thing, and the house asks it.

A page is a class in a file of its own: its settings, what it does to the world, and what it cannot
be combined with. It registers by being a subclass of its kind with a key. The key is the name of
its file, so reading a scene imports no page that the scene does not name. Nothing at the top of a
page imports Numba: kernels come with the first step.
"""

from __future__ import annotations

import importlib
import os
from collections.abc import Callable, Iterator, Mapping
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, TypeVar

# To look for plugins of pydantic among all installed packages takes 8 ms.
os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag, field_validator

if TYPE_CHECKING:
    from typing import Self

Refusals = Iterator[tuple[str, str]]  # a key inside of its settings, or none, and what is wrong
Given = tuple[tuple[str, ...], str, str]  # of a variable: dimensions, units, long_name

MOST_SAMPLES = 10**7  # of one series: half a gigabyte or more
MOST_BINS = 10**6  # of a histogram, which is kept for each of some blocks of the run
MOST_STEPS = 10**12
LARGEST_SEED = 2**63 - 1


class Change(Enum):
    """What a part of a scene does to the world that others take for granted.

    The value says why a page that has said nothing of it cannot stand it.
    """

    SLIDES = "takes the images of the box to stay where they are"
    STRETCHES = "takes the box to keep its size"
    ENDS = "takes the fluid to repeat along every axis"
    FLOWS = "holds in equilibrium only"
    JUMPS = "needs a force without jumps"
    PACE = "needs steps of one length while it samples"


# --- settings

N = TypeVar("N")
SPECIES, PAIR, TRIPLE = r"^\S+$", r"^\S+ \S+$", r"^\S+ \S+ \S+$"
# What a key of a table is, by its pattern, for messages.
NAMES = {
    SPECIES: "a species, as 'A'", PAIR: "a pair of species, as 'A B'",
    TRIPLE: "three species along two bonds, as 'A B C'",
}  # fmt: skip
Species = Annotated[str, Field(pattern=SPECIES)]
Pair = Annotated[str, Field(pattern=PAIR)]
Triple = Annotated[str, Field(pattern=TRIPLE)]


# Which branch a value is meant for, by its kind: so only errors of that are told.
OR_TABLE = Discriminator(lambda value: "=table" if isinstance(value, dict | BaseModel) else "=one")
OR_LIST = Discriminator(lambda value: "=list" if isinstance(value, list) else "=one")
_One = Annotated[N, Tag("=one")]
_PerSpecies = Annotated[dict[Species, N], Field(min_length=1), Tag("=table")]
_PerPair = Annotated[dict[Pair, N], Field(min_length=1), Tag("=table")]
PerSpecies = Annotated[_One[N] | _PerSpecies[N], OR_TABLE]
PerPair = Annotated[_One[N] | _PerPair[N], OR_TABLE]
OneOrMore = Annotated[_One[N] | Annotated[list[N], Field(min_length=1), Tag("=list")], OR_LIST]
PairTable = Annotated[dict[Pair, N], Field(min_length=1)]
Axis = Literal["x", "y", "z"]
K = TypeVar("K")
_Laws = Annotated[dict[K, N], Field(min_length=1), Tag("=table")]
OneOrTable = Annotated[
    _One[N] | _Laws[K, N], Discriminator(lambda value: "=table" if is_table(value) else "=one")
]
Positive = Annotated[float, Field(gt=0, le=1e6)]
NotNegative = Annotated[float, Field(ge=0, le=1e6)]


def is_table(value: object) -> bool:
    """Whether something is a law for each pair or triple of species, not one for all."""
    return isinstance(value, dict) and any(" " in str(key) for key in value)


def setting(text: str, default: Any = ..., unit: str = "", of: str = "", **bounds: Any) -> Any:
    """A setting: what it is, its default, its unit, and bounds as pydantic has them.

    Parameters
    ----------
    of : str
        What it names or is given for, which a scene must have: ``axis``, ``species`` (a value for
        each, if it is a table), or ``some species``.
    """
    extra: Any = {key: value for key, value in {"unit": unit, "of": of}.items() if value}
    given = {"default_factory": default} if callable(default) else {"default": default}
    return Field(description=text, json_schema_extra=extra or None, **given, **bounds)


def interval_setting(text: str) -> Any:
    """How many steps lie between samples; if it is not given, the page's interval decides."""
    return setting(text, 0, ge=1, le=MOST_STEPS)  # 0: the page decides


class Section(BaseModel):
    """Settings: nothing unknown, nothing converted, no infinity, never changed."""

    model_config = ConfigDict(
        frozen=True, extra="forbid", strict=True, allow_inf_nan=False, defer_build=True,
        validate_default=False,
    )  # fmt: skip

    @field_validator("*", mode="before")
    @classmethod
    def _given(cls, value):
        """Nothing behind a colon is not the same as a key that is left out."""
        if value is None:
            raise ValueError("None (nothing after the colon) where a value is needed")
        return value

    def conflicts(self) -> Refusals:
        """What its settings have against each other, whatever the scene."""
        return iter(())


# --- pages


class Page(Section):
    """A page; pages of a kind stand in one folder.

    Attributes
    ----------
    bare : str
        The setting that the whole section stands for, if it is no table of settings.
    stands : frozenset of Change
        Changes that it was made for.
    cannot : dict of Change to str
        Why not, where `Change` does not say it best.
    """

    folder: ClassVar[Path]  # each page in a file that is called by its key
    package: ClassVar[str]
    key: ClassVar[str] = ""
    bare: ClassVar[str] = ""
    stands: ClassVar[frozenset[Change]] = frozenset()
    cannot: ClassVar[Mapping[Change, str]] = {}
    _pages: ClassVar[dict[str, type[Page]]]

    @classmethod
    def allows(cls, change: Change) -> bool:
        """Whether it can stand a change."""
        return change in cls.stands and change not in cls.cannot

    @classmethod
    def why_not(cls, change: Change) -> str:
        """Why it cannot stand a change."""
        return cls.cannot.get(change, change.value)

    @classmethod
    def has_required(cls) -> bool:
        """Whether a setting has no default."""
        return any(field.is_required() for field in cls.model_fields.values())

    def plain(self) -> Any:
        """Its settings as plain data, as they stand in a file."""
        data = self.model_dump(exclude_none=True, by_alias=True)
        return data[self.bare] if self.bare else data

    @classmethod
    def summary(cls) -> str:
        """Its description in one sentence."""
        return " ".join((cls.__doc__ or "").split("\n\n")[0].split())

    def __init_subclass__(cls, key: str = "", **options: Any) -> None:
        super().__init_subclass__(**options)
        if key:
            cls.key = key
        if key and cls.__module__ == f"{cls.package}.{key}":  # others belong to the scene's files
            cls._pages[key] = cls

    @classmethod
    def __pydantic_init_subclass__(cls, key: str = "", **options: Any) -> None:
        """Pydantic hands on the words of the class line, all of which are used by now."""


class Term(Page):
    """Something that acts on beads or on the box; its key is a section of the scene.

    Attributes
    ----------
    mainly : Change or None
        What it is there for, by which the axes come first that the fluid changes across.
    makes : frozenset of Change
        What it does to the world; see `changes`.
    in_kernels : bool
        Whether kernels know it.
    in_start : bool
        Whether it acts while a start grows and relaxes, as it does in the run.
    keeps_apart : bool
        Whether it keeps beads apart that attract each other otherwise: repulsions may be negative.
    """

    folder = Path(__file__).parent / "physics"
    package = "dpd.physics"
    _pages: ClassVar[dict[str, type[Page]]] = {}
    stands = frozenset(Change)
    mainly: ClassVar[Change | None] = None
    makes: ClassVar[frozenset[Change]] = frozenset()
    in_kernels: ClassVar[bool] = True
    in_start: ClassVar[bool] = False
    keeps_apart: ClassVar[bool] = False

    def changes(self, scene: Any) -> frozenset[Change]:
        """What it does to the world in a scene."""
        return self.makes

    def unknown(self, scene: Any) -> Refusals:
        """Tables that do not fit the species, but for settings that say what they are ``of``."""
        return iter(())

    def refuses(self, scene: Any) -> Refusals:
        """What it cannot stand: boxes, numbers of beads, other settings."""
        return iter(())

    def found(self, folder: str | Path, where: str) -> Self:
        """Itself, once it has looked at the files that it names, from a folder on."""
        return self

    def content(self) -> Any:
        """Its settings as far as they decide a run: of a file what is in it, not where it lies."""
        return self.plain()

    def completed(self, scene: Any) -> Self:
        """Itself, with what its settings leave to the scene."""
        return self

    def gap(self, scene: Any, axis: int) -> float:
        """How far behind the box, on either side of an axis, there is room for beads, in r_c."""
        return 0.0

    def room(self, scene: Any) -> tuple[float, ...]:
        """The least distances that images of a bead may have along each axis, in r_c."""
        return tuple(scene.period)

    def stretched(self) -> str:
        """The axes along which it changes the size of the box: ``all``, one of them, or nothing."""
        return ""

    def across(self, scene: Any) -> tuple[int, ...]:
        """The axes across which the fluid changes because of it."""
        return ()

    def brakes(self, scene: Any) -> bool:
        """Whether it takes up momentum, along all axes, by a friction with what is no bead."""
        return False

    def is_no_pair(self, scene: Any) -> bool:
        """Whether it is a friction with what is no pair: then pairs exchange no momentum."""
        return self.brakes(scene)

    def modules(self, scene: Any) -> tuple[str, ...]:
        """Modules that act in a scene because of it, beside its own, and in no scene else."""
        return ()

    def repulsions(self, scene: Any) -> Mapping[str, float]:
        """Largest repulsions a_ij that it gives, by pairs of species as "A B"."""
        return {}

    def notes(self, scene: Any) -> Iterator[str]:
        """Sentences for a person on what it makes of the scene."""
        return iter(())

    def untried(self) -> str:
        """Why scheme ``auto``, whose table was measured without it, cannot choose a step."""
        return ""

    def held(self, values: Mapping[str, Any]) -> tuple[Any, float]:
        """The series of a pressure that it holds, out of what a run measured; and at what value."""
        return None, 0.0

    def record(self, scene: Any) -> Any:
        """What kernels get; None where nothing of it acts."""
        return None


class PairForce(Term):
    """A conservative force between pairs of a user's own, beside the repulsion.

    In its formulas a setting is the number of the pair at hand (``self.depth``), whether a scene
    gives one for all or a table by pairs of species; r is the distance in r_c and w = 1 - r. They
    are plain Python with `math`, and end at the cutoff, r = 1. Functions that they call are marked
    with `part`.
    """

    def force(self, r: float, w: float) -> float:
        """Minus the slope of the energy, in kT / r_c; positive where beads are pushed apart."""
        raise NotImplementedError

    def energy(self, r: float, w: float) -> float:
        """Energy in kT."""
        raise NotImplementedError

    def unknown(self, scene: Any) -> Refusals:
        """Tables that have not a value for each pair of species."""
        for name in type(self).model_fields:
            if isinstance(value := getattr(self, name), dict):
                yield from scene.check_pairs(name, value, 1)

    def modules(self, scene: Any) -> tuple[str, ...]:
        """What adds it to the repulsion."""
        return ("dpd.physics.common.own_pairs",)

    def numbers(self, scene: Any) -> dict[str, Any]:
        """What its formulas see as ``self``, where that is not its settings.

        Numbers, columns with one for each pair of species, and arrays of more dimensions.
        """
        return {}

    def untried(self) -> str:
        """Without it is how schemes were measured."""
        return f"schemes were measured without {self.key!r}; take gw-vv and try dt"


class BondForce(Term):
    """A law of bonds; a scene names one of those that there are.

    As in a `PairForce` a setting is the number of the bond at hand, whether a scene gives one for
    all or a table by pairs of species that are bonded, and formulas are plain Python with `math`; r
    is the length in r_c. A page may have a ``curvature(r)``, the slope of the slope of the energy,
    instead of a difference of forces.

    Attributes
    ----------
    caption : str
        The law in captions, with its settings in braces; if not given, its settings by name.
    """

    caption: ClassVar[str] = ""

    def force(self, r: float) -> float:
        """Minus the slope of the energy, in kT / r_c; positive where the ends are pushed apart."""
        raise NotImplementedError

    def energy(self, r: float) -> float:
        """Energy in kT."""
        raise NotImplementedError

    def at_rest(self) -> float:
        """Length of bonds in a random start, in r_c, of a law of numbers; 0 if any may do.

        If not given, it is that of least energy.
        """
        from dpd.laws import least_energy

        return least_energy(self)

    def laws(self, scene: Any) -> dict[str, Any]:
        """What acts along bonds, by pairs of species: pages of numbers; one for all by no name."""
        from dpd.laws import laws_of_page

        return laws_of_page(self, scene)

    def changed(self, given: dict[str, Any]) -> Any:
        """Its settings as plain data, with some others in the place of its own."""
        return self.plain() | given

    def tables(self) -> dict[str, dict[str, Any]]:
        """Its tables by pairs of bonded species, by settings."""
        fields = {name: getattr(self, name) for name in type(self).model_fields}
        return {name: value for name, value in fields.items() if isinstance(value, dict)}

    def unknown(self, scene: Any) -> Refusals:
        """Pairs that are not bonded, and bonded ones without a value."""
        if not scene.has_bonds:
            text = "every molecule is a single bead; remove the key, or give an architecture of"
            yield "", f"{text} several beads, as 'A 10'"
            return
        for name, table in self.tables().items():
            for pair, problem in check_bonded(table, scene.bonded_species):
                yield ".".join(filter(None, (name, pair))), problem

    def refuses(self, scene: Any) -> Refusals:
        """Bonds that are too long for the box."""
        from dpd.laws import too_long

        yield from too_long(self.laws(scene), scene)

    def untried(self) -> str:
        """With harmonic bonds is how schemes were measured."""
        return f"schemes were measured with 'bond', not {self.key!r}; take gw-vv and try dt"


class Observable(Page):
    """Something that is measured while a system runs; see `dpd.observe`.

    Attributes
    ----------
    gives : dict of str to tuple
        What it writes, by name: dimensions, units, long_name. The first dimension says what is kept
        of what `measure` finds: ``sample``, all of it; ``block``, means over blocks of the run;
        ``largest``, the largest in each block, of numbers of 0 or more; ``run``, the mean over the
        run; ``last``, what was found last; ``frame``, means over ``average`` samples each; ``lag``,
        averages over pairs of samples that lie some time apart, see `compare`. One of a name that
        begins with an underscore is kept for `finish` alone.
    only_with : dict of str to Change
        Names of those that only scenes have in which something makes a change.
    over : dict of str to (str, str)
        Names in the file of the dimension of ``sample``, ``frame`` or ``lag``, and of their times;
        if not given, ``KEY_sample`` and ``KEY_time``, ``KEY_lag`` and ``KEY_lag_time``.
    from_first : bool
        Whether the time of a sample is that since the first one.
    single : frozenset of str
        Names of what is kept in single precision.
    compared : tuple of str
        Dimensions of what is compared over lags, molecules last.
    of_sums : bool
        Whether it measures sums over beads and pairs, which kernels take of many samples at once:
        `measure` then gets `dpd.observe.common.measured.Sampled`, and what it finds has an axis of
        samples in front. Every sample is kept.
    interval : float
        tau between samples where a scene does not say: a fraction of the time in which a bead
        moves its own size. What moves faster says so.
    dimensions : tuple of int
        In which it can be measured.
    needs_bonds : bool
        Whether there is nothing to measure where every molecule is a single bead.
    bins_of : str
        What its bins divide: ``range``, a setting, or ``box``; or none.
    suffix : str
        Of the file of its own that it writes beside the result; or none.
    """

    folder = Path(__file__).parent / "observe"
    package = "dpd.observe"
    _pages: ClassVar[dict[str, type[Page]]] = {}
    gives: ClassVar[Mapping[str, Given]] = {}
    only_with: ClassVar[Mapping[str, Change]] = {}
    over: ClassVar[Mapping[str, tuple[str, str]]] = {}
    from_first: ClassVar[bool] = False
    single: ClassVar[frozenset[str]] = frozenset()
    compared: ClassVar[tuple[str, ...]] = ()
    of_sums: ClassVar[bool] = False
    interval: ClassVar[float] = 0.8
    dimensions: ClassVar[tuple[int, ...]] = (2, 3)
    needs_bonds: ClassVar[bool] = False
    bins_of: ClassVar[str] = ""
    suffix: ClassVar[str] = ""

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

    def refuses(self, scene: Any) -> Refusals:
        """What it cannot measure in a scene that is otherwise allowed."""
        return iter(())

    def refusals(self, scene: Any, made: Mapping[Change, str]) -> Refusals:
        """All that it has against a scene; the changes that are made, by a key of the scene."""
        if scene.dimension not in self.dimensions:
            yield "", f"{self.key!r} is measured in {self.dimensions[0]} dimensions only"
        if self.needs_bonds and not any(len(kind.beads) > 1 for kind in scene.molecules):
            yield "", f"{self.key!r} has nothing to measure: every molecule is a single bead"
        for change, key in made.items():
            if not self.allows(change):
                yield "", f"{self.key!r} {self.why_not(change)}; not allowed with {key!r}"
        yield from self._sizes(scene)
        yield from self.refuses(scene)

    def _sizes(self, scene):
        """Samples and bins that are too many, and intervals and bins that are too long."""
        every, steps = self.every, self.watched(scene)
        if every > steps:
            yield "every", f"{every} steps is longer than the run; allowed: 1 to {steps}"
        is_series = self.suffix or any(kind == "sample" for (kind, *_), _, _ in self.gives.values())
        if is_series and steps // every > MOST_SAMPLES:
            least = -(-steps // MOST_SAMPLES)
            text = f"{every} makes {steps // every} samples; allowed: <= {MOST_SAMPLES}, every >= "
            yield "every", f"{text}{least}"
        if self.bins_of:
            bin, end = self.bin, getattr(self, "range", max(scene.box))
            if bin > end:
                yield "bin", f"{bin:g} is more than the {self.bins_of}; allowed: <= {end:g}"
            if end / bin > MOST_BINS:
                least = end / MOST_BINS
                text = f"{bin:g} makes {end / bin:.3g} bins; allowed: <= {MOST_BINS}, bin >= "
                yield "bin", f"{text}{least:g}"


class StartCore(Section):
    """Rigid core, as above."""

    radius: float | None = setting(
        "Core radius r_s; 0 for none.", None, unit="r_c", ge=0, lt=0.5
    )  # fmt: skip
    force: float | None = setting("Force F_max.", None, unit="kT / r_c", ge=0, le=1e6)
    smooth: float | None = setting("Width of its edge.", None, unit="r_c", ge=0, le=1)


class StartForces(Section):
    """Forces of growth and relaxation, where they are not those of the run.

    A scene's bonds have their key here as well, with the settings that are others.
    """

    model_config = ConfigDict(extra="allow")
    core: StartCore | None = setting("Rigid core, as above.", None)
    gamma: float | None = setting("Friction.", None, ge=0, le=1e6)


class Relax(Section):
    """Steps with gw-vv before the run, shared by all runs from the same start."""

    steps: int = setting("Steps of relaxation.", ge=1, le=10**9)
    dt: float = setting("Their time step.", unit="tau", ge=1e-9, le=10)


class Start(Page):
    """The first configuration.

    Attributes
    ----------
    work : int
        Steps of the engine that take about as long as it does, beside those of ``relax``. Where it
        takes any, forces act in it, and a job of its own makes it for all runs that share it.
    without : tuple of str
        Terms that do not act in it.
    records : dict of str to tuple
        What it tells of how it came about, by name: dimensions, units, long_name.
    places : tuple of str
        Settings that say where something lies, which decides nothing.
    """

    folder = Path(__file__).parent / "start"
    package = "dpd.start"
    _pages: ClassVar[dict[str, type[Page]]] = {}
    work: ClassVar[int] = 0
    without: ClassVar[tuple[str, ...]] = ()
    records: ClassVar[Mapping[str, tuple[tuple[str, ...], str, str]]] = {}
    places: ClassVar[tuple[str, ...]] = ()

    method: str = setting("How beads are placed.", "random")
    kT: float | None = setting(
        "Temperature of the first velocities, if not the thermostat's.", None, ge=1e-6, le=1e6
    )
    seed: int | None = setting(
        "Seed of the start, if not that of the run.", None, ge=0, le=LARGEST_SEED
    )
    forces: StartForces = setting(
        "Forces of growth and relaxation, where they are not those of the run: core, gamma, and "
        "under their key settings of the scene's bonds, as {bond: {stiffness: 100}}.", StartForces,
    )  # fmt: skip
    relax: Relax | None = setting(
        "Steps with gw-vv before the run, shared by all runs from the same start.", None
    )

    def conflicts(self) -> Refusals:
        """Forces that never act."""
        if self.forces != StartForces() and not self.acts:
            yield (
                "forces",
                "has no effect: nothing is relaxed or grown; add start.relax, as {steps: 1000, "
                "dt: 0.01}, or remove the key",
            )

    @property
    def acts(self) -> bool:
        """Whether forces act while it is made."""
        return bool(self.work) or self.relax is not None

    def own(self) -> dict[str, Any]:
        """The settings that this page has and not every start, as plain data."""
        data = self.model_dump(exclude_none=True, by_alias=True)
        return {key: value for key, value in data.items() if key not in Start.model_fields}

    def found(self, folder: str | Path, where: str) -> Self:
        """Itself, once it has looked at the files that it names, from a folder on."""
        return self

    def refuses(self, scene: Any) -> Refusals:
        """What it cannot begin."""
        return iter(())

    def decides(self, scene: Any) -> dict[str, Any]:
        """What decides the places of beads, beside box, molecules, seed and walls."""
        return {"settings": self.own()}

    def positions(self, scene: Any, rng: Any) -> Any:
        """(beads, dimension) array of places, molecule after molecule, each from 0 to the box.

        Parameters
        ----------
        rng : numpy.random.Generator
            Of the start's seed.
        """
        raise NotImplementedError

    def velocities(self, scene: Any, rng: Any) -> Any:
        """(beads, dimension) array in r_c / tau, about a flow of shear; None for thermal ones."""
        return None

    def make(self, scene: Any, progress: Any, say: Any) -> Any:
        """A `dpd.engine.state.State` and its records, of one that does more than to place beads.

        Parameters
        ----------
        progress : callable or None
            Called with the number of beads that are in their molecules, then of steps more.
        say : callable
            Called with a sentence for what a person should know.
        """
        return None

    def stand_in(self) -> dict[str, Any]:
        """A start that takes no time, for what only compiles kernels or times them."""
        plain = self.model_dump(exclude_none=True, by_alias=True)
        return {"seed": self.seed or 1} if self.work else plain

    def tiny(self, scene: Any) -> dict[str, Any]:
        """What to change in a scene so that it compiles all kernels of the start in no time."""
        return {}


def check_laws(table: Mapping[str, Any], there: list[tuple[str, ...]]) -> Refusals:
    """Laws that are there twice, or for beads that are nowhere bonded.

    Parameters
    ----------
    table : dict
        Laws by the names of species along bonds, which may be read from either end.
    there : list of tuple of str
        The species of all beads that are bonded so, each as its lesser direction.
    """
    seen: set[str] = set()
    for name in table:
        along = tuple(name.split())
        if " ".join(along[::-1]) in seen:
            yield name, "is there in the other order, too; keep one"
        seen.add(name)
        if min(along, along[::-1]) not in there:
            allowed = ", ".join(repr(" ".join(each)) for each in there[:20])
            yield name, f"no molecule has these beads bonded; allowed: {allowed}"


def check_bonded(table: Mapping[str, Any], bonded: list[tuple[str, ...]]) -> Refusals:
    """A table by pairs of bonded species: as `check_laws`, and bonded pairs that are not in it."""
    unfit = list(check_laws(table, bonded))
    yield from unfit
    for pair in bonded if not unfit else ():
        if not {" ".join(pair), " ".join(pair[::-1])}.intersection(table):
            named = " ".join(pair)
            yield "", f"no law for the pair {named!r}, which is bonded; add '{named}: ...'"


KINDS = "sample", "block", "largest", "run", "last", "frame", "lag", "part"  # of Observable.gives


def once(method: Callable[..., Any]) -> Callable[..., Any]:
    """Mark a method of a page that takes a scene: what it finds is kept with the scene."""

    def found(page: Any, scene: Any) -> Any:
        kept, key = vars(scene).setdefault("_once", {}), (id(page), method.__name__)
        if key not in kept:
            kept[key] = page, method(page, scene)  # the page too, so that no other has its id
        return kept[key][1]

    found.__doc__ = method.__doc__
    return found


PARTS: list[Callable[..., Any]] = []


def part(function: Callable[..., Any]) -> Callable[..., Any]:
    """Mark a function that formulas of a page call; in Python it stays as it is."""
    PARTS.append(function)
    return function


# --- the registry


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
