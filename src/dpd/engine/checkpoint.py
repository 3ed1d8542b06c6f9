"""Checkpoints: the state of a run and what its observers have, in one file.

The file is NumPy's own (`numpy.load` reads it), written whole or not at all, with a checksum of
all that stands in it. What a run resumes from is not believed: whoever wrote it, every array must
be one that this run could have had at that step.
"""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from dpd.drafts import draft_of
from dpd.engine.state import State
from dpd.errors import UserError, reason

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from dpd.engine.loop import Observer
    from dpd.engine.simulation import Simulation

CUTOFF = 1.0
LONGEST_STRETCH = 500  # steps between looks at the clock,
MOST_WORK = 20_000_000  # and bead-steps: two seconds of a large system
# The first array of the file, which tells it from any other.
MARK = "dpd_checkpoint"
NOTE = "note"


def stretch_of(beads: int) -> int:
    """Steps between looks at the clock."""
    return max(1, min(LONGEST_STRETCH, MOST_WORK // beads))


def next_sample(observer: Observer, now: int, equilibrate: int) -> int:
    """Step of the observer's next sample after ``now``."""
    taken = _taken(observer, now, equilibrate)
    return counts_from(observer, equilibrate) + (taken + 1) * observer.every


def counts_from(observer: Any, equilibrate: int) -> int:
    """Step from which on the observer counts: 0 if it looks at the equilibration as well."""
    return 0 if getattr(observer, "equilibration", False) else equilibrate


def next_look(now: int, observers: Sequence[Any], equilibrate: int, beads: int) -> int:
    """The next step at which the clock is looked at.

    They follow the last sample at equal distances, whether a run began before that or goes on from
    a shorter one.
    """
    stretch = stretch_of(beads)
    return now + stretch - (now - _last_sample(now, observers, equilibrate)) % stretch


def _last_sample(now, observers, equilibrate):
    """Step of the last sample of any observer; 0 before the first."""
    sampled = [
        counts_from(observer, equilibrate) + taken * observer.every
        for observer in observers
        if (taken := _taken(observer, now, equilibrate))
    ]
    return max(sampled, default=0)


def _taken(observer, now, equilibrate):
    """Samples that the observer has at step ``now``."""
    return max(now - counts_from(observer, equilibrate), 0) // observer.every


def file_of(observer: Any) -> Any:
    """The file that an observer writes beside the result; None for one that writes none."""
    return getattr(observer, "file", None)


def refuse_other_file(path: str | Path) -> None:
    """Refuse to let a checkpoint take the place of somebody's file.

    Raises
    ------
    UserError
        If something is there that is neither a checkpoint, whole or damaged, nor empty.
    """
    if not os.path.lexists(path):
        return
    try:
        if os.path.isfile(path):
            with open(path, "rb") as file:
                head = file.read(64)
            if not head or (head.startswith(b"PK") and MARK.encode() in head):
                return
    except OSError as problem:
        raise UserError(f"{path}: cannot be read ({reason(problem)})") from None
    raise UserError(
        f"{path}: the checkpoint of this run would take its place, and it is no checkpoint; move "
        "it away, or choose another name for the result"
    )


def note_of(path: str | Path) -> Any:
    """What stands beside the state in a checkpoint: plain data; None where there is none.

    Parameters
    ----------
    path : path
        Of a file that may be missing, damaged, or no checkpoint.
    """
    stored = whole(path) if os.path.isfile(path) else None
    return json.loads(str(stored[NOTE])) if stored and NOTE in stored else None


def key_of(path: str | os.PathLike[str]) -> dict[str, object]:
    """What run a checkpoint is of; nothing where there is none, or a damaged one."""
    stored = whole(path) if os.path.isfile(path) else None
    return json.loads(str(stored[MARK])) if stored else {}


def whole(path: str | os.PathLike[str]) -> dict[str, np.ndarray] | None:
    """All arrays of a checkpoint but its checksum; None if it is damaged or none.

    Parameters
    ----------
    path : path
    """
    try:
        with np.load(path) as file:
            stored = dict(file)
        whole = str(stored.pop("checksum")) == checksum_of(stored)
    except Exception:  # NumPy and zipfile have a dozen for files that are damaged
        return None
    return stored if whole else None


class Checkpoint:
    """State and observers' arrays in one file, written whole or not at all.

    Parameters
    ----------
    path : path
    key : dict
        What the run is: scene and code digests. A file with another key is ignored.
    note : object
        Plain data to keep beside the state, see `note_of`.
    """

    def __init__(self, path: str | Path, key: dict[str, Any], note: Any = None) -> None:
        self.path = Path(path)
        self.key = json.dumps(key, sort_keys=True)
        self.note = json.dumps(note)
        self.is_ours = False  # whether the file is of this run: saved by it, or resumed from

    def save(self, simulation: Simulation, observers: Sequence[Observer]) -> str:
        """Write the state; a kill while writing leaves the previous file.

        Returns
        -------
        str
            Why it could not be written, or nothing.
        """
        for file in filter(None, map(file_of, observers)):
            file.flush()
        arrays = {MARK: np.array(self.key), NOTE: np.array(self.note)}
        arrays |= arrays_of(simulation.state, observers)
        arrays["checksum"] = np.array(checksum_of(arrays))
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            with draft_of(self.path) as draft:
                with open(draft, "wb") as file:
                    np.savez(file, **arrays)  # type: ignore[arg-type]  # no key is allow_pickle
                os.replace(draft, self.path)
            self.is_ours = True
        except OSError as problem:
            return f"{self.path}: no checkpoint could be written ({reason(problem)})"
        return ""

    def resume(
        self, simulation: Simulation, observers: Sequence[Observer], steps: tuple[int, int]
    ) -> str:
        """Put simulation and observers where the file left them, wholly or not at all.

        Parameters
        ----------
        simulation : Simulation
            At its beginning, as the observers.
        observers : list
        steps : (int, int)
            Of the run: to equilibrate, to sample.

        Returns
        -------
        str
            Why the file is refused, or nothing.

        Raises
        ------
        UserError
            If the file is not a checkpoint at all: it is somebody's, and stays.
        """
        if not os.path.lexists(self.path):
            return ""
        refuse_other_file(self.path)
        stored = whole(self.path)
        if stored is None:
            return f"{self.path}: a damaged checkpoint; starting anew"
        if str(stored.pop(MARK)) != self.key:
            return f"{self.path}: a checkpoint of another scene or other sources; starting anew"
        stored.pop(NOTE, None)
        state, box = simulation.state, simulation.system.box
        wrong = mistake_in(stored, state, box, observers, steps)
        if wrong := wrong or _cut_files(stored, observers, sum(steps)):
            return f"{self.path}: a checkpoint that cannot be right ({wrong}); starting anew"
        simulation.state = put_back(stored, observers)
        self.is_ours = True
        return ""

    def discard(self) -> None:
        """Remove the file once the run's result is written."""
        if os.path.lexists(self.path):
            refuse_other_file(self.path)
            self.path.unlink(missing_ok=True)


def _cut_files(stored, observers, last):
    """Let observers with files of their own go on where they were; why one cannot, or nothing."""
    for i, observer in enumerate(observers):
        frames = int(stored[f"{i}/taken"][0]) if (file := file_of(observer)) else 0
        digests, is_over = stored.get(f"{i}/digests"), int(stored["step"]) == last
        if file and (wrong := file.cut(frames, digests, is_over)):
            return wrong
    return ""


def arrays_of(state: State, observers: Sequence[Any]) -> dict[str, np.ndarray]:
    """All that a run consists of, as arrays by name: its state, and what observers have so far.

    Parameters
    ----------
    state : State
    observers : list

    Returns
    -------
    dict of str to array
        ``step``, the arrays of the state, and ``0/NAME`` of the first observer, and so on.
    """
    arrays = {"step": np.array(state.step)}
    for name in (
        "position", "velocity", "force", "identity", "species", "reference", "image", "peculiar",
    ):  # fmt: skip
        if getattr(state, name) is not None:
            arrays[name] = getattr(state, name)
    if state.slid is not None:
        arrays["slid"] = np.array(state.slid, np.uint64)
    if state.box is not None:
        arrays["box"] = np.array(state.box)
    for i, observer in enumerate(observers):
        arrays |= {f"{i}/{name}": array for name, array in observer.arrays.items()}
    return arrays


def put_back(stored: Mapping[str, np.ndarray], observers: Sequence[Any]) -> State:
    """What `arrays_of` took apart: the state, and observers filled with what they had.

    Parameters
    ----------
    stored : dict of str to array
        In which `mistake_in` has found none.
    observers : list
        They are changed.

    Returns
    -------
    State
    """
    for i, observer in enumerate(observers):
        for name, array in observer.arrays.items():
            array[...] = stored[f"{i}/{name}"]
    return State(
        stored["position"], stored["velocity"], stored["force"], stored["identity"],
        stored.get("species"), int(stored["step"]), stored.get("reference"),
        int(stored["slid"]) if "slid" in stored else None,
        tuple(map(float, stored["box"])) if "box" in stored else None,
        stored["image"], stored.get("peculiar"),
    )  # fmt: skip


def checksum_of(arrays: Mapping[str, np.ndarray]) -> str:
    """Digest of names, types, shapes and values.

    Parameters
    ----------
    arrays : dict of str to array

    Returns
    -------
    str
    """
    total = hashlib.sha256()
    for name in sorted(arrays):
        array = np.asarray(arrays[name])
        total.update(f"{name} {array.dtype.str} {array.shape}".encode())
        total.update(array.tobytes())
    return total.hexdigest()


def mistake_in(
    stored: Mapping[str, np.ndarray],
    state: State,
    box: tuple[float, ...],
    observers: Sequence[Any],
    steps: tuple[int, int],
) -> str:
    """What in some arrays cannot be of a run, or nothing.

    Parameters
    ----------
    stored : dict of str to array
        As `arrays_of` has them.
    state : State
        Of the run at its beginning, whole: arrays of the right shapes, and the species.
    box : tuple of float
        Of a run in which it stays as it is.
    observers : list
        At their beginning.
    steps : (int, int)
        Of the run: to equilibrate, to sample.

    Returns
    -------
    str
    """
    fresh = arrays_of(state, observers)
    if "image" not in stored:
        return "it is of version 0.2 or older, without counts of the boxes that beads have crossed"
    if stored.keys() != fresh.keys():
        return f"parts missing or too many: {', '.join(sorted(stored.keys() ^ fresh.keys()))}"
    for name, array in fresh.items():
        found = stored[name]
        if found.shape != array.shape or found.dtype != array.dtype:
            return f"{name} is {found.dtype} {found.shape}, not {array.dtype} {array.shape}"
        # Series are NaN until they are sampled.
        if array.dtype.kind == "f" and not np.isfinite(found[np.isfinite(array)]).all():
            return f"{name} has values that are not finite numbers"
    return (
        _wrong_step(int(stored["step"]), observers, steps, stored["identity"].size)
        or _wrong_beads(stored, state, box)
        or _wrong_samples(stored, observers, steps)
    )


def _wrong_step(step, observers, steps, beads):
    """Whether the run looks at the clock at that step."""
    (equilibrate, _), last = steps, sum(steps)
    if not 0 <= step <= last:
        return f"step {step} of {last}"
    since = step - _last_sample(step, observers, equilibrate)
    if step != last and since % stretch_of(beads):
        return f"step {step}, at which no checkpoint is made"
    return ""


def _wrong_beads(stored, state, box):
    """Whether every bead is there once, of its species, in the box."""
    identity = stored["identity"]
    if not np.array_equal(np.sort(identity), np.arange(identity.size)):
        return "beads that are there twice or not at all"
    if state.species is not None:
        species = state.by_identity(state.species)
        if not np.array_equal(stored["species"], species[identity]):
            return "beads of another species"
    edges = np.array(stored.get("box", box))[:, None]
    if (edges < 2 * CUTOFF).any():
        return "a box that is too small"
    for name in ("position", "reference"):
        if name in stored and not ((stored[name] >= 0) & (stored[name] <= edges)).all():
            return f"{name} outside the box"
    return ""


def _wrong_samples(stored, observers, steps):
    """Whether the observers have as many samples as they should at that step."""
    equilibrate, _ = steps
    for i, observer in enumerate(observers):
        expected = _taken(observer, int(stored["step"]), equilibrate)
        taken = stored.get(f"{i}/taken")
        if taken is not None and ((taken < 0).any() or taken.sum() != expected):
            return f"{taken.sum()} samples instead of {expected}"
        for name, array in observer.arrays.items():
            if array.dtype.kind != "f" or np.isfinite(array).all():
                continue
            found = stored[f"{i}/{name}"]  # a series with one entry a sample
            there = np.isfinite(found)
            if np.isnan(found).all():
                continue  # what never has a value, as kT of a lone bead in a closed box
            if not there[:expected].all() or not np.isnan(found[expected:]).all():
                return f"{name} with samples that are not finite numbers, or too many"
    return ""
