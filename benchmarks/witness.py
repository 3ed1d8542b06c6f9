"""LAMMPS as a witness: one point of each sweep of a study on both engines, and what both find.

Only the schemes of Liu and of Nikunen are exchanged, on both engines, for the one that LAMMPS has.
"""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context

import numpy as np
import pandas as pd

import dpd
from dpd.analysis.diffusion import diffusion_constant, displacements
from dpd.analysis.statistics import block_mean_and_error, mean_and_error
from dpd.errors import UserError
from dpd.pipeline.paper import read_config, read_paper
from dpd.scene.scene import Scene

WORK = 3e7  # bead-steps of a run at most: LAMMPS takes half a minute for them
SAMPLES = 2000  # of displacements, which are followed for a tenth of the run
LAMMPS = {"engine": {"name": "lammps"}}
SCHEME = {"scheme": "gw-vv", "lambda": 0.5}
COLUMNS = [
    "paper",
    "sweep",
    "point",
    "quantity",
    "own",
    "own_error",
    "lammps",
    "lammps_error",
    "z",
    "z_own",
]


def witness(study, cores, say=print):
    """Rows for each sweep that LAMMPS can have, in the order of the papers.

    A row is a quantity, its mean and standard error on both engines, and z, their difference over
    its standard error; of g(r) the root mean square of that over distances. ``z_own`` is the same
    of our engine with another seed: errors are widened where few samples know them, so that its
    rms is somewhat below 1 as well.
    """
    scenes = dict(scenes_of(study))
    with ProcessPoolExecutor(cores, mp_context=get_context("spawn")) as pool:
        waiting = {pool.submit(both, data): place for place, data in scenes.items()}
        found = {}
        for number, done in enumerate(as_completed(waiting), 1):
            place, problem = waiting[done], done.exception()
            found[place] = [] if problem else done.result()
            say(f"{number} of {len(waiting)}: {' '.join(place)}{f': {problem}' if problem else ''}")
    rows = [(*place, *row) for place in scenes for row in found[place]]
    return pd.DataFrame(rows, columns=COLUMNS)


def scenes_of(study):
    """Paper, sweep and point, and a scene as plain data: of each sweep the one of least work."""
    for name in read_config()["papers"]:
        for sweep in read_paper(name, study).sweeps.values():
            points = sorted(sweep.points, key=lambda point: point.scene.work)
            for point in points:
                data = shortened(point.scene)
                try:
                    Scene(data | LAMMPS, point.scene.where)
                except UserError:
                    continue
                yield (name, sweep.name, point.name), data
                break


def shortened(scene):
    """The same for both engines, watched alike, with at most `WORK` bead-steps."""
    share = min(1.0, WORK / scene.work)
    steps = {name: round(share * number) for name, number in scene.steps._asdict().items()}
    every = max(1, steps["sample"] // SAMPLES)
    watch = ["thermo", {"rdf": {"range": 2, "bin": 0.05}}, {"displacement": {"every": every}}]
    return scene.data | {
        "steps": steps, "duration": {}, "unstable": "fail",
        "observe": [*watch, *(["bonds", "chains"] if scene.has_bonds else [])],
        "integrator": scene.data["integrator"] | SCHEME,
    }  # fmt: skip


def both(data):
    """Rows of one scene."""
    other_noise = {"seed": data["seed"] + 1}
    runs = [dpd.run(data | changes, progress=False) for changes in ({}, LAMMPS, other_noise)]
    own, there, again = (means_of(run, data) for run in runs)
    rows = [
        (name, *own[name], *there[name], z(own[name], there[name]), z(own[name], again[name]))
        for name in own
    ]
    over = [over_distances(runs[0].rdf, run.rdf) for run in runs[1:]]
    return [*rows, ("g(r)", *(np.nan,) * 4, *over)]


def z(one, two):
    """Difference of two means, each with its standard error, over that of both."""
    return (one[0] - two[0]) / np.hypot(one[1], two[1])


def means_of(run, data):
    """Means and standard errors by name."""
    found = {name: mean_and_error(run[name].values)[:2] for name in ("kT", "pressure")}
    if "bond_mean" in run:
        found["mean bond"] = block_mean_and_error(run.bond_mean.values)
        sizes = run.gyration_square.values[:, np.argmax(run.gyration_square.values[0])]
        found["R_g^2"] = block_mean_and_error(sizes)
    runs = run.assign(scene=((), run.attrs["scene"])).expand_dims("replica")
    moved = displacements(runs, "centre")
    found["D"] = diffusion_constant(moved, data["dimension"], moved.time[-1] / 4)
    return {name: tuple(map(float, each)) for name, each in found.items()}


def over_distances(one, two):
    """Root mean square of z over the bins of two g(r) in which both have pairs."""
    (a, e), (b, f) = (block_mean_and_error(each.values) for each in (one, two))
    known = (e > 0) & (f > 0)
    return float(np.sqrt(np.mean((a - b)[known] ** 2 / (e**2 + f**2)[known])))


def summary(rows):
    """By quantity, as text: runs, rms of z, that of two seeds of our engine, and the largest z."""
    groups = [
        *rows.groupby("quantity", sort=False),
        ("all but g(r)", rows[rows.quantity != "g(r)"]),
    ]
    lines = ["quantity\truns\trms z\ttwo seeds of ours\tlargest z"]
    for name, each in groups:
        each = each.dropna(subset=["z", "z_own"])
        rms = np.sqrt((each[["z", "z_own"]] ** 2).mean())
        chance = "" if name == "g(r)" else f" ± {rms.z_own / np.sqrt(2 * len(each)):.2f}"
        largest = each.z.iloc[each.z.abs().argmax()]
        lines.append(
            f"{name}\t{len(each)}\t{rms.z:.2f}{chance}\t{rms.z_own:.2f}{chance}\t{largest:+.1f}"
        )
    return "\n".join([*lines, ""])
