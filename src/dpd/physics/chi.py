"""`chi` of a scene: the repulsion between two species, from how badly they mix.

The relation was measured where both kinds of molecules have one length. Of several the shortest
decides between those of single beads and of chains (7 % apart); all must be within the range.
"""

from collections.abc import Iterator
from typing import Annotated, Any

from pydantic import Field

from dpd.errors import UserError
from dpd.page import PairTable, Refusals, Term, no_species, setting

MEASURED_WITH = {"stiffness": 2, "length": 0}  # the bonds of the chains


class Chi(Term, key="chi"):
    """Flory-Huggins parameter of pairs of species, as {A B: 4}, in place of their repulsion.

    That is then a_AA + chi kT / 0.286 for single beads at density 3, / 0.689 at density 5, and
    / 0.306 for molecules of 2 to 10 beads at density 3 (Groot and Warren 1997, Eqs. 24 and 27). If
    the molecules with A or B differ in length, the shortest decides which. It is refused outside of
    the range in which that was measured.
    """

    caption = None
    bare = "pairs"
    usual = ""
    in_kernels = False
    not_in_lammps = ""
    pairs: PairTable[Annotated[float, Field(ge=0, le=1000)]] = setting("The parameter chi.")

    def repulsions(self, scene: Any) -> dict[str, float]:
        return {pair: self._repulsion(scene, pair) for pair in self.pairs}

    def _repulsion(self, scene, pair):
        from dpd.theory.repulsion import relation_at, unlike_repulsion

        def refuse(problem):
            raise UserError(f"{scene.where}: chi.{pair}: {problem}")

        one, other = names = pair.split()
        given = scene.terms["repulsion"].pairs
        for name in names:
            if name not in scene.species:
                refuse(no_species(name, scene.species))
        if one == other:
            refuse("a species mixes with itself, it has no chi; give its 'repulsion' alone")
        if {pair, f"{other} {one}"} & given.keys():
            refuse("the pair has a repulsion as well; give one of the two")
        if scene.dimension != 3:
            refuse("was measured in three dimensions only; give a 'repulsion'")
        like = [given.get(f"{name} {name}") for name in names]
        if None in like or like[0] != like[1]:
            refuse(f"needs the same repulsion for {one} {one} and {other} {other}; give both")
        lengths = _lengths(scene, names)
        try:
            for length in lengths:
                relation_at(scene.density, length)
            return unlike_repulsion(self.pairs[pair], scene.density, lengths[0], scene.kT, like[0])
        except ValueError as problem:
            refuse(f"{problem}. Or give a 'repulsion' instead")

    def refuses(self, scene: Any) -> Refusals:
        for term in scene.terms.values():
            if term.keeps_apart:
                yield "", f"was measured without {term.key!r}; give a 'repulsion' instead"

    def notes(self, scene: Any) -> Iterator[str]:
        from dpd.theory.repulsion import relation_at

        shortest = {pair: _lengths(scene, pair.split())[0] for pair in self.pairs}
        for pair, chi in self.pairs.items():
            relation = relation_at(scene.density, shortest[pair])
            found = scene.repulsions[pair]
            yield f"chi.{pair}: {chi:g} makes a_ij {found:.4f}, by {relation}"
        bonds = scene.bond_force.laws(scene).values() if scene.bond_force else ()
        alike = all(dict(law) == MEASURED_WITH for law in bonds)
        if max(shortest.values()) > 1 and not alike:
            yield (
                "chi was measured with bonds of stiffness 2 and length 0; with stiffness 4 we find "
                "it lower than that relation says, by 9 +- 2 % for 2 beads and by 22 +- 2 % for 5"
            )


def _lengths(scene, names):
    """Lengths of the molecules that hold one of two species, the shortest first."""
    return sorted({len(kind.beads) for kind in scene.molecules if {*names} & {*kind.beads}})
