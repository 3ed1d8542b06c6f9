"""What a scene may ask for under shear (`dpd.physics.shear`, `dpd.engine.space`)."""

from __future__ import annotations

from math import hypot
from typing import TYPE_CHECKING

from dpd.physics.schemes import WITHOUT_EXCHANGE, scheme_named
from dpd.scene.walls import period_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from dpd.scene.scene import Scene

    Refuse = Callable[[str, str], None]

AXES = "xyz"
CUTOFF = 1.0
# Keys of a scene that do not go together with shear, and why.
NOT_BESIDE = {
    "walls": "walls stand still, and the fluid would flow through or past them",
    "pressure": "how far images have slid is known for a box that keeps its size only",
}


def axes_of_shear(scene: Scene) -> tuple[int, int]:
    """Numbers of the axes of the flow and of its gradient."""
    shear = scene.data["shear"]
    return AXES.index(shear["flow"]), AXES.index(shear["gradient"])


def room_for_images(scene: Scene) -> tuple[float, ...]:
    """Edges of the box; along the flow of a shear the least distance that images may have.

    Half of it is how far a separation may reach along an axis and still be told from its images:
    images slide by up to half an edge, and the more they tilt, the less that is.
    """
    if "shear" not in scene.data:
        return period_of(scene)
    flow, gradient = axes_of_shear(scene)
    edges = list(scene.box)
    edges[flow] /= hypot(1.0, 0.5 * edges[flow] / edges[gradient])
    return tuple(edges)


def check_shear(scene: Scene, refuse: Refuse) -> None:
    """Refuse a shear that cannot be, and what does not go together with it.

    Parameters
    ----------
    scene : Scene
        Otherwise checked.
    refuse : callable
        Takes a key and what is wrong with it, and raises.
    """
    if "shear" not in scene.data:
        return
    shear = scene.data["shear"]
    if shear["rate"] == 0:
        refuse("shear.rate", "0 is no shear; allowed: a number that is not 0. Or remove the key")
    _check_axes(scene, refuse)
    _check_beside(scene, refuse)
    _check_box(scene, refuse)


def _check_axes(scene, refuse):
    """Two axes of the box, in their order: so files of other programs can hold the tilted box."""
    shear = scene.data["shear"]
    for key in ("flow", "gradient"):
        if AXES.index(shear[key]) >= scene.dimension:
            refuse(f"shear.{key}", f"two dimensions have no axis {shear[key]!r}; allowed: x and y")
    if shear["flow"] >= shear["gradient"]:
        refuse(
            "shear.gradient",
            f"{shear['gradient']!r} is the axis of the flow itself; allowed: an axis after it",
        )


def _check_beside(scene, refuse):
    """Schemes, lists and keys of a scene that do not go together with a flow."""
    for key, why in NOT_BESIDE.items():
        if key in scene.data:
            refuse("shear", f"not allowed together with {key!r}: {why}; remove one of them")
    scheme = scene.data["integrator"]["scheme"]
    if scene.is_auto:
        refuse(
            "integrator.scheme",
            "'auto' tries steps on a system at rest, which says nothing of shear; name a scheme "
            "and dt, as {scheme: gw-vv, dt: 0.04}",
        )
    if scheme_named(scheme).exchange is not None:
        refuse(
            "integrator.scheme",
            f"{scheme!r} lets pairs exchange momentum by their direction alone, and how the flow "
            "moves them apart depends on their distance; allowed with 'shear': "
            f"{WITHOUT_EXCHANGE}",
        )
    if scene.data["pairs"]["search"] == "list":
        refuse(
            "pairs.search",
            "a list does not last under shear, which moves all beads past each other; take cells, "
            "or remove the key",
        )


def _check_box(scene, refuse):
    """Images that slide too fast, or a box too short for them."""
    flow, gradient = axes_of_shear(scene)
    rate, dt = scene.data["shear"]["rate"], scene.data["integrator"]["dt"]
    height = scene.box[gradient]
    most = CUTOFF / (dt * height)
    if abs(rate) > most:
        refuse(
            "shear.rate",
            f"{rate:g} moves images by {abs(rate) * dt * height:.3g} r_c in a step, more than a "
            f"cutoff; allowed at dt {dt:g} in a box of {height:g} along {AXES[gradient]}: "
            f"-{most:.4g} to {most:.4g}",
        )
    if room_for_images(scene)[flow] < 2 * CUTOFF:
        least = 2 / (1 - 1 / height**2) ** 0.5
        refuse(
            "box",
            f"an edge of {scene.box[flow]:g} along the flow is too short for images that slide: a "
            f"bead could meet another one twice; allowed with {height:g} along {AXES[gradient]}: "
            f">= {least:.4g}",
        )
