"""What of a configuration is drawn: beads, and bonds cut at the faces of the box."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from dpd.engine.space import nearest, wrapped

if TYPE_CHECKING:
    from dpd.particles.particles import Particles
    from dpd.report.pictures.look import Look

DENSE = 0.36  # radius of beads that are not bonded, in mean distances of neighbours
LARGEST = 0.4  # r_c, radius of beads that have no close neighbours
TOUCHING = 0.45  # radius of bonded beads, in mean lengths of bonds


class Pieces(NamedTuple):
    """Pieces of bonds, each of which belongs to one bead and lies in the box.

    Attributes
    ----------
    first, last : (dimension, m) array
        Ends in r_c.
    bead : (m,) array
        Whose colour the piece has.
    """

    first: np.ndarray
    last: np.ndarray
    bead: np.ndarray


def visible_beads(particles: Particles, region: np.ndarray, look: Look) -> np.ndarray:
    """Which beads are drawn: those of the species asked for, in a region.

    Returns
    -------
    (n,) bool array
    """
    inside = (particles.position >= region[:, :1]) & (particles.position <= region[:, 1:])
    visible = np.logical_and.reduce(inside)
    if look.species:
        numbers = [particles.names.index(name) for name in look.species]
        visible &= np.isin(particles.species, numbers)
    return visible


def separations(particles: Particles, bonds: np.ndarray) -> np.ndarray:
    """From the first to the second bead of bonds, at the nearest image.

    Returns
    -------
    (dimension, bonds) array
    """
    one, other = bonds.T
    return nearest(particles.position[:, other] - particles.position[:, one], particles.box)


def pieces_of(particles: Particles, visible: np.ndarray, hidden: float) -> Pieces:
    """The bonds between visible beads, cut in the middle and at the faces of the box.

    A bond goes to the nearest image of the other bead. Where it leaves the box, its other piece
    comes in at the opposite face.

    Parameters
    ----------
    particles : Particles
    visible : (n,) bool array
    hidden : float
        Length of a bond, at both of its ends, that is left out as beads hide it.

    Returns
    -------
    Pieces
    """
    bonds = particles.bonds[visible[particles.bonds].all(axis=1)]
    begin, apart = particles.position[:, bonds[:, 0]], separations(particles, bonds)
    edges = np.array(particles.box)[:, None]
    # A share of the bond at which it crosses a face; 1, its end, where it does not.
    face = np.where(apart > 0, edges, 0.0)
    crossing = np.divide(face - begin, apart, out=np.ones_like(apart), where=apart != 0)
    crossing[(crossing < 0) | (crossing > 1)] = 1.0
    length = np.sqrt((apart**2).sum(axis=0))
    inside = np.divide(hidden, length, out=np.ones_like(length), where=length > 0).clip(0.0, 0.5)
    cuts = np.vstack([inside, np.full_like(length, 0.5), crossing, 1 - inside])
    cuts = np.sort(np.clip(cuts, inside, 1 - inside), axis=0)
    parts = [_between(particles, bonds, apart, *part) for part in pairwise(cuts)]
    first, last, bead = zip(*parts)
    return Pieces(np.hstack(first), np.hstack(last), np.concatenate(bead))


def _between(particles, bonds, apart, low, high):
    """The part of each bond from one share of it to another, moved into the box."""
    there = high - low > 1e-9
    bonds, apart, low, high = bonds[there], apart[:, there], low[there], high[there]
    begin, middle = particles.position[:, bonds[:, 0]], 0.5 * (low + high)
    place = begin + middle * apart
    shift = wrapped(place, particles.box)[0] - place
    bead = np.where(middle < 0.5, bonds[:, 0], bonds[:, 1])
    return Pieces(begin + low * apart + shift, begin + high * apart + shift, bead)


def usual_radius(particles: Particles) -> float:
    """Radius of drawn beads at which neighbours, and bonds between them, can be told apart."""
    spacing = (np.prod(particles.box) / particles.beads) ** (1 / particles.dimension)
    radius = min(DENSE * float(spacing), LARGEST)
    if not len(particles.bonds):
        return radius
    apart = separations(particles, particles.bonds)
    length = float(np.sqrt((apart**2).sum(axis=0)).mean())
    return min(radius, TOUCHING * length) if length > 0 else radius
