"""`chi` of a scene: the repulsion between two species, from how badly they mix.

The relation was measured where both kinds of molecules have one length. A scene may have the two
species in molecules of several lengths. Then the shortest molecule with one of the two decides
whether the relation of single beads is taken or that of chains (they differ by 7 %). All of them
must be within the range of lengths that were measured.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from dpd.errors import UserError
from dpd.theory.repulsion import relation_at, unlike_repulsion

if TYPE_CHECKING:
    from dpd.scene.scene import Scene

MEASURED_WITH = {"stiffness": 2, "length": 0}  # the bonds of the chains


class FromChi(NamedTuple):
    """A repulsion that a scene gives as chi.

    Attributes
    ----------
    pair : str
        As the scene writes it, "A B".
    chi : float
    length : int
        Beads of the shortest molecule with one of the two species.
    repulsion : float
        a_AB in kT / r_c.
    relation : str
    """

    pair: str
    chi: float
    length: int
    repulsion: float
    relation: str

    def __str__(self) -> str:
        return f"chi.{self.pair}: {self.chi:g} makes a_ij {self.repulsion:.4f}, by {self.relation}"


def repulsions_from_chi(scene: Scene) -> tuple[FromChi, ...]:
    """What `chi` of a scene makes of it.

    Parameters
    ----------
    scene : dpd.scene.scene.Scene
        Its repulsions need not have been checked yet.

    Raises
    ------
    UserError
        If a pair has a repulsion as well, if a name is not of the scene, or outside of the range in
        which the relation was measured.
    """
    return tuple(_from_chi(scene, pair, chi) for pair, chi in scene.data.get("chi", {}).items())


def _from_chi(scene, pair, chi):
    """One of them."""

    def refuse(problem):
        raise UserError(f"{scene.where}: chi.{pair}: {problem}")

    one, other = names = pair.split()
    given = scene.data["repulsion"]
    for name in names:
        if name not in scene.species:
            refuse(scene.no_species(name))
    if one == other:
        refuse("a species mixes with itself, it has no chi; give its 'repulsion' alone")
    for key in (pair, f"{other} {one}"):
        if key in given:
            refuse(f"the pair has the repulsion {given[key]:g} as well; give one of the two")
    if f"{other} {one}" in scene.data["chi"]:
        refuse("is there in the other order as well; keep one")
    if scene.dimension != 3:
        refuse("was measured in three dimensions only; give a 'repulsion'")
    like = [given.get(f"{name} {name}") for name in names]
    if None in like or like[0] != like[1]:
        refuse(f"needs the same repulsion for {one} {one} and {other} {other}; give both")
    kT, lengths = scene.kT, _lengths(scene, names)
    try:
        relation, *_ = [relation_at(scene.density, length) for length in lengths]
        found = unlike_repulsion(chi, scene.density, lengths[0], kT, like[0])
    except ValueError as problem:
        refuse(f"{problem}. Or give a 'repulsion' instead")
    return FromChi(pair, chi, lengths[0], found, str(relation))


def _lengths(scene, names):
    """Lengths of the molecules that hold one of two species, the shortest first."""
    held = [kind.beads for kind in scene.molecules if set(names).intersection(kind.beads)]
    return sorted({len(beads) for beads in held})


def chi_notes(scene: Scene) -> list[str]:
    """Sentences for a person: what came of each chi, and what the relation was not measured for."""
    found = [str(each) for each in scene.from_chi]
    bond = scene.data.get("bond", {})
    chains = [each for each in scene.from_chi if each.length > 1]
    if chains and any(bond.get(key) != value for key, value in MEASURED_WITH.items()):
        found.append(
            "chi was measured with bonds of stiffness 2 and length 0; with stiffness 4 we find it "
            "lower than that relation says, by 9 +- 2 % for 2 beads and by 22 +- 2 % for 5"
        )
    return found
