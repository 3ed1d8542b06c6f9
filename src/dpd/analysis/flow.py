"""Viscosity and slip from velocity profiles of flows that a body force drives.

A steady flow u(z) along one axis, across the other, obeys Newton's law of viscosity and the
balance of forces, eta u'' = -rho g, with rho beads per volume and the force g on each. So the
profile is a parabola, whose curvature gives eta.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from dpd.analysis.statistics import mean_and_error

if TYPE_CHECKING:
    import xarray as xr

NEAR_WALL = 2.0  # r_c from a wall, within which the fluid is layered and feels the wall


class Measured(NamedTuple):
    """A value and its standard error, which knows about correlation between blocks."""

    value: float
    error: float


class Channel(NamedTuple):
    """What a flow between two walls tells.

    - ``viscosity``: eta in kT tau / r_c^3.
    - ``slip``: slip length in r_c: how far behind the plane of the wall the parabola of the middle
      of the channel would be at rest; negative if it is at rest in front of it.
    """

    viscosity: Measured
    slip: Measured


def viscosity_of_two_flows(
    run: xr.Dataset, strength: float, edge: float, axis: int = 0
) -> Measured:
    """Shear viscosity from two opposite flows in a periodic box.

    A body force acts in the lower half of an axis, and the opposite one in the upper half. With
    h = edge / 2 the flow of the lower half is u(z) = rho g z (h - z) / (2 eta), and the other is
    the same backwards (Backer, Lowe, Hoefsloot and Iedema, J. Chem. Phys. 122, 154503 (2005)).
    Layers at the same place of both halves are taken together, which removes a drift of the box.

    ``run``: with ``velocity_profile`` and ``bead_profile`` over ``block``, ``axis`` and ``layer``,
    of which there is an even number. ``strength``: g, the force on a bead in the lower half, in kT
    / r_c. ``edge``: of the box across the flows, in r_c. ``axis``: of the flows. Raises
    `ValueError` if the number of layers is odd.
    """
    velocity = run.velocity_profile.values[:, axis]
    layers = velocity.shape[1]
    if layers % 2:
        raise ValueError(f"{layers} layers cannot be halved; choose 'bin' for an even number")
    half = 0.5 * edge
    flow = 0.5 * (velocity[:, : layers // 2] - velocity[:, layers // 2 :])
    z, thickness = run.layer.values[: layers // 2], edge / layers
    # The mean of z (h - z) over a layer.
    shape = z * (half - z) - thickness**2 / 12
    curvature = flow @ shape / (shape @ shape)
    density = float(run.bead_profile.mean())
    return _viscosity(density * strength, 2 * curvature)


def channel_flow(run: xr.Dataset, strength: float, apart: float, axis: int = 0) -> Channel:
    """Shear viscosity and slip length from one flow between two walls.

    A parabola u(z) = u_0 - c (z - L / 2)^2 is fitted to the middle of the channel, further than
    `NEAR_WALL` from both walls; eta = rho g / (2 c), with the density rho there. It is at rest at
    z = -b, with the slip length b = u(0) / u'(0) of the plane of the lower wall, by the tangent of
    the parabola.

    ``run``: with ``velocity_profile`` and ``bead_profile`` over ``block``, ``axis`` and ``layer``.
    ``strength``: g, the force on a bead, in kT / r_c. ``apart``: distance L of the walls in r_c.
    ``axis``: of the flow. Raises `ValueError` if fewer than three layers are far enough from both
    walls.
    """
    z = run.layer.values
    bulk = (z > NEAR_WALL) & (z < apart - NEAR_WALL)
    if bulk.sum() < 3:
        raise ValueError(
            f"{bulk.sum()} layers are further than {NEAR_WALL:g} r_c from both walls, and a "
            "parabola needs three; take walls further apart, or thinner layers"
        )
    velocity = run.velocity_profile.values[:, axis, bulk]
    density = float(run.bead_profile.values[:, bulk].mean())
    square = (z[bulk] - 0.5 * apart) ** 2 + (z[1] - z[0]) ** 2 / 12
    about = square - square.mean()
    curvature = -velocity @ about / (about @ about)
    top = velocity.mean(axis=1) + curvature * square.mean()
    c, highest = curvature.mean(), top.mean()
    # b = (u_0 - c L^2 / 4) / (c L), to first order in what a block deviates by
    slip = (highest - c * apart**2 / 4) / (c * apart)
    slips = slip + (top - highest) / (c * apart) - (curvature - c) * highest / (c**2 * apart)
    return Channel(_viscosity(density * strength, 2 * curvature), _measured(slips))


def _viscosity(force, second_derivatives):
    """eta = force / -u'', from one second derivative per block; its error to first order."""
    mean = second_derivatives.mean()
    eta = force / mean
    return _measured(eta - eta * (second_derivatives - mean) / mean)


def _measured(values):
    """Mean and error of one value per block."""
    mean, error, _ = mean_and_error(values)
    return Measured(float(mean), float(error))
