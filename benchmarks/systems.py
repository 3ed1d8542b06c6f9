"""The systems that speed is measured on: four beside LAMMPS, and those that studies are made of."""

from typing import Any, NamedTuple

from dpd.scene.scene import Scene

FLUID = {
    "dimension": 3,
    "box": 20,
    "molecules": [{"architecture": "A", "density": 3}],
    "repulsion": {"A A": 25},
    "integrator": {"scheme": "gw-vv", "dt": 0.04},
    "start": {"relax": {"steps": 200, "dt": 0.02}},
    "steps": {"sample": 200},
}
MELT = {
    "dimension": 3,
    "box": 20.1587,
    "molecules": [{"architecture": "A 64", "count": 128}],
    "repulsion": {"A A": 100},
    "bond": {"stiffness": 200, "length": 0.95},
    "integrator": {"scheme": "gw-vv", "dt": 0.02},
    "start": {"relax": {"steps": 10000, "dt": 0.005}},
    "steps": {"sample": 500},
}
# The chains begin as random flights: they cross, but move and cost as in a melt. The heat and the
# flows of their push-off last for tens of tau in two dimensions.
FLAT_MELT = {
    "dimension": 2,
    "box": 100,
    "molecules": [{"architecture": "A 100", "density": 2}],
    "repulsion": {"A A": 25},
    "core": {"radius": 0.15, "force": 100},
    "bond": {"stiffness": 300, "length": 0.25},
    "integrator": {"scheme": "gw-vv", "dt": 0.002},
    "start": {"relax": {"steps": 50000, "dt": 0.002}},
    "steps": {"sample": 500},
}
SLABS = {
    "dimension": 3,
    "box": [8, 8, 20],
    "molecules": [{"architecture": "A", "density": 1.5}, {"architecture": "B", "density": 1.5}],
    "repulsion": {"A A": 25, "B B": 25, "A B": 37},
    "integrator": {"scheme": "gw-vv", "dt": 0.04},
    "start": {"method": "slabs", "relax": {"steps": 500, "dt": 0.02}},
    "steps": {"sample": 1000},
}
# What the sweeps of the papers are made of, with their observables.
OLIGOMERS = {
    "dimension": 3,
    "box": 10.0794,
    "molecules": [{"architecture": "A 4", "density": 3}],
    "repulsion": {"A A": 25},
    "bond": {"stiffness": 1000, "length": 0.4},
    "integrator": {"scheme": "gw-vv", "dt": 0.008},
    "start": {"relax": {"steps": 500, "dt": 0.004}},
    "steps": {"sample": 1000},
    "observe": [{"thermo": {"every": 5}}, {"bonds": {"every": 50}}],
}
OBSERVED_MELT = MELT | {
    "integrator": {"scheme": "dpd-vv", "dt": 0.02},
    "observe": ["thermo", "bonds", "chains", "displacement"],
}
DENSE_SLABS = SLABS | {
    "box": [8, 8, 16],
    "molecules": [{"architecture": "A", "density": 2.5}, {"architecture": "B", "density": 2.5}],
    "repulsion": {"A A": 15, "B B": 15, "A B": 22},
    "observe": ["thermo", "profile"],
}
CHANNEL = {
    "dimension": 3,
    "box": [6, 6, 12],
    "molecules": [{"architecture": "A", "density": 3}],
    "repulsion": {"A A": 25},
    "walls": {"axis": "z", "repulsion": 25, "gamma": 4.5},
    "body_force": {"axis": "x", "strength": 0.03},
    "integrator": {"scheme": "gw-vv", "dt": 0.04},
    "start": {"relax": {"steps": 500, "dt": 0.02}},
    "steps": {"sample": 1000},
    "observe": ["thermo", "walls", "profile", "velocity_profile"],
}
SHEARED = {
    "dimension": 3,
    "box": 10,
    "molecules": [{"architecture": "A", "density": 3}],
    "repulsion": {"A A": 25},
    "shear": {"rate": 0.2, "flow": "x", "gradient": "y"},
    "integrator": {"scheme": "gw-vv", "dt": 0.04},
    "start": {"relax": {"steps": 500, "dt": 0.02}},
    "steps": {"sample": 1000},
    "observe": ["thermo", "rdf"],
}


class Workload(NamedTuple):
    """A system that speed is measured on: in words, and as a scene."""

    system: str
    scene: dict[str, Any]


WORKLOADS = {
    "W1": Workload("standard fluid: 24 000 beads, rho 3, a 25, dt 0.04", FLUID),
    "W2": Workload("melt of Nikunen: 128 chains of 64, rho 1, a 100, k 200, dt 0.02", MELT),
    "W2, dpd-vv": Workload(
        "the same with friction twice a step, which LAMMPS has not",
        MELT | {"integrator": {"scheme": "dpd-vv", "dt": 0.02}},
    ),
    "W3": Workload(
        "melt of Liu: 20 000 beads in two dimensions, N 100, set (1), dt 0.002", FLAT_MELT
    ),
    "W4": Workload("slabs: 8 x 8 x 20, rho 3, a 25, a_AB 37, dt 0.04", SLABS),
}
STUDIES = {
    "oligomers": Workload("tetramers: 3072 beads, rho 3, stiff bonds, pressure often", OLIGOMERS),
    "melt": Workload("W2 with dpd-vv and what is observed of chains", OBSERVED_MELT),
    "slabs": Workload("slabs at rho 5: 5120 beads, with their profile", DENSE_SLABS),
    "channel": Workload("flow between walls: 1296 beads, with profiles", CHANNEL),
    "shear": Workload("steady shear: 3000 beads, with g(r)", SHEARED),
}
# tau, about the integrated autocorrelation times of kT and pressure. Beads of W2 hardly overlap,
# and only those that do feel friction: its heat leaves in some twenty tau. W4's interface breathes.
MEMORY = {"W1": 1.0, "W2": 20.0, "W2, dpd-vv": 20.0, "W3": 2.0, "W4": 5.0}


def workload(name: str, **changes: Any) -> Scene:
    """The scene of a key of `WORKLOADS` or `STUDIES`, with some keys changed."""
    return Scene((WORKLOADS | STUDIES)[name].scene | changes, f"workload {name}")
