"""The record of all that acts on beads, and how kernels call a term of it.

A term is a page of this package: a record whose methods are its force, its energy and its
curvature. Numba knows the class of a record when it compiles, so `force(term, ...)` in a kernel
becomes the method of that class and nothing else: terms that a scene does not name cost nothing.
"""

from typing import NamedTuple

from dpd.jit import method
from dpd.physics.angle import Angle, AngleTable
from dpd.physics.body import BodyForce
from dpd.physics.bond import Bond, BondTable
from dpd.physics.core import Core
from dpd.physics.exchange import Exchange
from dpd.physics.friction import Friction
from dpd.physics.langevin import Langevin
from dpd.physics.soft import Soft
from dpd.physics.wall import Walls


class Forces(NamedTuple):
    """What acts on beads; None for what does not.

    Attributes
    ----------
    pair : Soft or Core
        The conservative force between pairs.
    bond : Bond, BondTable or None
    angle : Angle, AngleTable or None
    friction : Friction or None
    langevin : Langevin or None
    exchange : Exchange or None
        The thermostat is one of these three.
    walls : Walls or None
    body_force : BodyForce or None
    """

    pair: Soft | Core
    bond: Bond | BondTable | None = None
    angle: Angle | AngleTable | None = None
    friction: Friction | None = None
    langevin: Langevin | None = None
    exchange: Exchange | None = None
    walls: Walls | None = None
    body_force: BodyForce | None = None


# What a kernel calls with a term as the first argument.
force = method("force")
force_over_r = method("force_over_r")
energy = method("energy")
curvature = method("curvature")
drag = method("drag")
random = method("random")
change = method("change")
weight = method("weight")
