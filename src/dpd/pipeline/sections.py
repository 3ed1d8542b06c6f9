"""What config/config.yaml and a paper's file may say, and what theory takes."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, Tag

from dpd.page import NAMES, OR_TABLE, OneOrMore, Refusals, Section, setting

Number = Annotated[float, Field(gt=0, le=1e6)]
Value = int | float | str  # of an axis; whole numbers stay whole
NAME, AXIS = r"^[a-z][a-z0-9_]{0,79}$", r"^[a-z_]+$"
NAMES[NAME] = "small letters, digits and _, up to 80"
NAMES[AXIS] = "small letters and _"
Name = Annotated[str, Field(pattern=NAME)]
AxisKey = Annotated[str, Field(pattern=AXIS)]
Path = Annotated[str, Field(pattern=r"^[^.]+(\.[^.]+)*$")]
Labelled = dict[Value, dict[Any, Any]]
SERIES = Literal[
    "kT", "pressure", "excess_conservative", "excess_all", "pressure_tensor",
    "pressure_tensor_all", "pair_energy", "bond_energy", "total_energy", "volume",
]  # fmt: skip
Measurement = Literal["lammps", "scaling", "schemes", "features", "tension"]


class Study(Section):
    """How long and how large the simulations are; see `dpd.pipeline.study.as_studied`."""

    description: str = setting("One line for the report.")
    parent: str = setting("The study whose values it has where it has none of its own.", "paper")
    first: list[Annotated[str, Field(pattern="[.]")]] | None = setting(
        "Sweeps whose runs begin before those of all others, as paper.sweep, the one of the "
        "greatest worth in front, so that a study that is stopped has made what matters most. Of "
        "each of them the shortest run is first. If not given, the longest run of all is first.",
        None,
    )

    def conflicts(self) -> Refusals:
        """Sweeps that are there twice."""
        first = self.first or []
        for name in sorted({each for each in first if first.count(each) > 1}):
            yield "first", f"{name!r} is there more than once; keep one"


class Config(Section):
    """Which study of which papers."""

    study: str = setting("Name of one of the studies.")
    studies: dict[
        str,
        Annotated[Annotated[str, Tag("=one")] | Annotated[Study, Tag("=table")], OR_TABLE],
    ] = setting("Studies by name; a name alone is that of the parent, as `night: quick`.")
    seed: int = setting(
        "That all random numbers of the study follow from. With another than 1 its results are "
        "results/STUDY-seedN, and STUDY-seedN is its name in all commands.", 1, ge=1, le=10**9,
    )  # fmt: skip
    longest_job: int = setting(
        "Minutes that a job on a cluster may ask for; a run that needs more goes on in its next "
        "try.", 1440, ge=10,
    )  # fmt: skip
    papers: list[str] = setting("Names of files in config/papers.", min_length=1)

    def conflicts(self) -> Refusals:
        """Studies without the one whose values the papers' files have first, and theirs."""
        if "paper" not in self.studies:
            yield "studies", "the study 'paper' is missing, of which all others are children"
        for name, study in self.studies.items():
            for key, text in () if isinstance(study, str) else study.conflicts():
                yield f"studies.{name}.{key}", text


class Derive(Section):
    """A value of the scene that another sweep measures."""

    from_: str = Field(alias="from", description="Name of the sweep that measures it.")
    quantity: str = setting(
        "closest_contact: 2 r_0 of Liu et al. 2008, the lower edge of the first bin of g(r) that "
        "is not empty in one configuration, median over configurations. Of a sweep of theory: a "
        "number that it calculates, by its name in the sweep file."
    )


class SweptAxis(Section):
    """A swept parameter."""

    set: OneOrMore[Path] | None = setting(
        "Key or keys of the scene, or of the theory, that take the value, joined with dots; "
        "numbers count list items from 0.", None,
    )  # fmt: skip
    values: Annotated[
        Annotated[list[Value], Tag("=one")] | Annotated[Labelled, Tag("=table")], OR_TABLE
    ] = setting(
        "Numbers or names to put there; or a map from a label to the parts of the scene, or of the "
        "theory, that it changes."
    )
    labels: list[Value] | None = setting(
        "The labels of such a map that are taken; all if not given.", None, min_length=1
    )
    offset: float = setting(
        "Added to each value before it is set, so a label can be an excess.", 0.0
    )
    text: str | None = setting(
        'Text that the value is put into before it is set, as "A {}" for a chain length.', None,
        pattern=r"^[^{}]*\{\}[^{}]*$",
    )  # fmt: skip
    units: str = setting("Units of the axis.", "1")
    long_name: str | None = setting("Name for plots.", None)


class SweepFile(Section):
    """A family of runs, or of calculations."""

    scene: dict[Any, Any] | None = setting(
        "A scene, see below; the axes fill in what is swept. A sweep has this or `theory`.", None
    )
    theory: dict[Any, Any] | None = setting(
        "What is calculated where nothing is simulated, see Theory below. Such a sweep has `axes` "
        "alone beside it.", None,
    )  # fmt: skip
    replicas: int = setting(
        "Number of runs of each point, each with a seed of its own.", 1, ge=1, le=1000
    )
    sampling: Number = setting("Factor on the steps and durations of every run.", 1.0)
    series: list[SERIES] = setting(
        "Time series that the sweep file keeps whole, each NAME as NAME_series, if all runs share "
        "one time axis.", ["kT"],
    )  # fmt: skip
    seeds: str | None = setting(
        "Name from which the seeds follow, if it is not that of the sweep. After renaming a sweep, "
        "put its former name here, and its runs stay valid.", None,
    )  # fmt: skip
    derive: dict[Path, Derive] | None = setting(
        "Values of the scene that another sweep of the paper measures first, by the key that takes "
        "them. A point takes the result of the point of the other sweep that has the same values "
        "on the axes that both sweeps have. Until it is measured, the value in the scene serves "
        "for planning.", None,
    )  # fmt: skip
    axes: dict[AxisKey, SweptAxis] | None = setting(
        "Swept parameters; the points are all combinations.", None
    )


class Sampling(Section):
    """What the paper says of its own sampling."""

    sweeps: list[str] = setting("Names of sweeps that do what the paper did.", min_length=1)
    at: dict[str, Annotated[list[Value], Field(min_length=1)]] | None = setting(
        "Labels on axes of these sweeps, if it says so of some points alone.", None
    )
    steps: int | None = setting("Steps that the paper sampled.", None, ge=1)
    dt: float | None = setting("Its time step in tau, if runs of ours have another.", None, gt=0)
    duration: float | None = setting(
        "Time in tau that it sampled, if it gives that and no steps.", None, gt=0
    )
    runs: int | None = setting("Runs of that many steps, if there were several.", None, ge=1)
    at_least: bool = setting('Whether the text says "at least".', False)
    beads: int | None = setting("Number of beads in its system.", None, ge=1)
    molecules: int | None = setting("Number of molecules in its system.", None, ge=1)
    where: str = setting("Section, figure or table that says so, or that leaves it unsaid.")

    def conflicts(self) -> Refusals:
        """Steps and a duration, and what belongs to steps without them."""
        if self.steps is not None and self.duration is not None:
            yield "duration", "there are 'steps' as well; keep one"
        for key in ("runs", "dt"):
            if getattr(self, key) is not None and self.steps is None:
                yield key, "the key 'steps' is missing, which it belongs to"


class FigureFile(Section):
    """What a figure is made from."""

    sweeps: list[str] = setting("Names of sweeps.", [])
    measurements: list[str] = setting("Names of measurements.", [])


class PaperFile(Section):
    """The sweeps of a paper, timings of the engine, and the figures that are made from them."""

    title: str = setting("Title for the report.")
    reference: str = setting("Where it was published.", "")
    sweeps: dict[Name, SweepFile] = setting("Named families of runs.")
    measurements: list[Measurement] = setting(
        "Timings of the engine that figures need; for the benchmark.", []
    )
    sampling: list[Sampling] = setting(
        "What the paper says of its own sampling. The report compares the sweeps with it. What the "
        "paper leaves unsaid has a `where` alone; sweeps that are not named have no counterpart in "
        "the paper.", [],
    )  # fmt: skip
    figures: dict[Name, FigureFile] = setting(
        "What each figure is made from, by the name of its file in paper_figures.", {}
    )

    def conflicts(self) -> Refusals:
        """Measurements that are there twice, and what it says of its own sampling."""
        for name in {each for each in self.measurements if self.measurements.count(each) > 1}:
            yield "measurements", f"{name!r} is there more than once; keep one"
        for number, said in enumerate(self.sampling):
            for key, problem in said.conflicts():
                yield f"sampling.{number}.{key}", problem


# --- theory: functions of src/dpd/theory/calculations.py. Lengths in r_c, energies in kT.

Repulsion = Number
Density = Annotated[float, Field(gt=0, le=1000)]
Equation = Literal["GW", "rGW", "crGW"]
OF_REPULSION, OF_DENSITY = "Largest repulsion a in kT / r_c.", "Beads per r_c^3."


class MonomerFluid(Section):
    """A fluid of single beads: structure and pressure.

    Its structure is that of the Ornstein-Zernike equation with the HNC closure; its pressure is
    given by that and by equations of state.
    """

    density: Density = setting(OF_DENSITY)
    repulsion: Repulsion = setting(OF_REPULSION)


class Chain(Section):
    """Repulsion and shape of a molecule."""

    repulsion: Repulsion = setting(OF_REPULSION)
    beads: int = setting("Of a molecule.", 1, ge=1, le=1000)
    length: float = setting("Of a bond.", 0.0, unit="r_c", ge=0, le=20)


class SecondVirial(Chain):
    """Second virial coefficient of two chains.

    Sampled, by the fit of the chain-revised equation of state, and, of single beads, in closed form
    and by an older fit.
    """

    samples: int = setting("Pairs of conformations; 0 for none.", 0, ge=0, le=10**9)
    seed: int | None = setting(
        "Of the samples; if not given, that of the study.", None, ge=1, le=10**9
    )


class ChainPressure(Chain):
    """Pressure of a fluid of chains by three equations of state."""

    density: Density = setting(OF_DENSITY)


class ChainRepulsion(Section):
    """The repulsion that gives a fluid of chains a pressure, by one equation of state."""

    equation: Equation = setting("Which.")
    density: Density = setting("Molecules per r_c^3.")
    pressure: Number = setting("In kT / r_c^3.")
    beads: int = setting("Of a molecule.", 1, ge=1, le=1000)
    length: float = setting("Of a bond.", 0.0, unit="r_c", ge=0, le=20)
    stiffness: float | None = setting(
        "Spring constant of a bond; with it the rest length is calculated as well.", None,
        unit="kT / r_c^2", gt=0, le=1e7,
    )  # fmt: skip


class Fluid(Chain):
    """A pure fluid."""

    density: Density = setting("Molecules per r_c^3.")


class CrossRepulsion(Section):
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


class ChainPotential(Chain):
    """Excess chemical potentials at the pressure 41.89.

    Of a chain and of one of its beads in a fluid of beads, by fits of the chain-revised equation of
    state.
    """

    density: Density = setting(OF_DENSITY)
    solvent: Number | None = setting(
        "Repulsion of the beads of the fluid, for the HNC closure; without it that is left out.",
        None,
    )


class RestLength(Section):
    """The rest length with which a harmonic bond has a mean length.

    In a fluid of beads that repel each other, those of the bond too; the cavity function of the
    fluid is that of single beads, by the HNC closure. The other beads of a chain push those of a
    bond apart; that is a fit to simulations of chains of 3 to 8 beads.
    """

    stiffness: float = setting("Spring constant.", unit="kT / r_c^2", gt=0, le=1e7)
    repulsion: Repulsion = setting(OF_REPULSION)
    length: float = setting("The mean length.", unit="r_c", gt=0, le=20)
    density: float = setting("Beads of the fluid per r_c^3.", 0.0, ge=0, le=1000)
    beads: int = setting("Of the chain.", 2, ge=2, le=1000)


ARGUMENTS: dict[str, type[Section]] = {
    "monomer_fluid": MonomerFluid, "second_virial": SecondVirial, "chain_pressure": ChainPressure,
    "chain_repulsion": ChainRepulsion, "cross_repulsion": CrossRepulsion,
    "chain_potential": ChainPotential, "rest_length": RestLength,
}  # fmt: skip
