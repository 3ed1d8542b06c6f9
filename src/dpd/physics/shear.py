"""Steady shear: a flow along one axis that grows linearly along another.

With the rate g, x along the flow and y along its gradient, the fluid streams with

    U(y) = g y   along x

A velocity v is kept as that about the flow, u = v - U(y). Two beads apart by r_ij then approach
each other with (the first factor of friction, Groot and Warren 1997, Eq. 5)

    r_ij . v_ij  =  r_ij . u_ij + g x_ij y_ij

and without forces beads move with v constant (Lees and Edwards 1972; Evans and Morriss 1984):

    dx/dt = u_x + g y,     du_x/dt = -g u_y
"""

from typing import NamedTuple


class Shear(NamedTuple):
    """Steady shear.

    Attributes
    ----------
    rate : float
        g in 1 / tau.
    flow, gradient : int
        Number of the axis along which the fluid flows, and of that along which its speed grows.
    """

    rate: float
    flow: int
    gradient: int
