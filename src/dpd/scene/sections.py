"""What every scene says beside its terms and observables: one section a class."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, Tag

from dpd.page import MOST_STEPS, OR_TABLE, OneOrMore, Refusals, Section, Species, setting

CUTOFF = 1.0
LARGEST_SEED = 2**63 - 1
Edge = Annotated[float, Field(gt=0, le=1e6)]


class MoleculeKind(Section):
    """A kind of molecule, and how many of them there are."""

    architecture: str = setting(
        'A molecule as species and repeats, "A", "A 10" or "A 3 B 9 A 3". In brackets a branch, '
        'which hangs on the bead before it, "A 3 (B 2) (C 4 (D)) A 3"; or, with a number behind '
        'it, a group that is repeated along the chain, "(A 2 B) 4". A species is a letter, then '
        "letters, digits, _, + or -, as W1, tail or Na+."
    )
    density: float | None = setting(
        "Beads of these molecules per r_c^dimension.", None, gt=0, le=1000
    )
    count: int | None = setting("Number of molecules, instead of a density.", None, ge=1, le=10**8)


class Pairs(Section):
    """How pairs are found; it decides the speed, not the result."""

    search: Literal["auto", "cells", "list"] = setting(
        "Cells sorted every step, or a list that lasts while beads hardly move; auto takes the "
        "list for dt sqrt(kT) up to 0.005 in two dimensions, 0.001 in three.", "auto",
    )  # fmt: skip
    skin: float = setting(
        "Distance beyond the cutoff within which pairs are listed.", 0.15, unit="r_c", gt=0, le=1
    )


class StartCore(Section):
    """Rigid core, as above."""

    radius: float | None = setting(
        "Core radius r_s; 0 for none.", None, unit="r_c", ge=0, lt=0.5
    )  # fmt: skip
    force: float | None = setting("Force F_max.", None, unit="kT / r_c", ge=0, le=1e6)
    smooth: float | None = setting("Width of its edge.", None, unit="r_c", ge=0, le=1)


class StartBond(Section):
    """Bonds, as above."""

    stiffness: float | None = setting("Spring constant C.", None, unit="kT / r_c^2", ge=0, le=1e7)
    length: float | None = setting("Rest length.", None, unit="r_c", ge=0, le=1000)


class StartForces(Section):
    """Forces of growth and relaxation, where they are not those of the run."""

    core: StartCore | None = setting("Rigid core, as above.", None)
    bond: StartBond | None = setting("Bonds, as above.", None)
    gamma: float | None = setting("Friction.", None, ge=0, le=1e6)


class Polymerize(Section):
    """How chains grow."""

    radius: float = setting("Reaction radius.", 1.0, unit="r_c", gt=0, le=2)
    partner: Literal["random", "nearest"] = setting(
        "Which free monomer within the radius a growing end tries first.", "random"
    )
    initiators: float = setting(
        "Number of chains that begin to grow, divided by the number wanted; the first to finish "
        "are kept.", 1.05, ge=1, le=2,
    )  # fmt: skip
    spare: float = setting(
        "Monomers beyond those that the chains need, as a share of those; they are removed at the "
        "end.", 0.2, ge=0, le=2,
    )  # fmt: skip
    interval: float = setting(
        "Time between two tries of a growing end.", 0.05, unit="tau", ge=1e-6, le=1e6
    )
    mixing: float = setting(
        "Mean time after which a free monomer is moved to a random place; otherwise bonds would "
        "wall it in.", 0.5, unit="tau", ge=1e-6, le=1e6,
    )  # fmt: skip
    dt: float = setting("Time step of the growth.", 0.002, unit="tau", ge=1e-9, le=10)


class Relax(Section):
    """Steps with gw-vv before the run, shared by all runs from the same start."""

    steps: int = setting("Steps of relaxation.", ge=1, le=10**9)
    dt: float = setting("Their time step.", unit="tau", ge=1e-9, le=10)


class Start(Section):
    """The first configuration."""

    method: Literal["random", "slabs", "polymerize", "file"] = setting(
        "random: beads anywhere. slabs: each kind of molecule in a slab of its own along the "
        "longest axis. polymerize: chains that grow in two dimensions from monomers without "
        "crossing bonds (Liu et al. 2008); 20 000 beads in chains of 100 take half a minute, in "
        "chains of 200 a minute. file: as it stands in a file.", "random",
    )  # fmt: skip
    path: str | None = setting(
        "For method file: GSD (.gsd), LAMMPS data (.data, .lmp, data.NAME), or a run.nc, start.nc "
        "or .checkpoint of this program; it must have the box and the molecules of the scene; at "
        "constant pressure its box is that of the start. A relative path counts from the file of "
        "the scene.", None, min_length=1,
    )  # fmt: skip
    frame: int | None = setting(
        "For method file: which configuration of a trajectory, from 0, or from the last with -1, "
        "-2 ...; if not given, the last.", None, ge=-(10**9), le=10**9,
    )  # fmt: skip
    sha256: str | None = setting(
        "For method file: the digest that its content must have. If not given, it is found and "
        "becomes part of the scene.", None, pattern=r"^[0-9a-f]{64}$",
    )  # fmt: skip
    kT: float | None = setting(
        "Temperature of the first velocities, if not the thermostat's.", None, ge=1e-6, le=1e6
    )
    seed: int | None = setting(
        "Seed of the start, if not that of the run.", None, ge=0, le=LARGEST_SEED
    )
    forces: StartForces = setting(
        "Forces of growth and relaxation, where they are not those of the run.", StartForces
    )
    polymerize: Polymerize = setting("How chains grow.", Polymerize)
    relax: Relax | None = setting(
        "Steps with gw-vv before the run, shared by all runs from the same start.", None
    )

    def conflicts(self) -> Refusals:
        """Keys of a start from a file have no effect on other ones."""
        for key in ("path", "frame", "sha256"):
            if getattr(self, key) is not None and self.method != "file":
                yield (
                    key,
                    f"has no effect with method {self.method!r}; take 'method: file', or remove "
                    "the key",
                )
        if self.method == "file" and self.path is None:
            yield "", "the key 'path' is missing: the file that method 'file' reads"
        if self.forces != StartForces() and self.relax is None and self.method != "polymerize":
            yield (
                "forces",
                "has no effect: nothing is relaxed or grown; add start.relax, as {steps: 1000, "
                "dt: 0.01}, or remove the key",
            )


class PageFile(Section):
    """A file with pages, as results name it."""

    path: str = setting("Where it lies.", min_length=1)
    sha256: str = setting("The digest that it must have.", min_length=1)


class Steps(Section):
    """Length of the run in steps."""

    equilibrate: int | None = setting("Steps before sampling begins.", None, ge=0, le=MOST_STEPS)
    sample: int | None = setting("Steps with sampling.", None, ge=1, le=MOST_STEPS)


class Duration(Section):
    """Length of the run in tau. If both steps and duration are given, the longer one counts."""

    equilibrate: float | None = setting("Time before sampling begins.", None, ge=0, le=1e9)
    sample: float | None = setting("Time with sampling.", None, gt=0, le=1e9)


class Basics(Section):
    """One system and how long it is simulated.

    Reduced units: length r_c, energy kT, mass m, time tau = sqrt(m r_c^2 / kT).
    """

    dimension: int = setting("Number of space dimensions.", ge=2, le=3)
    box: OneOrMore[Edge] = setting(
        "Edge of the periodic box, one number or one per axis; at least two cutoffs. Along an axis "
        "with walls the distance of the two planes.", unit="r_c",
    )  # fmt: skip
    molecules: list[MoleculeKind] = setting(
        "What the box holds, in the order in which slabs are filled.", min_length=1
    )
    mass: dict[Species, Annotated[float, Field(ge=1e-3, le=1e6)]] | None = setting(
        "Mass of a bead of each species, as {A: 1, B: 2}; 1 for those that are not named.", None,
        unit="m", of="some species", min_length=1,
    )  # fmt: skip
    pairs: Pairs = setting("How pairs are found; it decides the speed, not the result.", Pairs)
    start: Start = setting("The first configuration.", Start)
    steps: Steps = setting("Length of the run in steps.", Steps)
    duration: Duration = setting(
        "Length of the run in tau. If both steps and duration are given, the longer one counts.",
        Duration,
    )  # fmt: skip
    pages: list[
        Annotated[
            Annotated[str, Tag("=one")] | Annotated[PageFile, Tag("=table")], OR_TABLE
        ]
    ] = setting(
        "Python files with observables of your own; a relative path counts from the file of the "
        "scene.", [],
    )  # fmt: skip
    observe: list[Any] = setting("What is measured, by name, or by name with settings.", ["thermo"])
    unstable: Literal["fail", "record"] = setting(
        "What happens if a run blows up or its bonds get too long for the box: it fails, or its "
        "result records that it did (for maps of stability).", "fail",
    )  # fmt: skip
    keep_state: bool | None = setting(
        "Whether run.nc keeps the last configuration, and what `dpd extend` needs to make the run "
        "longer. If not given, `dpd run` keeps it and a study does not.", None,
    )  # fmt: skip
    seed: int = setting("Seed of start and noise.", 1, ge=0, le=LARGEST_SEED)

    def conflicts(self) -> Refusals:
        """What sections have against each other, and molecules."""
        for place, kind in enumerate(self.molecules):
            if (kind.density is None) == (kind.count is None):
                yield f"molecules.{place}", "needs a density or a count, and not both"
        for key, problem in self.start.conflicts():
            yield f"start.{key}" if key else "start", problem
        edges = self.box if isinstance(self.box, list) else [self.box] * self.dimension
        if len(edges) != self.dimension:
            yield "box", f"{len(edges)} edges in {self.dimension} dimensions"
        elif min(edges) < 2 * CUTOFF:
            yield (
                "box",
                f"an edge of {min(edges):g} is smaller than two cutoffs, a bead would meet another "
                f"one twice; allowed: >= {2 * CUTOFF:g}",
            )
