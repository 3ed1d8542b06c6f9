"""What each feature of a scene costs, and that one which is not named costs nothing."""

import numpy as np

from dpd.benchmark.stripped import Engine
from dpd.benchmark.timing import TURNS, in_turns, labelled, simulation_of, starts_of
from dpd.benchmark.workloads import workload
from dpd.engine.loop import run
from dpd.observe import observables
from dpd.scene import Scene
from dpd.start import system_of

BARE = "bare fluid"
DIMERS = {
    "molecules": [{"architecture": "A 2", "density": 3}],
    "bond": {"stiffness": 2, "length": 0},
}
TWO = {
    "molecules": [{"architecture": "A", "density": 1.5}, {"architecture": "B", "density": 1.5}],
    "repulsion": {"A A": 25, "B B": 25, "A B": 25},
}
# What a scene names for each feature.
NAMED = {
    "bonds (dimers)": DIMERS,
    "two species": TWO,
    "rigid core": {"core": {"radius": 0.1, "force": 25}},
    "Gaussian noise": {"thermostat": {"noise": "gaussian"}},
    "Langevin bath": {"thermostat": {"kind": "langevin"}},
    "friction twice": {"integrator": {"scheme": "dpd-vv", "dt": 0.04}},
}
EVERY = 10  # steps between samples of an observable
WATCHED = {
    f"g(r) every {EVERY} steps": {"rdf": {"every": EVERY}},
    f"displacement every {EVERY} steps": {"displacement": {"every": EVERY}},
}
VIRIAL = "virial every step"
STEPS = 60  # in a turn
STRIPPED_TURNS = 25


def features(
    scene=None, steps=STEPS, turns=TURNS, stripped_turns=STRIPPED_TURNS, watched=None, say=print
):  # fmt: skip
    """Cost of features, each in turns with the bare fluid; then the engine stripped of all.

    Parameters
    ----------
    scene : Scene or None
        The bare fluid, W1 if not given.
    steps : int
        In a turn, a multiple of `EVERY`.
    turns, stripped_turns : int
    watched : dict or None
        Observables, `WATCHED` if not given.
    say : callable

    Returns
    -------
    xarray.Dataset
        ``cost`` and ``bare_cost`` (feature, turn) in s per bead and step.
    """
    bare = scene or workload("W1")
    watched = WATCHED if watched is None else watched
    scenes = {BARE: bare} | {
        name: Scene(bare.data | changes, bare.where) for name, changes in NAMED.items()
    }
    starts = starts_of(scenes, say)
    still = simulation_of(bare, starts[BARE])
    pairs = {
        name: (still.advance, simulation_of(scenes[name], starts[name]).advance) for name in NAMED
    }
    pairs[VIRIAL] = one_by_one(still, False), one_by_one(still, True)
    for name, observed in watched.items():
        seen = Scene(bare.data | {"observe": [observed]} | _length(turns, steps), bare.where)
        pairs[name] = still.advance, watching(simulation_of(bare, starts[BARE]), seen)
    cost = {}
    for name, advances in pairs.items():
        say(f"cost of {name}")
        for advance in advances:
            advance(steps)
        cost[name] = in_turns(advances, steps, turns) / (bare.beads * steps)
    reference, costs = np.array(list(cost.values())).transpose(1, 0, 2)
    along, per = ("feature", "turn"), "s"
    variables = {
        "feature": (("feature",), list(cost), "1", "feature"),
        "cost": (along, costs, per, "seconds per bead and step with the feature"),
        "bare_cost": (along, reference, per, "seconds per bead and step without, in turn"),
    }
    variables |= beside_stripped(bare, starts[BARE], steps, stripped_turns, say)
    return labelled(variables, _description(bare, turns, stripped_turns))


def _description(bare, turns, stripped_turns):
    return (
        f"{bare.beads} beads, rho {bare.density:.3g}, a 25, one thread, {turns} turns of feature "
        f"and bare fluid; the stripped engine {stripped_turns} turns, in a process of its own."
    )


def _length(turns, steps):
    """What an observable is told of the length of the run."""
    return {"steps": {"sample": (turns + 1) * steps}}


def one_by_one(simulation, measure):
    """Steps in calls of their own, measuring in each or in none."""

    def advance(steps):
        for _ in range(steps):
            simulation.advance(1, measure=measure)

    return advance


def watching(simulation, scene):
    """Steps of the run loop with the observables of a scene."""
    observers = observables(scene, system_of(scene))

    def advance(steps):
        run(simulation, (0, simulation.state.step + steps), observers)

    return advance


def beside_stripped(scene, start, steps, turns, say):
    """Times of the whole engine and of one stripped of every feature, in turns.

    Returns
    -------
    dict
        Variables: ``engine_seconds`` (engine, turn), ``code_size`` (engine), and ``same_bits``.
    """
    say("compiling the engine, whole and without its features")
    engines = [Engine(scene, start, stripped) for stripped in (False, True)]
    try:
        for engine in engines:
            engine.advance(steps)
        say("whole and stripped engine in turns")
        seconds = [[engine.advance(steps) for engine in engines] for _ in range(turns)]
        states = [engine.state() for engine in engines]
        sizes = [engine.code_size() for engine in engines]
    finally:
        for engine in engines:
            engine.close()
    same = all(np.array_equal(a, b) for a, b in zip(*states))
    text = "wall clock of a turn"
    return {
        "engine": (("engine",), ["whole", "stripped"], "1", "engine"),
        "engine_seconds": (("engine", "stripped_turn"), np.array(seconds).T, "s", text),
        "code_size": (("engine",), sizes, "B", "machine code of the loop over steps"),
        "same_bits": ((), int(same), "1", "whether both end in the same state, to the last bit"),
    }
