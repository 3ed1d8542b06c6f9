"""config/README.md: keys of the files in config, and what result files hold."""

from dpd.pipeline.sections import ARGUMENTS, Config, PaperFile
from dpd.report.keys import rows_of, scene_rows, section_rows, text_of
from dpd.report.variables import run_table, sweep_table, verdict_table
from dpd.scene.sections import Basics

INTRODUCTION = """# Configuration and result files

`python -m dpd readme` writes this page from the settings in the sources: of terms in
`src/dpd/physics`, of observables in `src/dpd/observe`, of the rest in `src/dpd/scene/sections.py`
and `src/dpd/pipeline/sections.py`. Edit those.

- `config.yaml` says which study of which papers `snakemake` makes. A *study* says how long and how
  large the simulations are.
- `papers/` holds one file for each paper: its sweeps and its figures. A *sweep* is a family of runs
  that differ in one or more parameters. What a study changes stands beside the value: `box: {paper:
  10, smoke: 6}`.
- Systems to run alone are in `src/dpd/scenes`; `python -m dpd new` lists them, and `python -m dpd
  new fluid` writes one into your folder. A *scene* is one system and how long it is simulated. With
  `--schema`, editors that have a YAML language server complete its keys.

## Edit a sweep

Change the `values` of an axis in the paper's file. Only new points of the sweep are run.

## Add a study

Give it a line in `config.yaml`, as `studies: {night: quick}`. It is `quick`, but for the values
that you give it in the papers' files, as `sample: {paper: 100000, quick: 5000, night: 40000}`: a
value, the values of an axis, the number of replicas, a whole section. A study that is not named
there takes what its parent takes, and `paper` is the parent of all. A key that has no value for a
study, or `null`, is left out. `--config study=night` makes it.

## Run a study with other random numbers

`snakemake --cores 2 --config seed=2` makes the study anew, every run with a seed of its own, in
`results/STUDY-seed2`. `STUDY-seed2` is the name of a study in all commands, as in `python -m dpd
status quick-seed2`. `python -m dpd compare quick quick-seed2` says whether the two differ as their
error bars predict.

## Calculate instead of simulating

A sweep that has a `theory` in the place of its `scene` calculates something at each point. It needs
no runs, and a figure that is made from such sweeps alone starts no simulation:

```yaml
pressures:
  theory: {monomer_fluid: {density: 3, repulsion: 25}}
  axes:
    density: {set: monomer_fluid.density, values: [2, 3, 4]}
```

`snakemake` calculates all points in one job; of an edited sweep it calculates the new ones only. A
scene may take what another sweep has calculated: `derive: {repulsion.A A: {from: SWEEP, quantity:
repulsion}}`. Points belong together if they have the same labels on the axes that both sweeps have.
A label of the scene's sweep may then change nothing itself, as in `values: {GW: {}, rGW: {}}`.

## Rename a sweep

The random numbers of a sweep follow from its name, so all its points would run again under another
name. To keep the runs that you have:

1. Rename the sweep in the paper's file, in the `sweeps` of its figures, and in the figure files
   that read it. Give it its former name as `seeds: OLD_NAME`.
2. `mv results/STUDY/PAPER/runs/OLD_NAME results/STUDY/PAPER/runs/NEW_NAME`, for each study.

Then `snakemake` gathers the runs again and simulates nothing. It keeps no record of files that were
moved. If the sweep is edited later, it refuses runs that no longer belong to it and prints the
command that makes them again. Two sweeps of a paper must not have the same seeds.

## Add a paper

1. Copy `config/papers/example.yaml` to `config/papers/NAME.yaml`, and change it. A title and a
   sweep are all that it needs. `snakemake --cores 2 --config papers='[example]'` makes the report
   of the example, and with NAME in its place that of yours.
2. Write one file for each figure, `paper_figures/NAME/FIGURE.py`: copy
   `paper_figures/example/scaled_pressure.py`. It needs the functions `compute` and `draw`, and the
   text `TITLE`.

The rest is for papers whose numbers you want to hold against your own:

3. Put the numbers that the paper prints into `paper_figures/published.yaml`. The figure that
   measures them has a function `measured`, as those of the other papers, and may say in
   `PAPER_SHOWS` what the paper's own figure shows.
4. Write what the paper says of its own sampling under `sampling`, for the report's comparison.
5. Add NAME to `papers` in `config/config.yaml`, so that it is made without being asked for.
6. To keep its verdicts in git with `python -m dpd archive STUDY`, and to give it a page, write its
   findings into `paper_figures/NAME/findings.md` and its reference into `CITATION.cff`. The page
   shows each picture that stands beside its figure file, as `FIGURE.png`.

## Whole molecules

A scene with a density gets the nearest whole number of molecules. If that misses the density by
more than 1 %, the scene is refused, and the message names a box and a count that fit.

## Walls and flows

`walls` puts a soft plane at both ends of an axis. Nothing repeats along it. `box` is then the
distance of the planes, and densities and pressures are per volume between them. Beads may get a
little behind a plane, so files and pictures have a longer box, with empty space behind both planes
and the fluid in the middle. Profiles count from the lower plane. A file to begin with may have
either box.

The observable `walls` measures the pressure of the fluid on each wall. The pressure of `thermo` is
an average over the whole space between the planes, and near them the fluid is not that of the bulk:
for the bulk take `wall_pressure`, and the density in the middle of `profile`.

Walls with a `gamma` take hold of beads as pair friction does; along smooth walls a fluid slips
freely. The slip length says how far behind the plane the flow would be at rest
(`dpd.analysis.flow.channel_flow`). For the fluid of density 3, repulsion 25 and gamma 4.5 it is
-0.04 +- 0.04 r_c at walls with gamma 4.5, -0.21 +- 0.05 with 9 and -0.30 +- 0.02 with 20: there
the fluid is at rest in front of the plane. Walls with a `velocity` shear the fluid between them.

`body_force` drives a flow between walls. With `opposite` it drives two flows in opposite directions
in a periodic box: its net force is 0 on the average, and as the numbers of beads in both halves
fluctuate, so does the total momentum a little. kT and pressures are those about the flow, whose
profile is fitted in each sample, and count the degrees of freedom that conserved momentum leaves
(`src/dpd/observe/thermo.py`). `temperature_profile` of `velocity_profile` says where the fluid is
hot. A cluster alone in a box keeps its angular momentum too: of its 3 (N - 1) degrees of freedom 3
stay as the start has left them, and kT of few beads shows it.

## An observable of your own

A function of a snapshot is enough:

```python
import dpd


def span(snapshot):
    "Squared distance between the ends of chains of five beads, in r_c^2."
    chains = snapshot.unwrapped.reshape(-1, 5, snapshot.dimension)
    return ((chains[:, -1] - chains[:, 0]) ** 2).sum(axis=1).mean()


run = dpd.run("chains.yaml", observe=[span])  # run.span, a series with its mean and error
```

It returns a number or an array. It is called every 0.8 tau, or as a scene says that names its file,
`pages: [mine.py]` and `observe: [{span: {every: 20}}]`. It may also stand in a script, which then
runs below `if __name__ == "__main__":`, or in a cell of a notebook that imports what it uses.

A class can say more: its settings, what it `gives` (dimensions, units, a name for plots) and how to
`measure` that in a snapshot. Here it stands in `gyration.py`, beside the scene:

```python
import numpy as np
from dpd.page import Change, Observable, setting


class Gyration(Observable, key="gyration"):
    "Squared radius of gyration of the beads of one species in each molecule, mean over all."

    stands = frozenset({Change.STRETCHES, Change.FLOWS})
    needs_bonds = True
    gives = {"gyration": (("block",), "r_c^2", "squared radius of gyration")}
    of: str = setting("The species.", "A")

    def measure(self, now):
        chosen = now.of(self.of)
        x, molecule = now.unwrapped[chosen], now.molecules[chosen]
        count = np.bincount(molecule)
        means = [np.bincount(molecule, y) / count for y in x.T]
        squares = np.bincount(molecule, (x**2).sum(axis=1)) / count
        return (squares - np.square(means).sum(axis=0)).mean()
```

A scene names the file and the observable, as `pages: [gyration.py]` and `observe: [{gyration: {of:
A}}]`, in a paper with the path from `config/papers`. `python -m dpd run scene.yaml -o run.nc
--page gyration.py` names the file too.

The first dimension of what it gives says what is kept: `block`, means over blocks of the run;
`largest`, the largest in each block; `sample`, every sample; `run`, the mean; `last`, the last;
`frame`, means over as many samples each as its setting `average` says; `lag`, averages over pairs
of samples some time apart.
Further dimensions are those of `axes`, and `axis`, `bead`, `molecule`, `kind` and `species`. A
snapshot ([what it has](../src/dpd/observe/common/snapshot.py)) has `positions`, `unwrapped`,
`velocities`, `species`, `molecules`, `bonds`, `bond_vectors`, `box`, `time`, and `pairs(within)`.
Observables of the package have the same form ([`observe/`](../src/dpd/observe)): look there for
more, as for `finish`, for ratios of means. One that compares a sample with others keeps arrays,
which checkpoints have too; what follows from the scene alone is found once:

```python
import numpy as np
from dpd.page import Change, Observable, once


class Wandering(Observable, key="wandering"):
    "How far the molecules of the first kind have gone, and how long they remember their velocity."

    stands = frozenset({Change.FLOWS})
    gives = {
        "wandered": (("sample", "axis"), "r_c^2", "squared displacement since the first sample"),
        "memory": (("lag", "one"), "(r_c / tau)^2", "velocity times that some time before"),
    }
    compared = ("axis", "one")

    @once
    def beads(self, scene):
        kind = scene.molecules[0]
        return np.arange(kind.count * len(kind.beads)).reshape(kind.count, -1)

    def axes(self, scene):
        return {"one": scene.molecules[0].count}

    def keeps(self, scene):
        return {"first": np.zeros((scene.molecules[0].count, scene.dimension))}

    def measure(self, now):
        beads = self.beads(now.scene)
        centre = now.unwrapped[beads].mean(axis=1)
        if now.sample == 0:
            now.kept["first"][:] = centre
        wandered = ((centre - now.kept["first"]) ** 2).mean(axis=0)
        return {"wandered": wandered, "compared": now.velocities[beads].mean(axis=1).T}

    def compare(self, now, then):
        return (now * then).sum(axis=1)[:, None]
```

`stands` names what an observable was made for: `SLIDES` (a shear), `STRETCHES` (constant pressure),
`ENDS` (walls), `FLOWS` (a body force), `JUMPS` (a rigid core) and `PACE` (a `dt` that changes). It
is refused where a scene does what it has not named. An edited file makes its runs run again. A
result names the file with its digest, and only the same file is used to make that result longer.

## A pair force of your own

A file with an energy and the force that is its slope, here an attraction:

```python
from math import pi, sin, cos
from dpd.page import NotNegative, PairForce, PerPair, setting


class Attraction(PairForce, key="attraction"):
    "A well between 0 and the cutoff."

    depth: PerPair[NotNegative] = setting("Depth of the well.", unit="kT")

    def energy(self, r, w):
        return -self.depth * sin(pi * w) ** 2

    def force(self, r, w):
        return -2.0 * pi * self.depth * sin(pi * w) * cos(pi * w)
```

A scene with `pages: [attraction.py]` (in Python also `dpd.run(..., pages=[Attraction])`) has the
key `attraction: {depth: 2}`, or `{depth: {A A: 2, A B: 0, B B: 2}}`. It acts beside the repulsion.
In the formulas a setting is the number of the pair at hand, r the distance and w = 1 - r; they use
`math`, and functions of the file that are marked with `part` of `dpd.page`. Before anything is
compiled, the force is held to the slope of the energy at 49 distances. Pressure, energy, stress
profiles and the configurational temperature have it. Steps that the repulsion allows may be too
long for it: look at `kT` and at half of `dt`.

## Pair forces from tables

`pair: {A B: force.csv}` gives the pairs of A and B the force of a file, beside their repulsion,
which may be 0. Pairs that are not named feel the repulsion alone. The file has the columns `r`,
`energy` and `force`, named in its first row, with r from near 0 to where the force ends, at most 1:

```
r,energy,force
0.0,5.0,10.0
0.1,4.05,9.0
```

The force must be minus the slope of the energy, and both must end at 0. Between rows there is a
cubic spline. The path counts from the file of the scene; what is in the file is part of the scene,
and a result is made longer with the same file alone.

## Bonds of your own

`fene: {stiffness: 30, length: 1.5}` and `morse_bond: {depth: 100, alpha: 4, length: 0.5}` stand in
the place of `bond`; a setting may be a table by pairs of species. So does a page of your own:

```python
from dpd.page import BondForce, PerPair, Positive, setting


class Quartic(BondForce, key="quartic"):
    "Bonds that hardly pull near rest."

    strength: PerPair[Positive] = setting("Strength.", unit="kT / r_c^4")
    length: float = setting("Rest length.", 0.5, unit="r_c", gt=0)

    def energy(self, r):
        return self.strength * (r - self.length) ** 4

    def force(self, r):
        return -4.0 * self.strength * (r - self.length) ** 3
```

A scene with `pages: [quartic.py]` has `quartic: {strength: 100}`. What is said of pair forces
holds, with the length r alone. Random starts take the length of least energy, or that of a method
`at_rest(self)`; `start.forces` changes settings under the same key. Bonds that would often reach
across half of the box are refused, by the Boltzmann weight of their energy.

## A start of your own

A file with a class that places beads, here chains whose last beads meet in the middle of the box:

```python
import numpy as np
from dpd.page import Start, setting


class Bilayer(Start, key="bilayer"):
    "The first kind of molecule stands in two leaflets, the ends of its tails together."

    spacing: float = setting("Distance of beads along a chain.", 0.5, unit="r_c", gt=0, le=2)

    def positions(self, scene, rng):
        chains, *others = scene.molecules
        x = np.empty((chains.count, len(chains.beads), 3))
        x[:] = rng.random((chains.count, 1, 3)) * scene.box
        up = np.where(np.arange(chains.count) % 2, 1, -1)[:, None]
        height = self.spacing * (np.arange(len(chains.beads))[::-1] + 0.5)
        x[..., 2] = scene.box[2] / 2 + up * height
        rest = sum(kind.count * len(kind.beads) for kind in others)
        return np.concatenate([x.reshape(-1, 3), rng.random((rest, 3)) * scene.box])
```

A scene with `pages: [bilayer.py]` then begins so with `start: {method: bilayer, spacing: 0.4}`, and
relaxes, if it says so, as after any other method. `positions` gives a row for each bead, molecule
after molecule in the order of `molecules`, from 0 to the edges of the box; what is outside of a
face that repeats is put back into the box. Velocities are thermal, unless the class has a method
`velocities` with the same arguments and rows. `rng` follows from the seed of the start. A class
with `work = 10_000`, about the number of steps that take as long, is made by a job of its own for
all runs of a study that share it.

## Values that change while a system runs

`schedule` lists them, each with the step of the run behind which it holds, equilibration included:

```yaml
schedule:
- {step: 2000, set: {thermostat.kT: 1.2, repulsion.A A: 30}}
- {step: 4000, set: {integrator.dt: 0.02}}
```

Keys are those of forces, walls, thermostat and integrator, joined by dots. A new value acts at
once: forces are evaluated anew where the beads are. What is measured goes on; times are those of
the steps that were taken, and what compares samples over time (`diffusion`, `displacement`,
`end_to_end`) is refused if `dt` changes while it samples. From Python the same is done step by
step:

```python
import dpd

sim = dpd.Simulation("fluid.yaml")  # what it observes is measured as in dpd.run
sim.run(2000)
sim.set({"repulsion.A A": 30}, kT=1.2)  # a name is enough where it is there once
sim.run(2000)
print(sim.step, sim.time, sim.kT, sim.positions.shape, sim.velocities.shape)
snapshot = sim.snapshot()  # what an observable of your own sees
run = sim.result()  # a dataset, as that of dpd.run
sim.save("run.nc")  # for dpd.load, dpd.extend, dpd.draw
```

The scene in `run.nc` has the schedule, and `dpd run` comes to the same bits with it.

## Surface tension

Two fluids that do not mix, in slabs (`start: {method: slabs}`), have two interfaces. The observable
`stress_profile` divides the pressure tensor of the box among slices: each pair, bond and angle
along its line (Irving and Kirkwood 1950), and each bead's kinetic part where it is. The normal
pressure is the same in all slices, the tangential one is smaller at the interfaces, and the surface
tension is what is missing. A sample takes as long as 3 to 4 steps, so every tenth step costs a
third more.

```python
import dpd
from paper_figures.groot_warren_1997.surface_tension import slab_tension  # in a clone

found = slab_tension(dpd.run("slabs.yaml"))  # observes thermo, profile and stress_profile
print(found.of_profile, found.of_tensor)  # the tension in two ways, with errors
print(found.bulks)  # normal less tangential pressure in both slabs, which must vanish
print(found.settled)  # False if the composition still drifted
```

Between walls the slices go from behind one wall to behind the other. Walls push beads from outside,
so the normal pressure of the fluid falls to zero there. `wall_pressure_profile` is what the walls
carry: with it the sum is the same everywhere, the force per area on each wall.

## Branched molecules, bonds and angles

An `architecture` is read from left to right:

| text | molecule |
| --- | --- |
| `A 3 B 9` | a chain of 3 A and 9 B |
| `A 3 (B 2) A 3` | a chain of 6 A with a branch: what is in brackets hangs on the bead before it |
| `A 3 (B 2) (C 4 (D)) A 3` | two branches on the same bead, the second with a branch of its own |
| `(A 2 B) 4` | a chain: with a number behind it, what is in brackets is repeated along the chain |
| `(A (B 2)) 10` | a comb: 10 A along the chain, each with a branch of 2 B |

Beads are numbered in the order in which they are written. Rings cannot be written. A molecule has
1 000 000 beads at most. A message on an architecture that cannot be read marks the place.

`bond` is one law for all bonds, or a table with a law for each pair of species that is bonded, in
either order. `angle` acts between all pairs of bonds that share a bead, at branches too. Its table
names triples of species along the bonds, in either order; triples that are not named feel no force.

```yaml
molecules: [{architecture: H (T 4) T 4, count: 300}, {architecture: W, density: 2}]
bond: {H T: {stiffness: 100, length: 0.5}, T T: {stiffness: 100, length: 0.5}}
angle: {H T T: {stiffness: 5}, T T T: {stiffness: 5, angle: 180}}
```

Only linear molecules have an end-to-end distance. `chains` gives `end_to_end_square` of these, NaN
for branched ones, and then also `ends_square`: the mean squared distance over all pairs of ends,
which are beads with a single bond. `start: {method: polymerize}` grows linear molecules only, and
without angles: these act from the first step of the run on.
"""
FILES = """## Variables of run.nc

`python -m dpd run` writes one NetCDF file, and so does each point of a sweep. The file holds the
variables of the observables that the scene names in `observe`. The dimension *sample* counts
samples over time; *block* counts consecutive parts of the run, 50 or fewer, each with its mean, and
alike but for a quarter of their length. The
attributes of the file say what made it: scene, seed, versions, and digests
(checksums) of the sources.

{run}

A run of your own also keeps how it ended: `last_position`, `last_image`, `last_velocity`,
`last_species` (numbers in `last_names`), `last_bonds` and `last_angles`, molecule after molecule as
in the scene, `last_masses` if it names masses, and the attributes `last_box` and `last_step`. A run
of a study keeps that if its scene says `keep_state: true`. The group `state` of the file holds what
`python -m dpd extend run.nc --sample 10000` needs to make the run longer, to the same bits as a run
that was planned that long. The file is about as large as a checkpoint.

## Shear

`shear: {{rate: 0.1}}` lets the fluid flow along x with a speed of 0.1 y, without walls: images of
the box above and below slide along (Lees-Edwards boundary conditions). Velocities are kept about
this flow, in `run.nc`, in trajectories and in files to begin with; so kT is measured about the
flow too, and a run that begins with thermal velocities flows from its first step. The velocity of a
bead in the laboratory is that plus the rate times its y. The viscosity is the mean of
`shear_stress` over the rate, with its error:

```python
import dpd
from dpd.analysis.shear import viscosity

print(viscosity(dpd.load("run.nc")))
```

Shear heats the fluid by viscosity times rate^2 per volume, which the thermostat takes up; look at
`kT`. Displacements are those about the flow. Positions stay in the box of right angles; the lattice
of its images is tilted, and files say by how much: `last_tilt`, `box_tilt`, and the tilt factors of
the box in GSD and LAMMPS data.

## Trajectories and images

`observe: [{{trajectory: {{every: 1000}}}}]` writes `run.gsd`. `species: [H, T]` leaves a solvent
out, `velocities: false` the velocities, and `equilibration: true` counts from the first step.
Positions stay in the box, and `image` counts the boxes that a bead is further, in GSD as in LAMMPS
data and `last_image`: position + image times the vectors of the box goes on through all faces, and
has each molecule in one piece. Each frame holds `log/time` (in tau, since the run began), `log/dt`
and `log/kT` (of the thermostat), and as `particles/body` the numbers of molecules, which MDAnalysis
takes for those of its residues. It reads no times from GSD files: tell it those of the file.

```python
import gsd.hoomd
import MDAnalysis

with gsd.hoomd.open("run.gsd") as file:
    first, second = (float(file[number].log["time"][0]) for number in (0, 1))
universe = MDAnalysis.Universe("run.gsd", dt=second - first, time_offset=first)
```

## Density fields and phases

`density_field` counts beads in the cells of a grid, in frames over time. One look has few beads in
a cell, so a frame is the average of some looks. To see how a mixture orders, let the scene sample
from the beginning, as that of `python -m dpd new triblock` does with `equilibrate: 0`. Then

```
python -m dpd draw run.nc --slice z=5 --frame 0 3 -1      # three times side by side
python -m dpd draw run.nc --surface A=0.4 B=1 --frame -1  # around what is denser than that
python -m dpd convert run.nc field.vti --frame -1         # for ParaView
```

Surfaces and files for ParaView need `pip install 'dpd-papers[draw]'`. For a picture, the field is
averaged with a Gaussian of width 0.5 (`--smooth`). A surface is closed where the box ends. The
values of a file for ParaView belong to cells: use its filter *Cell Data to Point Data* before
*Contour*.

The phase of a block copolymer is named by the peaks of its structure factor, 1 : 2 : 3 for lamellae
and 1 : sqrt(3) : 2 for cylinders:

```python
import dpd
from paper_figures.cerius2_1998.phases import phase_of, strengths_of  # in a clone

run = dpd.load("run.nc")  # of a scene that observes structure_factor
phase = phase_of(strengths_of(run, "A"))
print(phase.name, phase.reason, phase.spacing)
```

## First configurations

`start` of a scene says where beads begin. `method: file` reads that from a file: GSD, LAMMPS data,
a `run.nc`, `start.nc` or checkpoint. The file must have the box and the molecules of the scene, in
any order; the content of the file is part of the scene, so that an edited file is another scene.
`python -m dpd run SCENE.yaml --start FILE -o run.nc` is short for that, without relaxation: the
velocities are those of the file. With another seed, temperature, repulsion or time step it is how
one run goes on from another.

A first configuration that takes long to make can be kept: if `--start start.nc` is not there yet,
it is made as the scene says and kept, with the record of how chains grew.

## Variables of a sweep file

`results/STUDY/PAPER/sweeps/SWEEP.nc` holds all runs of a sweep. Its dimensions are the axes of the
sweep and `replica`. Variables without the dimension *sample* are those of the runs. A series over
*sample* becomes its mean and five more variables, shown here for kT. If `series` of the sweep names
it, the whole series is kept as well, with `_series` behind its name. Coordinates that differ among
the runs, as the slices of boxes at constant pressure, are variables, with `_of_run` behind their
names.

{sweep}

For a plot of your own, in Python:

```python
import xarray as xr

sweep = xr.open_dataset("results/quick/groot_warren_1997/sweeps/equation_of_state_15.nc")
(sweep.excess_conservative / (15 * sweep.density**2)).mean("replica").plot()
```

## Columns of verdicts.csv

`results/STUDY/verdicts.csv` has one row for each published number or claim, and for each check of
our own.

{verdicts}
"""
THEORY = """The `theory` of a sweep that simulates nothing: a mapping with one calculation and its
arguments, any of which an axis may set, as `set: monomer_fluid.density`. All points come together
in `sweeps/NAME.nc`, as those of runs do; a point is calculated anew only if its arguments or the
sources change."""
HEAD = "| key | allowed | unit | default | meaning |\n| --- | --- | --- | --- | --- |"


def config_readme() -> str:
    """The page as Markdown."""
    theory = [row for key, each in ARGUMENTS.items() for row in section_rows(each, key, "")]
    parts = [INTRODUCTION]
    for name, text, rows in (
        ("Config", text_of(Config), rows_of(Config, "")),
        ("Paper", text_of(PaperFile), rows_of(PaperFile, "")),
        ("Theory", THEORY, theory),
        ("Scene", text_of(Basics), scene_rows()),
    ):
        parts += [f"## {name}\n\n{text}\n", _table(rows)]
    files = FILES.format(run=run_table(), sweep=sweep_table(), verdicts=verdict_table())
    return "\n".join([*parts, files])


def _table(rows):
    """Markdown, of rows of cells."""
    cells = ((f"`{row.key}`", *row[1:]) for row in rows)
    lines = (" | ".join(cell.replace("|", "\\|") for cell in row) for row in cells)
    return HEAD + "".join(f"\n| {line} |" for line in lines) + "\n"
