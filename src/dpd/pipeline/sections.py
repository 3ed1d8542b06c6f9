"""What config/config.yaml and a paper's file may say."""

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
    batch: float = setting(
        "Seconds: runs that are expected to take less share a job, as many as that makes.", 60, ge=0
    )
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
        "What is calculated where nothing is simulated: one calculation of the paper's own, which "
        "is a class in paper_figures/PAPER/calculations.py, with its arguments. Such a sweep has "
        "`axes` alone beside it. All points come together in sweeps/NAME.nc, as those of runs do; "
        "a point is calculated anew only if its arguments or the sources change.", None,
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
