"""A scene in words, for whoever prints one."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from dpd.scene.scene import Scene


def description(scene: Scene) -> str:
    """What a scene holds, a line for each part.

    Parameters
    ----------
    scene : dpd.scene.scene.Scene

    Returns
    -------
    str
    """
    thermostat, dt = scene.data["thermostat"], scene.data["integrator"]["dt"]
    steps, times = scene.steps, [f"{dt * number:g}" for number in scene.steps]
    lines = {
        "box": f"{' x '.join(f'{edge:g}' for edge in scene.box)} r_c",
        "beads": f"{scene.beads}, {scene.density:.4g} per r_c^{scene.dimension}",
        "molecules": "; ".join(_molecules(scene)),
        "repulsion": _pairs(scene.data["repulsion"]),
        "core": _pairs(scene.data.get("core", {})),
        "bonds": _bonds(scene),
        "thermostat": _pairs(thermostat),
        "pressure": _pairs(scene.data.get("pressure", {})),
        "integrator": _integrator(scene),
        "steps": f"{steps.equilibrate} to equilibrate, {steps.sample} to sample "
        f"({' + '.join(times)} tau)",
        "observe": ", ".join(scene.observe),
        "note": "; ".join(scene.notes),
    }
    text = "\n".join(f"  {name:10s}  {value}" for name, value in lines.items() if value)
    return f"<dpd.Scene {scene.where}>\n{text}"


def _molecules(scene: Scene) -> list[str]:
    return [
        f"{kind.count} of {given['architecture']}"
        for kind, given in zip(scene.molecules, scene.data["molecules"])
    ]


def _bonds(scene: Scene) -> str:
    if "bond" not in scene.data:
        return ""
    count = sum(kind.count * (len(kind.beads) - 1) for kind in scene.molecules)
    return f"{count}, {_pairs(scene.data['bond'])}"


def _integrator(scene: Scene) -> str:
    first = " (scheme auto: a first guess, which a run tries)" if scene.is_auto else ""
    return _pairs(scene.data["integrator"]) + first


def _pairs(values: dict) -> str:
    return ", ".join(f"{name} {value}" for name, value in values.items())
