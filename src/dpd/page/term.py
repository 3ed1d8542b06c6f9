"""Pages of what acts on beads or on the box."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, ClassVar

from dpd.page.base import PACKAGE, Change, Page, Refusals, inside, is_table
from dpd.page.tables import check_table

if TYPE_CHECKING:
    from pathlib import Path
    from typing import Self


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
        Whether it acts while a start grows and relaxes.
    own_in_start : bool
        Whether it may do so with other settings, which ``start.forces`` has under its key.
    joins : int
        Beads along bonds that a law of it joins; 0 if it is none of bonds.
    keeps_apart : bool
        Whether it keeps beads apart that attract each other otherwise: repulsions may be negative.
    caption : str or None
        What captions say of it, with its settings in braces; what stands in brackets is left out
        where they are as by default. If not given, its settings by name; None for nothing.
    """

    folder = PACKAGE / "physics"
    package = "dpd.physics"
    _pages: ClassVar[dict[str, type[Page]]] = {}
    stands = frozenset(Change)
    mainly: ClassVar[Change | None] = None
    makes: ClassVar[frozenset[Change]] = frozenset()
    in_kernels: ClassVar[bool] = True
    in_start: ClassVar[bool] = False
    own_in_start: ClassVar[bool] = False
    joins: ClassVar[int] = 0
    keeps_apart: ClassVar[bool] = False
    caption: ClassVar[str | None] = ""

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

    def changed(self, given: Mapping[str, Any]) -> Any:
        """Its settings as plain data, with some others; of a table of laws, in each."""
        plain = self.plain()
        if is_table(plain):
            return {name: law | given for name, law in plain.items()}
        return plain | given

    def record(self, scene: Any) -> Any:
        """What kernels get under its key; None where nothing of it acts."""
        return None

    def records(self, scene: Any) -> dict[str, Any]:
        """The same and what else they get of it, by names of `dpd.engine.state.System`."""
        record = self.record(scene)
        return {} if record is None else {self.key: record}


class PairForce(Term):
    """A conservative force between pairs of a user's own, beside the repulsion.

    In its formulas a setting is the number of the pair at hand (``self.depth``), whether a scene
    gives one for all or a table by pairs of species; r is the distance in r_c and w = 1 - r. They
    are plain Python with `math`, and end at the cutoff, r = 1. Functions that they call are marked
    with `part`.
    """

    in_start = True

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
                yield from inside(name, check_table(value, scene, scene.pairs, 1))

    def modules(self, scene: Any) -> tuple[str, ...]:
        """What adds it to the repulsion."""
        return ("dpd.physics.common.records",)

    def numbers(self, scene: Any) -> dict[str, Any]:
        """What its formulas see as ``self``, where that is not its settings.

        Numbers, columns with one for each pair of species, and arrays of more dimensions.
        """
        return {}

    def untried(self) -> str:
        """Without it is how schemes were measured."""
        return f"schemes were measured without {self.key!r}; take gw-vv and try dt"


class BondedForce(Term):
    """Laws along bonds, of two beads or of three in a row: one for all, or by their species."""

    in_start = True
    own_in_start = True
    joins = 2

    def tables(self) -> dict[str, dict[str, Any]]:
        """Its tables by the species that it joins, by settings; a bare one by no name."""
        fields = {name: getattr(self, name) for name in type(self).model_fields}
        return {
            "" if name == self.bare else name: value
            for name, value in fields.items() if isinstance(value, dict)
        }  # fmt: skip

    def laws(self, scene: Any) -> dict[str, Any]:
        """Pages of numbers by the species that they join; one for all by no name."""
        if self.bare:
            law = getattr(self, self.bare)
            return law if isinstance(law, dict) else {"": law}
        from dpd.laws import laws_of_page

        return laws_of_page(self, scene)


class BondForce(BondedForce):
    """A law of bonds; a scene names one of those that there are.

    As in a `PairForce` a setting is the number of the bond at hand, whether a scene gives one for
    all or a table by pairs of species that are bonded, and formulas are plain Python with `math`; r
    is the length in r_c. A page may have a ``curvature(r)``, the slope of the slope of the energy,
    instead of a difference of forces.

    Attributes
    ----------
    example : str
        Of its section, for who needs bonds and has none.
    """

    example: ClassVar[str] = ""

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

    def unknown(self, scene: Any) -> Refusals:
        """Pairs that are not bonded, and bonded ones without a value."""
        if not scene.has_bonds:
            text = "every molecule is a single bead; remove the key, or give an architecture of"
            yield "", f"{text} several beads, as 'A 10'"
            return
        for name, table in self.tables().items():
            yield from inside(name, check_table(table, scene, scene.species_along(2)))

    def refuses(self, scene: Any) -> Refusals:
        """Bonds that are too long for the box."""
        from dpd.laws import too_long

        yield from too_long(self.laws(scene), scene)

    def untried(self) -> str:
        """With harmonic bonds is how schemes were measured."""
        return f"schemes were measured with 'bond', not {self.key!r}; take gw-vv and try dt"
