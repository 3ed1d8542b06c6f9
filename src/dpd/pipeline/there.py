"""What is in the place of a run before it begins: people edit a scene and run it again.

A result of the same scene is kept, and nothing else is replaced unless they ask for it.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from dpd import files
from dpd.engine.checkpoint import key_of, note_of
from dpd.errors import Occupied, OtherPage, UserError
from dpd.pipeline.kept import scene_of
from dpd.pipeline.simulate import checkpoint_path
from dpd.scene.scene import Scene
from dpd.stages import run_sources


def result_there(scene: Scene, output: Path, say: Callable[[str], object]) -> Scene | None:
    """The scene of a result that is there, if it is the same (``say`` tells); None for no file.

    Raises
    ------
    Occupied
        If anything else is in the place of the output, or in that of what lies beside it.
    """
    checkpoint, beside = checkpoint_path(output), scene.files_beside(output).values()
    if not files.is_filled(output):
        refuse_to_lose(scene, checkpoint)
        for path in beside if not key_of(checkpoint) else ():
            # Here, as most scenes have no trajectory, and its library takes time to import.
            from dpd.particles.trajectory_file import refuse_other_trajectory

            refuse_other_trajectory(path)  # which --overwrite does not replace either
            files.refuse_to_replace(path)
        return None
    try:
        attributes = files.attributes(output)
        former = scene_of(output, attributes) if "scene_digest" in attributes else None
    except OtherPage as problem:
        raise Occupied(
            f"{output}: holds the result of a run with another page; {problem}"
        ) from None
    except UserError:
        former = None
    if former is None:
        raise Occupied(f"{output}: is there already, and no result of a run that can be read")
    if not _same(scene, former):
        raise Occupied(f"{output}: holds the result of {_other(scene, former)}")
    if missing := [path for path in beside if not path.is_file()]:
        raise Occupied(f"{output}: is there already, but not {missing[0]}, which belongs to it")
    is_ours = attributes.get("sources") == run_sources(former)
    version = "" if is_ours else ", made by another version of this program"
    say(f"{output}: is there already, of the same scene{version}; it is kept, and nothing was run")
    return former


def refuse_to_lose(scene: Scene, checkpoint: Path) -> None:
    """Refuse to begin anew where the state of a run lies from which this one cannot go on."""
    if not (key := key_of(checkpoint)):
        return
    holds = f"{checkpoint}: holds the state of a run that was stopped or killed,"
    try:
        former = scene_of(checkpoint, note_of(checkpoint) or {})
    except OtherPage as problem:
        raise Occupied(f"{holds} with another page; {problem}") from None
    except UserError:
        raise Occupied(f"{holds} of an older version, which alone can go on with it") from None
    if not _same(scene, former):
        raise Occupied(f"{holds} of {_other(scene, former)}")
    if key.get("sources") != run_sources(former):
        raise Occupied(
            f"{holds} of another version of this program, such as 0.2, which alone can go on with "
            "it: finish the run with that one"
        )
    if key.get("kept") is not former.data.get("keep_state", True):
        raise Occupied(f"{holds} of a study, which keeps less: finish it by the same command")


def remove_left(checkpoint: Path, scene: Scene) -> bool:
    """Remove the checkpoint of a run whose result is whole; whether there was one."""
    left = key_of(checkpoint).get("scene") == scene.digest
    if left:
        checkpoint.unlink(missing_ok=True)
    return left


def _same(scene, former):
    """Whether two scenes are the same; one that leaves its step to us is with what it found."""
    if scene.is_auto:
        said = (former.chosen or {}).get("said", "")
        if not said.endswith(f"asked for: {100 * scene.terms['integrator'].tolerance:g} %)"):
            return False
        scene = Scene(scene.data | {"integrator": former.data["integrator"]}, scene.where)
    return scene.digest == former.digest


def _other(scene, former):
    """What distinguishes the scene of a file from one that is to be run."""
    mine, its = scene.data, former.data
    keys = sorted(key for key in mine.keys() | its.keys() if mine.get(key) != its.get(key))
    more = former.steps.sample - scene.steps.sample
    if keys == ["steps"] and former.steps.equilibrate == scene.steps.equilibrate:
        hint = " (`dpd extend` makes a result longer)" if more < 0 else ""
        return f"this scene, {abs(more)} steps {'longer' if more > 0 else 'shorter'}{hint}"
    return f"another scene, with other values of {', '.join(keys)}"
