"""The stages that make files: start.nc from a scene, run.nc from a scene and its start."""

import json
import resource
import time
from pathlib import Path

import numpy as np

from dpd import files
from dpd.analysis.statistics import mean_and_error
from dpd.digest import stage_digest
from dpd.engine.checkpoint import Checkpoint
from dpd.engine.loop import run
from dpd.engine.simulation import Simulation, State, Unstable
from dpd.errors import LostTrack, Stopped, UserError
from dpd.observe import observables
from dpd.start.description import start_description, start_digest
from dpd.start.make import make_start_and_record, system_of
from dpd.start.polymerize import RECORD

# Share by which kT may be off without a word, and standard errors that it may; samples needed.
FAR_OFF, SURE, FEWEST = 0.05, 4.0, 20
ANOTHER = (
    "let snakemake make it again; for a run of your own name a file for --start that is not there "
    "yet: the first configuration is made and kept in it"
)


def write_start(scene, path, progress=None):
    """Make the first configuration of a scene and write it.

    Parameters
    ----------
    scene : Scene
    path : path
    progress : callable or None
    """
    begun = time.perf_counter()
    state, record = make_start_and_record(scene, progress)
    variables = {
        "position": (("axis", "bead"), state.position, "r_c", "positions in the box"),
        "velocity": (("axis", "bead"), state.velocity, "r_c / tau", "velocities"),
    }
    if state.species is not None:
        variables["species"] = (("bead",), state.species, "1", "number of the species")
    for name, (units, long_name) in RECORD.items():
        if name in record:
            variables[name] = (("round",), record[name], units, long_name)
    if "relax_crossings" in record:
        crossings = record["relax_crossings"]
        text = "pairs of crossing bonds while the melt relaxed"
        variables["relax_crossings"] = (("look",), crossings, "1", text)
    attributes = {
        "start": json.dumps(start_description(scene)),
        "start_digest": start_digest(scene),
        "start_sources": stage_digest("start"),
        "seconds": time.perf_counter() - begun,
    }
    files.write(path, variables, attributes)


def read_start(scene, path):
    """Read a first configuration that belongs to a scene.

    Returns
    -------
    State

    Raises
    ------
    UserError
        If the file belongs to another system or other sources.
    """
    variables, attributes = files.read(path)
    if "start_digest" not in attributes:
        what = "the result of a run" if "scene_digest" in attributes else "some other NetCDF file"
        raise UserError(
            f"{path}: this is {what}, not a first configuration. --start wants a file that an "
            "earlier --start or `python -m dpd start` wrote, or a name that is not there yet: the "
            "first configuration is then made and kept in it"
        )
    if attributes["start_digest"] != start_digest(scene):
        raise UserError(
            f"{path}: the first configuration of another scene than {scene.where} (start_digest "
            f"{attributes['start_digest']}, now {start_digest(scene)}); {ANOTHER}"
        )
    files.check_digest(path, attributes, "start_sources", stage_digest("start"), ANOTHER)
    shape = (scene.dimension, scene.beads)
    wanted = {"position": (shape, "f"), "velocity": (shape, "f")}
    if len(scene.species) > 1:
        wanted["species"] = (shape[1:], "u")
    for name, (expected, kind) in wanted.items():
        found = variables.get(name)
        if found is None or found.shape != expected or found.dtype.kind != kind:
            raise UserError(f"{path}: has no {name} of {expected} beads that it needs; {ANOTHER}")
    species = variables["species"] if "species" in wanted else None
    if species is not None and species.max() >= len(scene.species):
        raise UserError(f"{path}: has beads of a species that the scene has not; {ANOTHER}")
    identity = np.arange(scene.beads, dtype=np.uint32)
    return State(variables["position"], variables["velocity"], None, identity, species, 0)


def simulate(
    scene, path, state, checkpoint=None, progress=None, every_seconds=60.0, stopping=None, say=None,
    threads=1, begun=None,
):  # fmt: skip
    """Run a scene and write what it observed.

    Parameters
    ----------
    scene : Scene
    path : path
        The NetCDF file; written at the end, whole.
    state : State
        From `read_start` or `dpd.start.make.make_start`.
    checkpoint : path or None
        Where the state is kept while it runs; an interrupted run of the same scene and
        sources goes on from there, to the same bits.
    progress : callable or None
        Called with the number of steps done.
    every_seconds : float
        Wall clock between checkpoints.
    stopping, say : callable or None
        See `dpd.engine.loop.run`.
    threads : int
        See `dpd.engine.simulation.Simulation`.
    begun : float or None
        When the work on this run began, as `time.perf_counter` has it: with its start, where the
        run made that itself. Otherwise now.

    Returns
    -------
    dict
        Summary: seconds, bead-steps per second, and means of what was measured.

    Raises
    ------
    UserError
        If the run blows up or is stopped; the last checkpoint stays. Before it begins, if
        there is no room for checkpoint and result.
    """
    begun = time.perf_counter() if begun is None else begun
    if scene.is_auto:
        raise UserError(
            f"{scene.where}: integrator.scheme: 'auto' has not been tried on the scene yet; call "
            "dpd.pipeline.probing.settle(scene, state) first, or name scheme and dt"
        )
    system = system_of(scene)
    simulation = Simulation(system, state, threads)
    observers = observables(scene, system)
    sizes = [a.nbytes for o in observers for a in o.arrays.values()]
    state_size = sum(a.nbytes for a in vars(simulation.state).values() if hasattr(a, "nbytes"))
    # The checkpoint, the draft of the next one, and the result.
    for place in (path, checkpoint) if checkpoint else (path,):
        files.check_room(place, 3 * (sum(sizes) + state_size))
    keeper = None
    if checkpoint:
        key = {"scene": scene.digest, "sources": stage_digest("simulate")}
        keeper = Checkpoint(checkpoint, key, scene.chosen)
    running, lost = time.perf_counter(), -1
    try:
        done = run(
            simulation, scene.steps, observers, keeper, progress, every_seconds, stopping, say
        )
    except UserError as problem:
        recorded = isinstance(problem, Unstable | LostTrack) and scene.data["unstable"] == "record"
        done, lost = (problem.step, problem.step) if recorded else (0, -1)
        if not recorded:
            raise _with_place(problem, scene, keeper) from None
    now = time.perf_counter()
    variables = {}
    for observer in observers:
        variables |= observer.variables()
    warning = temperature_warning(scene, variables)
    attributes = {
        "scene": json.dumps(scene.data),
        "scene_digest": scene.digest,
        "sources": stage_digest("simulate"),
        "beads": scene.beads,
        "number_density": scene.density,
        "seed": scene.data["seed"],
        "steps": sum(scene.steps),
        "lost_step": lost,
        "seconds": now - begun,
        "bead_steps_per_second": scene.beads * done / max(now - running, 1e-9),
        "peak_memory_MiB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
    } | versions()
    if scene.chosen:
        attributes["chosen"] = scene.chosen["said"]
    if warning:
        attributes["warning"] = warning
        if say:
            say(warning)
    try:
        files.write(path, variables, attributes)
    except UserError as problem:
        if keeper and lost < 0:
            keeper.save(simulation, observers)
        raise _with_place(problem, scene, keeper) from None
    if keeper:
        keeper.discard()
    return summary(scene, variables, attributes)


def _with_place(problem, scene, keeper):
    """A problem of a run, with the scene's file and where the last good state is."""
    kept = keeper is not None and keeper.is_ours and keeper.path.exists()
    last = f"; its last good state is in {keeper.path}" if kept else ""
    kind = Stopped if isinstance(problem, Stopped) else UserError
    return kind(f"{scene.where}: {str(problem).rstrip('.')}{last}")


def summary(scene, variables, attributes):
    """Means of the measured series, for a person at a terminal.

    Both pressures have the kinetic part that was measured, as ``pressure`` and
    ``pressure_tensor_all`` in the file.
    """
    found = {
        "beads": attributes["beads"],
        "steps": attributes["steps"],
        "seconds": attributes["seconds"],
        "bead-steps per second": attributes["bead_steps_per_second"],
    }
    if "kT" in variables:
        found["kT"] = float(np.mean(variables["kT"][1]))
    if "pressure" in variables:
        found["pressure (conservative virial)"] = float(np.mean(variables["pressure"][1]))
        diagonal = np.trace(variables["pressure_tensor_all"][1], axis1=1, axis2=2)
        found["pressure (virial of all forces)"] = float(np.mean(diagonal)) / scene.dimension
    if "bond_mean" in variables:
        found["mean bond length"] = float(np.mean(variables["bond_mean"][1]))
    return found


def summary_of_file(scene, path):
    """The same of a result on the disk.

    Raises
    ------
    UserError
        If it is not there, or of another scene or other sources.
    """
    variables, attributes = files.read(path)
    files.check_digest(path, attributes, "sources", stage_digest("simulate"), ANOTHER)
    files.check_digest(path, attributes, "scene_digest", scene.digest, ANOTHER)
    return summary(scene, {name: (None, array) for name, array in variables.items()}, attributes)


def temperature_warning(scene, variables):
    """A sentence if a run was not at its temperature; nothing if it was.

    It looks at the second half of the samples, so that a start that is hotter or colder may
    settle, and asks for more than `FAR_OFF` and for more than `SURE` standard errors.
    """
    kT = variables["kT"][1] if "kT" in variables else np.empty(0)
    kT = kT[len(kT) // 2 :]
    if len(kT) < FEWEST or not np.isfinite(kT).all():
        return ""
    asked, (mean, error, _) = scene.data["thermostat"]["kT"], mean_and_error(kT)
    if abs(mean - asked) <= max(FAR_OFF * asked, SURE * error):
        return ""
    cause = "dt is too large for this scene, or the run too short to reach its temperature"
    if scene.data["thermostat"]["gamma"] == 0:
        cause = "without friction (gamma 0) nothing holds it"
    known = f"+- {error:.2g}" if np.isfinite(error) else "(too short a run to know its error)"
    return (
        f"kT is {mean:.4g} {known} instead of {asked:g} in the second half of the run, and "
        f"all that was measured belongs to that: {cause}"
    )


def versions():
    """Of what computes, for a file."""
    import numba

    return {"numpy": np.__version__, "numba": numba.__version__}


def checkpoint_path(path):
    """Where the checkpoint of a result lies: beside it, under a name that no rule declares."""
    path = Path(path)
    return path.with_name(path.stem + ".checkpoint")
