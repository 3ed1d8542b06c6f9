"""What features of a scene, schemes, observables and whole runs cost, each beside what lacks it."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.systems import CHANNEL, FLAT_MELT, FLUID, MELT, SLABS, STUDIES, workload
from benchmarks.timing import TURNS, in_turns, labelled, simulation_of, starts_of
from dpd.engine.loop import run
from dpd.errors import LostRun, UserError
from dpd.observe.common.measured import observables
from dpd.page import Observable, names
from dpd.physics.integrator import SCHEMES
from dpd.pipeline.paper import read_config, read_paper
from dpd.runs.run import simulate
from dpd.scene.scene import Scene
from dpd.start.common.make import make_start

BARE = "bare fluid"
# What a scene names for each feature.
NAMED = {
    "bonds (dimers)": {
        "molecules": [{"architecture": "A 2", "density": 3}],
        "bond": {"stiffness": 2, "length": 0},
    },
    "two species": {
        "molecules": [{"architecture": species, "density": 1.5} for species in "AB"],
        "repulsion": {"A A": 25, "B B": 25, "A B": 25},
    },
    "rigid core": {"core": {"radius": 0.1, "force": 25}},
    "Gaussian noise": {"thermostat": {"noise": "gaussian"}},
    "Langevin bath": {"thermostat": {"kind": "langevin"}},
    "friction twice": {"integrator": {"scheme": "dpd-vv", "dt": 0.04}},
}
VIRIAL = "virial every step"
STEPS = 60  # in a turn
PREDICTIONS = (0.5, 0.65)  # lambda of gw-vv, Groot and Warren 1997
DT = 0.01  # tau; all schemes stand it, and pairs are found as at the workloads' own
SHARE = 0.25  # of a workload's steps, in one turn of a scheme
# Systems on which observables are measured.
OBSERVED = {
    "fluid": FLUID | {"box": 10},
    "slabs": SLABS,
    "channel": CHANNEL,
    "melt": MELT,
    "2D melt": FLAT_MELT | {"box": 31.6228},
}
WATCHED, LONGEST = 200, 2000  # steps of a turn with an observable: at least, at most
OFTEN = 8  # times as often as by default each is looked at, to see what a look costs


def features(scene=None, steps=STEPS, turns=TURNS, say=print):
    """Cost of features of a fluid, W1 if not given, each in turns with the bare fluid.

    A dataset with ``cost`` and ``bare_cost`` (feature, turn) in s per bead and step.
    """
    bare = scene or workload("W1")
    scenes = {name: Scene(bare.data | changes, bare.where) for name, changes in NAMED.items()}
    starts = starts_of({BARE: bare} | scenes, say)
    still = simulation_of(bare, starts[BARE])
    pairs = {
        name: (still.advance, simulation_of(scenes[name], starts[name]).advance) for name in NAMED
    }
    pairs[VIRIAL] = _one_by_one(still.advance), _one_by_one(still.advance_measured)
    cost = {}
    for name, advances in pairs.items():
        say(f"cost of {name}")
        for advance in advances:
            advance(steps)
        cost[name] = in_turns(advances, steps, turns) / (bare.beads * steps)
    reference, costs = np.array(list(cost.values())).swapaxes(0, 1)
    along, per = ("feature", "turn"), "s"
    variables = {
        "feature": (("feature",), list(cost), "1", "feature"),
        "cost": (along, costs, per, "seconds per bead and step with the feature"),
        "bare_cost": (along, reference, per, "seconds per bead and step without, in turn"),
    }
    description = (
        f"{bare.beads} beads, rho {bare.density:.3g}, a 25, one thread, {turns} turns of feature "
        "and bare fluid."
    )
    return labelled(variables, description)


def _one_by_one(advance):
    """Steps in calls of their own."""
    return lambda steps: [advance(1) for _ in range(steps)]


def labelled_schemes():
    """Name to what a scene says of it, for every scheme; gw-vv once for each lambda."""
    found = {}
    for scheme in SCHEMES:
        if scheme == "gw-vv":
            found |= {f"gw-vv-{p:g}": {"scheme": scheme, "lambda": p} for p in PREDICTIONS}
        else:
            found[scheme] = {"scheme": scheme}
    return found


def schemes(scenes=None, turns=TURNS, dt=DT, say=print):
    """Seconds per bead and step of each scheme on some workloads, W1 and W2 if not given.

    ``cost`` (workload, scheme, turn), NaN where a scheme blows up at the time step.
    """
    scenes = scenes or {name: workload(name) for name in ("W1", "W2")}
    starts, named = starts_of(scenes, say), labelled_schemes()
    wild = []
    cost = np.full((len(scenes), len(named), turns), np.nan)
    for w, (name, scene) in enumerate(scenes.items()):
        steps = max(1, round(SHARE * scene.steps.sample))
        running = {}
        for s, (label, integrator) in enumerate(named.items()):
            say(f"{name}: {label}")
            changed = scene.data | {"integrator": {"dt": dt} | integrator}
            simulation = simulation_of(Scene(changed, scene.where), starts[name])
            try:
                simulation.advance((turns + 1) * steps)  # stands what is to come, and compiles
            except LostRun as problem:
                say(f"{name}: {label}: {problem}")
                wild.append(f"{label} on {name}")
                continue
            running[s] = simulation.advance
        seconds = in_turns(list(running.values()), steps, turns)
        cost[w, list(running)] = seconds / (scene.beads * steps)
    variables = {
        "workload": (("workload",), list(scenes), "1", "workload"),
        "scheme": (("scheme",), list(named), "1", "scheme, and lambda of gw-vv"),
        "beads": (("workload",), [s.beads for s in scenes.values()], "1", "number of beads"),
        "cost": (("workload", "scheme", "turn"), cost, "s", "seconds per bead and step"),
    }
    description = f"every scheme from the same state, one thread, {turns} turns."
    if wild:
        description += f" Left out, as they blow up at that time step: {', '.join(wild)}."
    return labelled(variables, description)


def whole_run(scene, start, turns=TURNS):
    """(2, turns) bead-steps per second of the bare loop and of the run that is made of it.

    A run is what follows the first configuration: the loop, its observables, and the file. Both are
    done once before, so that neither compiles.
    """
    steps, bare = scene.steps.sample, simulation_of(scene, start)
    with TemporaryDirectory() as folder:

        def whole(steps):
            return simulate(scene, Path(folder) / "run.nc", replace(start))

        advances = [bare.advance, whole]
        in_turns(advances, steps, 1)
        return scene.beads * steps / in_turns(advances, steps, turns)


def whole_runs(say=print):
    """`whole_run` by name, of what studies are made of."""
    scenes = {name: workload(name) for name in STUDIES}
    starts = starts_of(scenes, say)
    return {name: whole_run(scene, starts[name]) for name, scene in scenes.items()}


def observing(systems=OBSERVED, turns=TURNS, say=print):
    """What each observable adds to a run at its default interval, on one thread.

    By name of the observable, then of the system: steps between samples, and % of the run without
    it; of those that a system allows.
    """
    scenes = {name: Scene(data, name) for name, data in systems.items()}
    starts, found = starts_of(scenes, say), {}
    for system, scene in scenes.items():
        say(f"{system}: measuring what observables cost")
        for key in names(Observable):
            simulation = simulation_of(scene, starts[system])
            try:
                found.setdefault(key, {})[system] = _share(simulation, scene, key, turns)
            except UserError:  # nothing to measure there
                continue
    return found


def _share(simulation, scene, key, turns):
    """Steps between samples of an observable, and what they add in % of the processor's time."""
    watched = Scene(scene.data | {"observe": [key], "steps": {"sample": LONGEST}}, scene.where)
    every = watched.observe[key].every
    often = max(1, every // OFTEN)  # or what else the machine does would hide it
    share = _added(simulation, watched, [{key: {"every": often}}], often, turns)
    return every, share * often / every


def _added(simulation, scene, observe, every, turns):
    """What some observables add, in % of the processor's time; ``every``: the longest interval."""
    steps, added = -(-WATCHED // every) * every, []
    asked = {"observe": observe, "steps": {"sample": (turns + 1) * steps}, "duration": {}}
    watched = Scene(scene.data | asked, scene.where)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "run.nc"
        observers = observables(watched, simulation.system, path, simulation.state)
        for _ in range(turns + 1):  # the first one compiles
            begun = time.process_time()
            run(simulation, (0, simulation.state.step + steps), observers)
            ended = time.process_time()
            simulation.advance(steps)
            added.append((ended - begun) / (time.process_time() - ended) - 1)
    return 100 * float(np.median(added[1:]))


def observing_in(study, turns=TURNS, say=print):
    """What all that a sweep observes adds to its largest run, in %, for each sweep of a study.

    A sentence for each sweep, the share of the whole study in its time last. What is seen once, as
    the last configuration, is left out.
    """
    total = observed = 0.0
    for paper in (read_paper(name, study) for name in read_config()["papers"]):
        for name, sweep in paper.sweeps.items():
            if not sweep.points:
                continue
            scene = max((point.scene for point in sweep.points), key=lambda scene: scene.work)
            scene = Scene(scene.data | {"start": scene.start.stand_in()}, scene.where)
            seen = {key: page for key, page in scene.observe.items() if page.every <= LONGEST}
            simulation = simulation_of(scene, make_start(scene))
            every = max(page.every for page in seen.values())
            observe = [each for each in scene.data["observe"] if _key(each) in seen]
            added = _added(simulation, scene, observe, every, turns)
            begun = time.process_time()
            simulation.advance(WATCHED)
            step = (time.process_time() - begun) / WATCHED / scene.beads
            steps = [point.scene.steps for point in sweep.points]
            size = step * np.mean([point.scene.beads for point in sweep.points])
            total += size * sum(map(sum, steps))
            observed += size * sum(each.sample for each in steps) * added / 100
            looks = ", ".join(f"{key} {page.every}" for key, page in seen.items())
            say(f"{paper.name} {name}: {added:.0f} % ({looks})")
    say(f"{study}: {100 * observed / total:.0f} % of the steps of all runs")


def _key(observed):
    return observed if isinstance(observed, str) else next(iter(observed))


def observing_as_text(found, systems=tuple(OBSERVED)):
    """A column for each system, a line for each observable."""
    lines = ["cost of each observable, % of a run (steps between its samples)"]
    lines.append(" " * 20 + "".join(f"{system:>16s}" for system in systems))
    for key, shares in found.items():
        words = {system: f"{share:.1f} ({every})" for system, (every, share) in shares.items()}
        lines.append(f"{key:20s}" + "".join(f"{words.get(each, '-'):>16s}" for each in systems))
    return "\n".join(lines)
