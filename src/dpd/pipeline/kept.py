"""What a run keeps in its result beside what it measured: its last configuration and its state.

The last configuration is for everybody, see `dpd.particles.netcdf`. The group ``state`` is for
`dpd.pipeline.extend` alone. It holds the arrays of a checkpoint (`dpd.engine.checkpoint.arrays_of`)
that the last configuration lacks:

- ``identity``, the order in which the engine stores beads: sums over pairs are added up in it;
- ``force``, which a step begins with, and whose noise is that of the step before;
- ``image``, the boxes that beads have crossed (those of the last configuration are of whole
  molecules, which differ where a bond was once longer than half the box);
- ``peculiar``, how far each bead has gone along the flow by itself, under shear;
- ``slid``, by how much images had slid at its beginning, under shear;
- ``reference``, where the beads were when the list of pairs was made, if there is a list;
- ``box``, at constant pressure;
- ``step``;
- as ``0.NAME``, ``1.NAME`` and so on, the arrays of each observable in the order of the scene.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from dpd import files
from dpd.engine.checkpoint import arrays_of, checksum_of, file_of, mistake_in, put_back
from dpd.engine.state import State
from dpd.errors import UserError
from dpd.observe import observables
from dpd.page import Change
from dpd.particles.netcdf import attributes_of, particles_of, variables_of
from dpd.particles.particles import Particles, of_scene
from dpd.particles.tilt import box_at
from dpd.scene.scene import Scene
from dpd.stages import run_sources
from dpd.start.common.make import species_of, system_of

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

STATE = "state"  # name of the group
IN_CONFIGURATION = ("position", "velocity", "species")
CHECKSUM = "state_checksum"
NO_STATE = "not_extendable"  # attribute that says why there is no such group


class Kept(NamedTuple):
    """What `dpd.files.write` takes: variables, attributes, groups."""

    variables: dict[str, tuple]
    attributes: dict[str, Any]
    groups: dict[str, dict[str, np.ndarray]]


NOTHING = Kept({}, {}, {})


class Former(NamedTuple):
    """A finished run that a longer one can go on from.

    Attributes
    ----------
    scene : Scene
    state : State
    observers : list
        With all that they had in the end.
    attributes : dict
        Of its file.
    """

    scene: Scene
    state: State
    observers: list[Any]
    attributes: dict[str, Any]


def go_on_from(observer: Any, former: Any, step: int) -> None:
    """Put an observable where that of a run that was planned as long would be at a step.

    Its arrays do not depend on how long a run is planned to be, but for series and levels of
    correlations, for which a longer one has more room, and a shorter one enough.

    Parameters
    ----------
    observer : observable
        Before its first sample.
    former : observable
        The same of a run that was planned otherwise, with its own file.
    step : int
        Steps that this one has looked at.

    Raises
    ------
    ValueError
        If the two take their samples at other steps, of which some are over.
    """
    if observer.every != former.every:
        if observer.every <= step:
            raise ValueError(f"samples every {observer.every} steps cannot follow {former.every}")
        return  # the longer run would not have looked yet
    if (file := file_of(observer)) is not None:
        file.go_on_after(former.file.path, int(former.arrays["taken"][0]), former.arrays["digests"])
    for name, array in observer.arrays.items():
        room = min(len(array), len(former.arrays[name]))
        array[:room] = former.arrays[name][:room]


def last_configuration(scene: Scene, state: State) -> Particles:
    """The beads of a state in the order of their identities."""
    box = box_at(scene, state.step, state.slid) if state.box is None else state.box
    position, velocity = (state.by_identity(each) for each in (state.position, state.velocity))
    return of_scene(scene, box, position, state.image, velocity, state.step)


def kept_of(scene: Scene, state: State, observers: list[Any], why_not: str = "") -> Kept:
    """What a run keeps at its end.

    Parameters
    ----------
    scene : Scene
    state : State
    observers : list
    why_not : str
        Why no run can go on from this one, as where frames of its trajectory are lost; or nothing.
    """
    last = last_configuration(scene, state)
    attributes = attributes_of(last)
    if why_not:
        return Kept(variables_of(last), attributes | {NO_STATE: why_not}, {})
    arrays = arrays_of(state, observers)
    attributes[CHECKSUM] = checksum_of(arrays)
    stored = {
        name.replace("/", "."): np.asarray(array)
        for name, array in arrays.items()
        if name not in IN_CONFIGURATION
    }
    return Kept(variables_of(last), attributes, {STATE: stored})


def read_former(path: str | Path) -> Former:
    """The finished run in a file.

    Parameters
    ----------
    path : path
        Of a ``run.nc``.

    Returns
    -------
    Former

    Raises
    ------
    UserError
        If it is not the result of a run, or of one that cannot be made longer, or is damaged. All
        arrays must be such as its run could have had in the end.
    """
    refuse_other(path, files.attributes(path))
    variables, attributes = files.read(path)
    stored = files.read_group(path, STATE)
    scene = scene_of(path, attributes)
    if not stored:
        why = attributes.get(NO_STATE) or (
            "it holds no state to go on from. `dpd run --overwrite` makes it again with one; a run "
            "of a study has one if its scene says 'keep_state: true'"
        )
        raise UserError(f"{path}: {why}")
    last = particles_of(variables, attributes, path)
    blank = _blank_state(scene)
    if last.position.shape == blank.position.shape:
        velocity = blank.velocity if last.velocity is None else last.velocity
        blank = replace(blank, position=last.position, velocity=velocity, image=last.image)
    observers: list[Any] = list(observables(scene, system_of(scene), path, blank))
    arrays = _as_checkpoint(stored, last, blank)
    whole = attributes.get(CHECKSUM) == checksum_of(arrays)
    wrong = "" if whole else "its checksum does not fit"
    wrong = wrong or mistake_in(arrays, blank, scene.period, observers, scene.steps)
    if not wrong and attributes.get("scene_digest") != scene.digest:
        wrong = "its scene reads otherwise today, as where a default has changed"
    if not wrong and int(arrays["step"]) != sum(scene.steps):
        wrong = f"step {arrays['step']} of {sum(scene.steps)}"
    if wrong and attributes.get("sources") != run_sources(scene):
        raise UserError(
            f"{path}: made by another version of this program, which alone can make it longer "
            f"({wrong}); a new run can begin with its last configuration: --start {path}"
        )
    if wrong:
        raise UserError(
            f"{path}: the state that it holds cannot be right ({wrong}), so no run can go on from "
            "it; make the file anew"
        )
    return Former(scene, put_back(arrays, observers), observers, attributes)


def refuse_other(path: str | Path, attributes: Mapping[str, Any]) -> None:
    """Refuse what is no result, and that of a run which was lost.

    Parameters
    ----------
    path : path
    attributes : dict
        Of that file.

    Raises
    ------
    UserError
    """
    if "scene" not in attributes or "scene_digest" not in attributes:
        what = "a first configuration" if "start_digest" in attributes else "some other NetCDF file"
        raise UserError(f"{path}: this is {what}, not the result of a run; name a run.nc")
    lost = int(attributes.get("lost_step", -1))
    if lost >= 0:
        raise UserError(
            f"{path}: this run was lost at step {lost} (it blew up, or its bonds got "
            "too long), so nothing can go on from it; run its scene with a smaller dt"
        )


def scene_of(path: str | Path, attributes: Mapping[str, Any]) -> Scene:
    """The scene of a result, with the step that was chosen for it; or of a checkpoint's note."""
    scene = Scene.of_result(attributes.get("scene"), str(path))
    if chosen := attributes.get("chosen"):
        scene.chosen = chosen if isinstance(chosen, dict) else {"said": chosen}
    return scene


def _blank_state(scene):
    """A state of the scene as far as shapes and species go."""
    zeros = np.zeros((scene.dimension, scene.beads))
    identity = np.arange(scene.beads, dtype=np.uint32)
    reference = zeros if scene.skin > 0 else None
    slid = 0 if Change.SLIDES in scene.made else None
    box = scene.box if Change.STRETCHES in scene.made else None
    peculiar = None if slid is None else np.zeros(scene.beads)
    return State(
        zeros, zeros, zeros, identity, species_of(scene), 0, reference, slid, box, peculiar=peculiar
    )


def _as_checkpoint(
    stored: Mapping[str, np.ndarray], last: Particles, blank: State
) -> dict[str, np.ndarray]:
    """The arrays of a checkpoint, from those of the group and from the last configuration."""
    arrays = {name.replace(".", "/"): np.asarray(array) for name, array in stored.items()}
    identity = arrays.get("identity")
    if identity is None or not np.array_equal(np.sort(identity), blank.identity):
        return arrays  # which lack positions, and so cannot be right
    arrays["position"] = last.position[:, identity]
    arrays["velocity"] = last.velocity[:, identity] if last.velocity is not None else np.zeros(0)
    if blank.species is not None:
        arrays["species"] = last.species[identity]
    return arrays
