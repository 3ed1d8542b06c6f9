"""Molecules: their architecture, and how many of them a box holds."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Molecule:
    """A linear molecule: the species of its beads in order, and how many there are."""

    beads: tuple
    count: int


@dataclass(frozen=True)
class MissedDensity:
    """A density that whole molecules cannot meet.

    Attributes
    ----------
    place : int
        Of the kind of molecule in the scene.
    asked, found : float
        Beads per r_c^dimension in the scene, and of whole molecules in its box.
    """

    place: int
    asked: float
    found: float

    @property
    def share(self) -> float:
        """By how much it is missed, relative to what is asked for."""
        return abs(self.found / self.asked - 1)


def beads_of(architecture: str) -> tuple[str, ...]:
    """Species of the beads of "A 3 B 9": A A A B B B ..."""
    beads = []  # type: list[str]
    for word in architecture.split():
        if word.isdigit():
            beads += [beads[-1]] * (int(word) - 1)
        else:
            beads.append(word)
    return tuple(beads)
