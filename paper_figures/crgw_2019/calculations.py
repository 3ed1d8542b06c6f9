"""What the paper's sweeps calculate; lengths are in r_c, energies in kT."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from dpd.page import Calculation, Positive, Quantity, Refusals, Section, setting

Density = Annotated[float, Field(gt=0, le=1000)]
Equation = Literal["GW", "rGW", "crGW"]
OF_REPULSION, OF_DENSITY = "Largest repulsion a in kT / r_c.", "Beads per r_c^3."
PRESSURE, VIRIAL = "kT / r_c^3", "r_c^3"
NAN = float("nan")


class MonomerFluid(Calculation, key="monomer_fluid"):
    """A fluid of single beads: structure and pressure.

    Its structure is that of the Ornstein-Zernike equation with the HNC closure; its pressure is
    given by that and by equations of state.
    """

    density: Density = setting(OF_DENSITY)
    repulsion: Positive = setting(OF_REPULSION)

    def calculate(self) -> dict[str, Quantity]:
        from dpd.theory.equation_of_state import gw, rgw
        from dpd.theory.integral_equations import R, solve
        from paper_figures.crgw_2019 import thermodynamics

        density, repulsion = self.density, self.repulsion
        fluid, shown = solve(density, repulsion), R <= 3
        energy = thermodynamics.energy(fluid) / density
        by_compressibility = thermodynamics.compressibility_pressure(density, repulsion)
        potential = float(thermodynamics.excess_chemical_potentials(fluid)[0])
        return {
            "r": Quantity(R[shown], "r_c", "distance", ("r",)),
            "rdf": Quantity(fluid.g[shown, 0, 0], "1", "g(r) by HNC", ("r",)),
            "pressure": Quantity(
                thermodynamics.pressure(fluid), PRESSURE, "virial pressure by HNC"
            ),
            "pressure_by_compressibility": Quantity(
                by_compressibility, PRESSURE, "pressure by HNC, from the compressibility"
            ),
            "energy": Quantity(energy, "kT", "energy per bead by HNC"),
            "chemical_potential": Quantity(potential, "kT", "excess chemical potential by HNC"),
            "pressure_gw": Quantity(gw(density, repulsion), PRESSURE, "GW"),
            "pressure_rgw": Quantity(rgw(density, repulsion), PRESSURE, "rGW"),
        }


class Chain(Section):
    """Repulsion and shape of a molecule."""

    repulsion: Positive = setting(OF_REPULSION)
    beads: int = setting("Of a molecule.", 1, ge=1, le=1000)
    length: float = setting("Of a bond.", 0.0, unit="r_c", ge=0, le=20)


class SecondVirial(Chain, Calculation, key="second_virial"):
    """Second virial coefficient of two chains.

    Sampled, by the fit of the chain-revised equation of state, and, of single beads, in closed form
    and by an older fit.
    """

    samples: int = setting("Pairs of conformations; 0 for none.", 0, ge=0, le=10**9)
    seed: int | None = setting(
        "Of the samples; if not given, that of the study.", None, ge=1, le=10**9
    )

    def calculate(self) -> dict[str, Quantity]:
        from dpd.theory.equation_of_state import chain_second_virial, second_virial
        from paper_figures.crgw_2019 import sampled_virial

        a, beads, length = self.repulsion, self.beads, self.length
        value, error = NAN, NAN
        if self.samples:
            value, error = sampled_virial.sampled_second_virial(
                a, beads, length, self.samples, self.seed or 1
            )
        fitted = float(chain_second_virial(a, beads, length))
        older = float(sampled_virial.older_second_virial(a))
        return {
            "sampled": Quantity(value, VIRIAL, "B2 of two chains, sampled"),
            "sampled_error": Quantity(error, VIRIAL, "standard error"),
            "fitted": Quantity(fitted, VIRIAL, "B2 by Eqs. 18 to 24"),
            "bead": Quantity(float(second_virial(a)), VIRIAL, "B2 of single beads"),
            "bead_older": Quantity(older, VIRIAL, "B2 of single beads by an older fit"),
        }


class ChainPressure(Chain, Calculation, key="chain_pressure"):
    """Pressure of a fluid of chains by three equations of state."""

    density: Density = setting(OF_DENSITY)

    def calculate(self) -> dict[str, Quantity]:
        from dpd.theory.equation_of_state import crgw, gw, rgw

        equations = {
            "GW": gw(self.density, self.repulsion),
            "rGW": rgw(self.density, self.repulsion),
            "crGW": crgw(self.density / self.beads, self.repulsion, self.beads, self.length),
        }
        return {name: Quantity(float(p), PRESSURE, name) for name, p in equations.items()}


class ChainRepulsion(Calculation, key="chain_repulsion"):
    """The repulsion that gives a fluid of chains a pressure, by one equation of state."""

    equation: Equation = setting("Which.")
    density: Density = setting("Molecules per r_c^3.")
    pressure: Positive = setting("In kT / r_c^3.")
    beads: int = setting("Of a molecule.", 1, ge=1, le=1000)
    length: float = setting("Of a bond.", 0.0, unit="r_c", ge=0, le=20)
    stiffness: float | None = setting(
        "Spring constant of a bond; with it the rest length is calculated as well.", None,
        unit="kT / r_c^2", gt=0, le=1e7,
    )  # fmt: skip

    def calculate(self) -> dict[str, Quantity]:
        from dpd.theory.equation_of_state import crgw, gw, repulsion_of, rgw
        from paper_figures.crgw_2019.bonds import rest_length

        beads, length, of_beads = self.beads, self.length, self.beads * self.density
        if self.equation == "crGW":
            found = repulsion_of(self.pressure, crgw, self.density, beads, length)
        else:
            equation = rgw if self.equation == "rGW" else gw
            found = repulsion_of(self.pressure, equation, of_beads)
        repulsion, rest = float(found), NAN
        if self.stiffness is not None:
            rest = rest_length(self.stiffness, repulsion, length, of_beads, beads)
        return {
            "repulsion": Quantity(repulsion, "kT / r_c", "repulsion a"),
            "rest_length": Quantity(rest, "r_c", "rest length of a bond"),
        }


class Fluid(Chain):
    """A pure fluid."""

    density: Density = setting("Molecules per r_c^3.")


class CrossRepulsion(Calculation, key="cross_repulsion"):
    """The repulsion of the beads of two fluids of chains that mix without heat, or have a chi."""

    one: Fluid = setting("A pure fluid.")
    other: Fluid = setting("A pure fluid.")
    equation: Equation | None = setting(
        "Which gives the prefactors of an athermal mixture, from both pressures; if not given, "
        "they are equal.", None,
    )  # fmt: skip
    inverse_chi: Density | None = setting(
        "1 / chi, at the pressure 41.89; if not given, the repulsion is the athermal one.", None
    )

    def conflicts(self) -> Refusals:
        """An equation has nothing to say of a chi."""
        if self.equation is not None and self.inverse_chi is not None:
            yield (
                "equation",
                (
                    f"{self.equation} is for mixtures without heat, and a chi is given; leave out "
                    "equation or inverse_chi"
                ),
            )

    def calculate(self) -> dict[str, Quantity]:
        from paper_figures.crgw_2019 import mixing

        fluids = [mixing.Fluid(**fluid.model_dump()) for fluid in (self.one, self.other)]
        if self.inverse_chi is None:
            found = mixing.athermal_by(self.equation, *fluids)
        else:
            found = mixing.thermal(*fluids, 1 / self.inverse_chi)
        return {"repulsion": Quantity(found, "kT / r_c", "repulsion a_ij")}


class ChainPotential(Chain, Calculation, key="chain_potential"):
    """Excess chemical potentials at the pressure 41.89.

    Of a chain and of one of its beads in a fluid of beads, by fits of the chain-revised equation of
    state.
    """

    density: Density = setting(OF_DENSITY)
    solvent: Positive | None = setting(
        "Repulsion of the beads of the fluid, for the HNC closure; without it that is left out.",
        None,
    )

    def calculate(self) -> dict[str, Quantity]:
        from dpd.theory.integral_equations import solve
        from paper_figures.crgw_2019 import mixing
        from paper_figures.crgw_2019.thermodynamics import excess_chemical_potentials

        a, density, by_hnc = self.repulsion, self.density, NAN
        if self.solvent is not None:
            fluid = solve([density, 0.0], [[self.solvent, a], [a, 0.0]])
            by_hnc = float(excess_chemical_potentials(fluid)[1])
        chain = float(mixing.chain_potential(a, density, self.beads, self.length))
        bead = float(mixing.monomer_potential(a, density))
        return {
            "chain": Quantity(chain, "kT", "excess chemical potential of a chain, Eq. 34"),
            "bead": Quantity(bead, "kT", "excess chemical potential of a bead, Eq. 30"),
            "bead_by_hnc": Quantity(by_hnc, "kT", "excess chemical potential of a bead by HNC"),
        }


class RestLength(Calculation, key="rest_length"):
    """The rest length with which a harmonic bond has a mean length.

    In a fluid of beads that repel each other, those of the bond too; the cavity function of the
    fluid is that of single beads, by the HNC closure. The other beads of a chain push those of a
    bond apart; that is a fit to simulations of chains of 3 to 8 beads.
    """

    stiffness: float = setting("Spring constant.", unit="kT / r_c^2", gt=0, le=1e7)
    repulsion: Positive = setting(OF_REPULSION)
    length: float = setting("The mean length.", unit="r_c", gt=0, le=20)
    density: float = setting("Beads of the fluid per r_c^3.", 0.0, ge=0, le=1000)
    beads: int = setting("Of the chain.", 2, ge=2, le=1000)

    def calculate(self) -> dict[str, Quantity]:
        from paper_figures.crgw_2019.bonds import rest_length

        found = rest_length(self.stiffness, self.repulsion, self.length, self.density, self.beads)
        return {"rest_length": Quantity(found, "r_c", "rest length of a bond")}
