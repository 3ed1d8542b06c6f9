"""What pages of all kinds have in common: settings, their tables, changes, the registry."""

import importlib
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from enum import Enum
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, NamedTuple, Self, TypeVar

# To look for plugins of pydantic among all installed packages takes 8 ms.
os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
from pydantic import BaseModel, ConfigDict, Discriminator, Field, Tag, field_validator

from dpd.errors import shown, suggestion
from dpd.folders import PACKAGE

Refusals = Iterator[tuple[str, str]]  # a key inside of its settings, or none, and what is wrong

MOST_STEPS = 10**12
LARGEST_SEED = 2**63 - 1
MOST_NAMED = 20  # pairs or triples in a message


class Change(Enum):
    """What a page does to the world, and why one that has said nothing of it cannot stand that."""

    SLIDES = "takes the images of the box to stay where they are"
    STRETCHES = "takes the box to keep its size"
    ENDS = "takes the fluid to repeat along every axis"
    FLOWS = "holds in equilibrium only"
    JUMPS = "needs a force without jumps"
    VARIES = "needs steps of one length while it samples"


# --- settings

K = TypeVar("K")
N = TypeVar("N")
SPECIES, PAIR, TRIPLE = r"^\S+$", r"^\S+ \S+$", r"^\S+ \S+ \S+$"
# What a key of a table is, by its pattern, for messages.
NAMES = {
    SPECIES: "a species, as 'A'", PAIR: "a pair of species, as 'A B', or a type of bonds",
    TRIPLE: "three species along two bonds, as 'A B C', or a type of angles",
}  # fmt: skip
Species = Annotated[str, Field(pattern=SPECIES)]
Pair = Annotated[str, Field(pattern=PAIR)]
Triple = Annotated[str, Field(pattern=TRIPLE)]
# Which branch a value is meant for, by its kind: so only errors of that are told.
OR_TABLE = Discriminator(lambda value: "=table" if isinstance(value, dict | BaseModel) else "=one")
OR_LIST = Discriminator(lambda value: "=list" if isinstance(value, list) else "=one")
OR_LAWS = Discriminator(  # a law has numbers alone
    lambda v: "=table" if is_table(v) or dict in map(type, getattr(v, "values", list)()) else "=one"
)
_One = Annotated[N, Tag("=one")]
Table = Annotated[dict[K, N], Field(min_length=1)]
PairTable = Table[Pair, N]
OneOr = Annotated[_One[N] | Annotated[K, Tag("=table")], OR_TABLE]  # K: a table, or a section
PerSpecies = OneOr[N, Table[Species, N]]
PerPair = OneOr[N, Table[Pair, N]]
OneOrMore = Annotated[_One[N] | Annotated[list[N], Field(min_length=1), Tag("=list")], OR_LIST]
OneOrTable = Annotated[_One[N] | Annotated[Table[K, N], Tag("=table")], OR_LAWS]
Axis = Literal["x", "y", "z"]
Positive = Annotated[float, Field(gt=0, le=1e6)]
NotNegative = Annotated[float, Field(ge=0, le=1e6)]


def is_table(value: object) -> bool:
    """Whether something is a law for each pair or triple of species, not one for all."""
    return isinstance(value, dict) and any(" " in str(key) for key in value)


def setting(text: str, default: Any = ..., unit: str = "", of: str = "", **bounds: Any) -> Any:
    """A setting with bounds as pydantic has them.

    It may be ``of`` what a scene must have: an ``axis``, ``species`` (a table has a value for each)
    or ``some species``.
    """
    extra: Any = {key: value for key, value in {"unit": unit, "of": of}.items() if value}
    given = {"default_factory": default} if callable(default) else {"default": default}
    return Field(description=text, json_schema_extra=extra or None, **given, **bounds)


def inside(key: str, problems: Refusals) -> Refusals:
    """Problems of what stands under a key."""
    for place, problem in problems:
        yield ".".join(filter(None, (key, place))), problem


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
    """A page; those of a kind stand in one package, each in a file that is called by its key."""

    package: ClassVar[str]
    key: ClassVar[str] = ""
    bare: ClassVar[str] = ""  # setting that the section stands for, if it is no table of settings
    stands: ClassVar[frozenset[Change]] = frozenset()  # changes that it was made for
    cannot: ClassVar[Mapping[Change, str]] = {}  # why not, where `Change` does not say it best
    _pages: ClassVar[dict[str, type["Page"]]]

    @classmethod
    def why_not(cls, change: Change) -> str:
        """Why it cannot stand a change; nothing if it can."""
        stands = change in cls.stands and change not in cls.cannot
        return "" if stands else cls.cannot.get(change, change.value)

    @classmethod
    def has_required(cls) -> bool:
        """Whether a setting has no default."""
        return any(field.is_required() for field in cls.model_fields.values())

    def found(self, folder: str | Path, where: str) -> Self:
        """Itself, once it has looked at the files that it names, from a folder on."""
        return self

    def refuses(self, scene: Any) -> Refusals:
        """What it cannot stand in a scene that is otherwise allowed."""
        return iter(())

    def plain(self) -> Any:
        """Its settings as plain data, as they stand in a file."""
        data = self.model_dump(exclude_none=True, by_alias=True)
        return data[self.bare] if self.bare else data

    def content(self) -> Any:
        """Its settings as far as they decide a run: of a file what is in it, not where it lies."""
        return self.plain()

    @classmethod
    def summary(cls) -> str:
        """Its description in one sentence."""
        return " ".join((cls.__doc__ or "").split("\n\n")[0].split())

    def __init_subclass__(cls, key: str = "", **options: Any) -> None:
        super().__init_subclass__(**options)
        if key:
            cls.key = key

    @classmethod
    def __pydantic_init_subclass__(cls, key: str = "", **options: Any) -> None:
        """Register a page that has all its settings by now: other threads may look for it."""
        if key and cls.__module__ == f"{cls.package}.{key}":  # others belong to the scene's files
            cls._pages[key] = cls


class Quantity(NamedTuple):
    """A calculated number or array; what has the name of its only dimension is a coordinate."""

    value: Any
    units: str
    long_name: str
    dims: tuple[str, ...] = ()


class Calculation(Page):
    """What a sweep of theory calculates at a point: a page of a paper, in its calculations.py.

    A setting ``seed`` that is not given is the seed of the study.
    """

    package: ClassVar[str] = "paper_figures"

    def calculate(self) -> dict[str, Quantity]:
        """Numbers and arrays by name; a ValueError says why there is no solution."""
        raise NotImplementedError


def once(method: Callable[..., Any]) -> Callable[..., Any]:
    """Mark a method of a page that takes a scene: what it finds is cached with the scene."""

    def found(page: Any, scene: Any) -> Any:
        cache, key = vars(scene).setdefault("_once", {}), (id(page), method.__name__)
        if key not in cache:
            cache[key] = page, method(page, scene)  # the page too, so that no other has its id
        return cache[key][1]

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
    files = os.listdir(PACKAGE / kind.package.removeprefix("dpd."))
    return sorted(name[:-3] for name in files if name.endswith(".py") and name[0] != "_")


def find(kind: type[Page], key: str) -> Any:
    """A page by its key, which there is."""
    if key not in kind._pages:
        importlib.import_module(f"{kind.package}.{key}")
    return kind._pages[key]


# --- tables by species, by pairs of species, or by species along bonds


def no_species(name: str, species: Sequence[str]) -> str:
    """In words that no molecule has a species, and what may be meant."""
    found = f"no molecule has the species {name!r}"
    for other in species:
        if other.startswith(name) and other[len(name) :].isdigit():
            meant = f"'{name} {other[len(name) :]}', several beads of {name}"
            return f"{found}; allowed: {', '.join(species)}; did you mean {meant}?"
    return f"{found}; {suggestion(name, species)}"


def check_table(
    table: Mapping[str, Any], scene: Any, there: Iterable[tuple[str, ...]], example: float | str
) -> Refusals:
    """Names that are not ``there``, two values of one, those without any.

    The example is a usual value, or '' where values may be left out.
    """
    there, wrong = list(there), False
    species = {*scene.species, *(name for along in there for name in along)}  # and names of types
    known = set(there)
    for name, value in table.items():
        along = tuple(name.split())
        back = " ".join(along[::-1])
        problems = [no_species(each, scene.species) for each in {*along} - species]
        if there and len(along) != len(there[0]):
            allowed = list(NAMES.values())[len(there[0]) - 1]
            problems = [f"{name!r} is no name here; allowed: {allowed}"]
        elif not problems and min(along, along[::-1]) not in known:
            allowed = ", ".join(repr(" ".join(each)) for each in there[:MOST_NAMED])
            problems.append(f"no molecule has these beads bonded; allowed: {allowed}")
        if name < back and (other := table.get(back, value)) != value:
            values = [shown(f"{x:g}" if isinstance(x, float) else x, str) for x in (value, other)]
            problems.append(f"{values[0]}, but {values[1]} in the other order; keep one")
        for problem in problems:
            yield name, problem
        wrong = wrong or bool(problems)
    for along in () if wrong or example == "" else there:
        name, back = " ".join(along), " ".join(along[::-1])
        if name not in table and back not in table:
            yield "", f"no value for {name!r}; add '{name}: {example}'"
