"""What a sweep calculates at a point, by the names in dpd.pipeline.sections.

Each function takes the arguments of one point and returns its numbers and arrays by name, each a
`Quantity`. Lengths are in units of r_c, energies in kT, repulsions in kT / r_c, pressures in
kT / r_c^3. Where there is no solution it raises a `ValueError` that says why.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from dpd.theory import bonds, equation_of_state, mixtures
from dpd.theory.integral_equations import R, solve
from dpd.theory.mixtures import Fluid
from dpd.theory.second_virial import (
    chain_second_virial,
    older_second_virial,
    sampled_second_virial,
)
from dpd.theory.thermodynamics import (
    compressibility_pressure,
    energy,
    excess_chemical_potentials,
    pressure,
)
from dpd.theory.virial import second_virial

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from typing import Any

PRESSURE, REPULSION, VIRIAL = "kT / r_c^3", "kT / r_c", "r_c^3"
SHOWN = R <= 3  # distances of g(r) that are kept


class Quantity(NamedTuple):
    """A calculated number or array.

    Attributes
    ----------
    value : float or array
    units, long_name : str
    dims : tuple of str
        Of an array. What has the name of its only dimension is the coordinate of that.
    """

    value: float | np.ndarray
    units: str
    long_name: str
    dims: tuple[str, ...] = ()


def monomer_fluid(density: float, repulsion: float) -> dict[str, Quantity]:
    """A fluid of single beads: g(r), pressures, energy, and chemical potential.

    Parameters
    ----------
    density : float
        Beads per r_c^3.
    repulsion : float

    Returns
    -------
    dict of str to Quantity

    Raises
    ------
    NoSolution
        If the integral equation has none.
    """
    fluid = solve(density, repulsion)
    return {
        "r": Quantity(R[SHOWN], "r_c", "distance", ("r",)),
        "rdf": Quantity(fluid.g[SHOWN, 0, 0], "1", "g(r) by HNC", ("r",)),
        "pressure": Quantity(pressure(fluid), PRESSURE, "virial pressure by HNC"),
        "pressure_by_compressibility": Quantity(
            compressibility_pressure(density, repulsion), PRESSURE,
            "pressure by HNC, from the compressibility",
        ),
        "energy": Quantity(energy(fluid) / density, "kT", "energy per bead by HNC"),
        "chemical_potential": Quantity(
            float(excess_chemical_potentials(fluid)[0]), "kT", "excess chemical potential by HNC"
        ),
        "pressure_gw": Quantity(equation_of_state.gw(density, repulsion), PRESSURE, "GW"),
        "pressure_rgw": Quantity(equation_of_state.rgw(density, repulsion), PRESSURE, "rGW"),
    }  # fmt: skip


def second_virial_of_chains(
    repulsion: float, beads: int, length: float, samples: int, seed: int = 1
) -> dict[str, Quantity]:
    """B2 of two chains, sampled and by fits; NaN for what was not sampled.

    Parameters
    ----------
    repulsion : float
    beads : int
        Of a chain.
    length : float
        Of a bond.
    samples : int
        Pairs of conformations; 0 for none.
    seed : int

    Returns
    -------
    dict of str to Quantity

    Raises
    ------
    ValueError
        If there are too few samples.
    """
    sampled = (np.nan, np.nan)
    if samples:
        sampled = sampled_second_virial(repulsion, beads, length, samples, seed)
    return {
        "sampled": Quantity(sampled[0], VIRIAL, "B2 of two chains, sampled"),
        "sampled_error": Quantity(sampled[1], VIRIAL, "standard error"),
        "fitted": Quantity(
            float(chain_second_virial(repulsion, beads, length)), VIRIAL, "B2 by Eqs. 18 to 24"
        ),
        "bead": Quantity(float(second_virial(repulsion)), VIRIAL, "B2 of single beads"),
        "bead_older": Quantity(
            float(older_second_virial(repulsion)), VIRIAL, "B2 of single beads by an older fit"
        ),
    }


def chain_pressure(
    density: float, repulsion: float, beads: int, length: float
) -> dict[str, Quantity]:
    """Pressure of a fluid of chains by three equations.

    Parameters
    ----------
    density : float
        Of the beads.
    repulsion : float
    beads : int
        Of a chain.
    length : float
        Of a bond.

    Returns
    -------
    dict of str to Quantity

    Raises
    ------
    NoSolution
        If the integral equation has none.
    """
    equations = {
        "GW": equation_of_state.gw(density, repulsion),
        "rGW": equation_of_state.rgw(density, repulsion),
        "crGW": equation_of_state.crgw(density / beads, repulsion, beads, length),
    }
    return {name: Quantity(float(p), PRESSURE, name) for name, p in equations.items()}


def chain_repulsion(
    equation: str, density: float, pressure: float, beads: int, length: float,
    stiffness: float | None = None,
) -> dict[str, Quantity]:  # fmt: skip
    """The repulsion at which an equation gives a pressure.

    Parameters
    ----------
    equation : str
        crGW, rGW or GW.
    density : float
        Of the chains.
    pressure : float
    beads : int
        Of a chain.
    length : float
        Of a bond.
    stiffness : float or None
        Of a bond; with it the rest length is calculated too, see `rest_length`.

    Returns
    -------
    dict of str to Quantity

    Raises
    ------
    NoSolution
        If the integral equation has none.
    ValueError
        If no repulsion gives that pressure.
    """
    if equation == "crGW":
        found = equation_of_state.crgw_repulsion(density, pressure, beads, length)
    elif equation == "rGW":
        found = equation_of_state.rgw_repulsion(beads * density, pressure)
    else:
        found = equation_of_state.gw_repulsion(beads * density, pressure)
    rest = np.nan
    if stiffness is not None:
        rest = bonds.rest_length(stiffness, float(found), length, beads * density, beads)
    return {
        "repulsion": Quantity(float(found), REPULSION, "repulsion a"),
        "rest_length": Quantity(rest, "r_c", "rest length of a bond"),
    }


def cross_repulsion(
    one: Mapping[str, Any], other: Mapping[str, Any], equation: str | None = None,
    inverse_chi: float | None = None,
) -> dict[str, Quantity]:  # fmt: skip
    """a_ij of two fluids of chains, athermal or at a chi.

    Parameters
    ----------
    one, other : dict
        Fields of a `dpd.theory.mixtures.Fluid`.
    equation : str or None
        crGW, rGW or GW, which gives the prefactors of an athermal mixture. Without it they are
        equal.
    inverse_chi : float or None
        Without it they mix without heat.

    Returns
    -------
    dict of str to Quantity

    Raises
    ------
    NoSolution
        If the integral equation has none.
    ValueError
        If no repulsion gives that chi, or both an equation and a chi are given.
    """
    fluids = Fluid(**one), Fluid(**other)
    if inverse_chi is None:
        found = _athermal(fluids, equation)
    elif equation is None:
        found = mixtures.thermal(*fluids, 1 / inverse_chi)
    else:
        raise ValueError(
            f"equation: {equation} is for mixtures without heat, and a chi is given; leave out "
            "equation or inverse_chi"
        )
    return {"repulsion": Quantity(found, REPULSION, "repulsion a_ij")}


def _athermal(fluids, equation):
    """a_ij without heat; GW and rGW take a chain for as many single beads."""
    if equation is None:
        return mixtures.athermal(*fluids)
    if equation == "crGW":
        pressures = [
            equation_of_state.crgw(fluid.density, fluid.repulsion, fluid.beads, fluid.length)
            for fluid in fluids
        ]
    else:
        of_beads = {"rGW": equation_of_state.rgw, "GW": equation_of_state.gw}[equation]
        fluids = [Fluid(fluid.bead_density, fluid.repulsion) for fluid in fluids]
        pressures = [of_beads(fluid.density, fluid.repulsion) for fluid in fluids]
    return mixtures.athermal(*fluids, pressures)


def chain_potential(
    density: float, repulsion: float, beads: int, length: float, solvent: float | None = None
) -> dict[str, Quantity]:
    """Excess chemical potential of a chain and of one of its beads, that also by HNC.

    Parameters
    ----------
    density : float
        Beads of the solvent per r_c^3.
    repulsion : float
        Of a bead of the chain and one of the solvent.
    beads : int
        Of the chain.
    length : float
        Of a bond.
    solvent : float or None
        Repulsion of the beads of the solvent; without it nothing is calculated by HNC.

    Returns
    -------
    dict of str to Quantity

    Raises
    ------
    NoSolution
        If the integral equation has none.
    """
    by_hnc = np.nan
    if solvent is not None:
        pairs = [[solvent, repulsion], [repulsion, 0.0]]
        by_hnc = float(excess_chemical_potentials(solve([density, 0.0], pairs))[1])
    chain = float(mixtures.chain_potential(repulsion, density, beads, length))
    bead = float(mixtures.monomer_potential(repulsion, density))
    return {
        "chain": Quantity(chain, "kT", "excess chemical potential of a chain, Eq. 34"),
        "bead": Quantity(bead, "kT", "excess chemical potential of a bead, Eq. 30"),
        "bead_by_hnc": Quantity(by_hnc, "kT", "excess chemical potential of a bead by HNC"),
    }


def rest_length(
    stiffness: float, repulsion: float, length: float, density: float, beads: int
) -> dict[str, Quantity]:
    """Rest length of a bond with a mean length, by `dpd.theory.bonds.rest_length`.

    Parameters
    ----------
    stiffness : float
        Of the bond, in kT / r_c^2.
    repulsion : float
    length : float
        The mean.
    density : float
        Beads of the fluid per r_c^3.
    beads : int
        Of the chain.

    Returns
    -------
    dict of str to Quantity

    Raises
    ------
    NoSolution
        If the integral equation has none.
    ValueError
        If the rest length would be negative.
    """
    found = bonds.rest_length(stiffness, repulsion, length, density, beads)
    return {"rest_length": Quantity(found, "r_c", "rest length of a bond")}


CALCULATIONS: dict[str, Callable[..., dict[str, Quantity]]] = {
    "monomer_fluid": monomer_fluid,
    "second_virial": second_virial_of_chains,
    "chain_pressure": chain_pressure,
    "chain_repulsion": chain_repulsion,
    "cross_repulsion": cross_repulsion,
    "chain_potential": chain_potential,
    "rest_length": rest_length,
}
