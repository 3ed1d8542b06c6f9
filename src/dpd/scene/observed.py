"""What a scene observes, and how often where it does not say."""

from __future__ import annotations

from typing import Any

from dpd.scene.schema import schema, with_defaults

MOST_SAMPLES = 10_000  # of a time series, unless the scene says how often
MOST_FRAMES = 100  # of density fields, likewise
# tau between samples where the scene does not say: about the memory of the momenta, a
# fraction of the time in which a bead moves its own size, and what moves slower. kT and pressure
# remember 0.3 to 0.8 tau: a mean over samples 0.16 apart has 2 % more variance than one over twice
# as many, which would take a tenth more of the run time.
INTERVALS = {
    "thermo": 0.16, "walls": 0.16, "velocity_profile": 0.2, "displacement": 0.1, "crossings": 0.2,
    "passes": 0.1, "diffusion": 0.2, "structure_factor": 2.0, "stress_profile": 0.4,
}  # fmt: skip
SLOWER = 0.8


def observed(data: dict[str, Any], sample: int) -> dict[str, dict[str, Any]]:
    """Settings of each observable by name, with ``every`` filled in.

    Parameters
    ----------
    data : dict
        Of the scene.
    sample : int
        Steps that it samples.
    """
    rules = schema("scene")["properties"]["observe"]["items"]["oneOf"][1]["properties"]
    chosen = {}
    for item in data["observe"]:
        name, settings = (item, {}) if isinstance(item, str) else next(iter(item.items()))
        chosen[name] = with_defaults(settings, rules[name])
        if "every" not in chosen[name]:
            chosen[name]["every"] = _every(name, chosen[name], data["integrator"]["dt"], sample)
    return chosen


def _every(name, settings, dt, sample):
    """Steps between samples where the scene does not say."""
    if name == "configuration":
        return sample
    every = round(INTERVALS.get(name, SLOWER) / dt)
    if name == "thermo":
        every = max(every, -(-sample // MOST_SAMPLES))
    if name == "density_field":
        every = max(every, -(-sample // (MOST_FRAMES * settings["average"])))
    return max(1, min(every, sample))
