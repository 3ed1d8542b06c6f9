"""Colours of beads, by species or by molecule."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from matplotlib.colors import to_rgb

from dpd.particles.particles import molecules_of
from dpd.report.colours import BLUE, GREEN, MANY, ORANGE, PURPLE, RED, SKY

if TYPE_CHECKING:
    from dpd.particles.particles import Particles
    from dpd.report.pictures.look import Look

OF_SPECIES = (BLUE, ORANGE, GREEN, RED, PURPLE, SKY)
SINGLE = "#B4B4B4"  # beads without bonds among molecules
# Molecules are neighbours if beads come as close as this, in mean distances of beads.
CLOSE = {2: 3.0, 3: 1.5}
BRIGHTER = 0.2  # share of white in colours on a black background
PALER = 0.5  # share of white in colours of a second round


class Colours(NamedTuple):
    """Colours of all beads.

    Attributes
    ----------
    palette : (colours, 3) array
        Red, green and blue, from 0 to 1.
    kind : (n,) array
        Number of the colour of each bead.
    """

    palette: np.ndarray
    kind: np.ndarray


def coloured_by(particles: Particles, look: Look) -> str:
    """What the colours tell: ``species`` or ``molecule``."""
    if look.colour:
        return look.colour
    return "molecule" if len(particles.names) == 1 and len(particles.bonds) else "species"


def colours_of(particles: Particles, look: Look) -> Colours:
    """Colours of all beads, by what the colours tell."""
    if coloured_by(particles, look) == "species":
        return Colours(species_colours(len(particles.names)), particles.species)
    return molecule_colours(particles)


def species_colours(count: int) -> np.ndarray:
    """A colour for each species: paler in a second round, and then again from the first."""
    first = np.array([to_rgb(colour) for colour in OF_SPECIES])
    both = np.vstack([first, mixed(first, np.ones(3), PALER)])
    return both[np.arange(count) % len(both)]


def molecule_colours(particles: Particles) -> Colours:
    """Colours of beads such that neighbouring molecules differ as far as the palette goes.

    Molecules take colours in turn, those with the most contacts first. Each takes the colour that
    it has the fewest contacts with, and among such the one that was taken least often. Beads
    without bonds are gray.
    """
    molecules = molecules_of(particles)
    contacts = _contacts(particles, molecules)
    bonded = np.flatnonzero(np.bincount(molecules) > 1)
    gray = len(MANY)
    taken = np.full(contacts.shape[0], gray)
    often = np.zeros(gray)
    total = contacts.sum(axis=1)
    for molecule in bonded[np.argsort(-total[bonded], kind="stable")]:
        row = slice(contacts.indptr[molecule], contacts.indptr[molecule + 1])
        near = taken[contacts.indices[row]]
        seen = near < gray
        touched = np.bincount(near[seen], contacts.data[row][seen], gray)
        choice = np.lexsort((often, touched))[0]
        taken[molecule] = choice
        often[choice] += 1
    palette = np.array([to_rgb(colour) for colour in (*MANY, SINGLE)])
    return Colours(palette, taken[molecules])


def _contacts(particles, molecules):
    """How many pairs of close beads each two molecules have, as a sparse table."""
    from scipy.sparse import coo_array
    from scipy.spatial import cKDTree

    spacing = (np.prod(particles.box) / particles.beads) ** (1 / particles.dimension)
    reach = min(CLOSE[particles.dimension] * spacing, 0.49 * min(particles.box))
    tree = cKDTree(particles.position.T, boxsize=particles.box)
    pairs = molecules[tree.query_pairs(reach, output_type="ndarray")]
    one, other = pairs[pairs[:, 0] != pairs[:, 1]].T
    both = np.concatenate([one, other]), np.concatenate([other, one])
    count = int(molecules.max()) + 1
    return coo_array((np.ones(len(both[0])), both), shape=(count, count)).tocsr()


def mixed(colours: np.ndarray, with_colour: np.ndarray, share: np.ndarray | float) -> np.ndarray:
    """Colours with a share of another one.

    Parameters
    ----------
    colours : (n, 3) array
    with_colour : (3,) array
    share : float or (n, 1) array
        Of the other colour, from 0 to 1.
    """
    return colours * (1 - share) + with_colour * share
