"""Viscosity and slip length from a flow between two walls."""

from __future__ import annotations

from typing import NamedTuple

import xarray as xr

from dpd.analysis.viscosity import Measured, measured, viscosity_of_curvature

NEAR_WALL = 2.0  # r_c from a wall, within which the fluid is layered and feels the wall


class Channel(NamedTuple):
    """What a flow between two walls says."""

    viscosity: Measured  # in kT tau / r_c^3
    # Slip length in r_c: how far behind the plane of the wall the parabola of the middle of the
    # channel would be at rest; negative if it is at rest in front of it.
    slip: Measured


def channel_flow(run: xr.Dataset, strength: float, apart: float, axis: int = 0) -> Channel:
    """Shear viscosity and slip length from one flow between two walls.

    A parabola u(z) = u_0 - c (z - L / 2)^2 is fitted to the middle of the channel, further than
    `NEAR_WALL` from both walls; eta = rho g / (2 c), with the density rho there. It is at rest at
    z = -b, with the slip length b = u(0) / u'(0) of the plane of the lower wall, by the tangent of
    the parabola.

    ``run``, ``strength``, ``axis``: as of `viscosity_of_two_flows`. ``apart``: distance L of the
    walls in r_c. Raises `ValueError` if fewer than three layers are far enough from both walls.
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
    return Channel(viscosity_of_curvature(density * strength, 2 * curvature), measured(slips))
