"""A scene in words, for whoever prints one."""

from __future__ import annotations

from typing import TYPE_CHECKING

from dpd.page import is_table

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
    thermostat, dt = dict(scene.data["thermostat"]), scene.dt
    if isinstance(thermostat["gamma"], dict):
        thermostat["gamma"] = f"{{{_pairs(thermostat['gamma'])}}}"
    steps, times = scene.steps, [f"{dt * number:g}" for number in scene.steps]
    lines = {
        "box": f"{' x '.join(f'{edge:g}' for edge in scene.box)} r_c",
        "beads": f"{scene.beads}, {scene.density:.4g} per r_c^{scene.dimension}",
        "molecules": "; ".join(_molecules(scene)),
        "repulsion": _pairs({pair: f"{value:.6g}" for pair, value in scene.repulsions.items()}),
        **{term.key: _pairs(scene.data[term.key]) for term in scene.own_forces},
        "masses": _pairs(scene.data.get("mass", {})),
        "core": _pairs(scene.data.get("core", {})),
        "bonds": _bonds(scene),
        "angles": _angles(scene),
        "walls": _pairs(scene.data.get("walls", {})),
        "body force": _pairs(scene.data.get("body_force", {})),
        "thermostat": _pairs(thermostat),
        "pressure": _pairs(scene.data.get("pressure", {})),
        "integrator": _integrator(scene),
        "shear": _shear(scene),
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
    return f"{count}, {_laws(scene.data['bond'])}"


def _angles(scene: Scene) -> str:
    if scene.angles is None:
        return ""
    return f"{len(scene.angles.members)}, {_laws(scene.data['angle'])}"


def _laws(given: dict) -> str:
    """One law for all, or each law with its pair or triple before it."""
    if not is_table(given):
        return _pairs(given)
    return "; ".join(f"{name}: {_pairs(law)}" for name, law in given.items())


def _integrator(scene: Scene) -> str:
    first = " (scheme auto: a first guess, which a run tries)" if scene.is_auto else ""
    integrator = scene.terms["integrator"].named
    return _pairs(integrator.model_dump(exclude_none=True, by_alias=True)) + first


def _shear(scene: Scene) -> str:
    if "shear" not in scene.data:
        return ""
    shear = scene.data["shear"]
    return f"rate {shear['rate']:g}, flow along {shear['flow']}, gradient along {shear['gradient']}"


def _pairs(values: dict) -> str:
    return ", ".join(f"{name} {value}" for name, value in values.items())
