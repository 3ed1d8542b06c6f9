"""Checkpoints: the state of a run and what its observers have, in a file of `numpy.savez`."""

from __future__ import annotations

import hashlib
import json
import os
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from dpd.engine.state import State
from dpd.errors import UserError, reason
from dpd.files import draft_of

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from dpd.engine.simulation import Simulation

# Names of arrays: the first of the file, which tells it from any other; and what is no array.
MARK, NOTE, CHECKSUM = "dpd_checkpoint", "note", "checksum"


class Stored(NamedTuple):
    """What stands in a checkpoint: see `Checkpoint`."""

    key: dict[str, Any]
    note: dict[str, Any]
    arrays: dict[str, np.ndarray]


def stored_in(path: str | os.PathLike[str]) -> Stored | None:
    """What stands in a checkpoint; None where there is none, or a damaged one."""
    if not os.path.isfile(path):  # a pipe would let us wait
        return None
    try:
        with np.load(path) as file:
            arrays = dict(file)
        if str(arrays.pop(CHECKSUM)) != checksum_of(arrays):
            return None
        key, note = (json.loads(str(arrays.pop(name))) for name in (MARK, NOTE))
    except Exception:  # NumPy and zipfile have a dozen for files that are damaged
        return None
    return Stored(key, note or {}, arrays)


def refuse_other_file(path: str | Path) -> None:
    """Refuse to let a checkpoint take the place of what is no checkpoint, whole or damaged."""
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


class Checkpoint:
    """State and observers' arrays in one file, written whole or not at all, with a checksum.

    The key is what the run is, scene and code digests: a file with another one is ignored. The note
    is plain data.
    """

    def __init__(self, path: str | Path, key: dict[str, Any], note: Any = None) -> None:
        self.path, self.key, self.note = Path(path), key, note or {}
        self.is_ours = False  # whether the file is of this run: saved by it, or resumed from

    def save(self, simulation: Simulation, observers: Sequence[Any]) -> str:
        """Write the state; why it could not be, or nothing. A kill leaves the previous file."""
        for file in filter(None, map(file_of, observers)):
            file.flush()
        texts = {MARK: json.dumps(self.key, sort_keys=True), NOTE: json.dumps(self.note)}
        arrays = {name: np.array(text) for name, text in texts.items()}
        arrays |= arrays_of(simulation.state, observers)
        arrays[CHECKSUM] = np.array(checksum_of(arrays))
        try:
            with draft_of(self.path) as draft, open(draft, "wb") as file:
                np.savez(file, **arrays)  # type: ignore[arg-type]  # no key is allow_pickle
            self.is_ours = True
        except OSError as problem:
            return f"{self.path}: no checkpoint could be written ({reason(problem)})"
        return ""

    def resume(self, simulation: Simulation, observers: Sequence[Any]) -> str:
        """Put simulation and observers, at their beginning, where the file left them.

        Return why the file is refused, or nothing; a `UserError` if it is no checkpoint at all.
        """
        if not os.path.lexists(self.path):
            return ""
        refuse_other_file(self.path)
        stored = stored_in(self.path)
        if stored is None:
            return f"{self.path}: a damaged checkpoint; starting anew"
        if stored.key != self.key:
            return f"{self.path}: a checkpoint of another scene or other sources; starting anew"
        if wrong := _cut_files(stored.arrays, observers):
            return f"{self.path}: a checkpoint that cannot be right ({wrong}); starting anew"
        simulation.state = put_back(stored.arrays, observers)
        self.is_ours = True
        return ""

    def discard(self) -> None:
        """Remove the file once the run's result is written."""
        refuse_other_file(self.path)
        self.path.unlink(missing_ok=True)


def file_of(observer: Any) -> Any:
    """The file that an observer writes beside the result; None for one that writes none."""
    return getattr(observer, "file", None)


def _cut_files(stored, observers):
    """Let observers with files of their own go on where they were; why one cannot, or nothing."""
    for i, observer in enumerate(observers):
        if file := file_of(observer):
            frames, digests = int(stored[f"{i}/taken"][0]), stored.get(f"{i}/digests")
            if wrong := file.cut(frames, digests):
                return wrong
    return ""


def arrays_of(state: State, observers: Sequence[Any]) -> dict[str, np.ndarray]:
    """All that a run consists of, by name: its state, and ``0/NAME`` of the first observer..."""
    arrays = {name: np.asarray(value) for name, value in vars(state).items() if value is not None}
    if state.slid is not None:
        arrays["slid"] = np.array(state.slid, np.uint64)
    for i, observer in enumerate(observers):
        arrays |= {f"{i}/{name}": array for name, array in observer.arrays.items()}
    return arrays


def put_back(stored: Mapping[str, np.ndarray], observers: Sequence[Any]) -> State:
    """What `arrays_of` took apart: the state; observers are filled with what they had."""
    for i, observer in enumerate(observers):
        for name, array in observer.arrays.items():
            array[...] = stored[f"{i}/{name}"]
    state: dict[str, Any] = {each.name: stored.get(each.name) for each in fields(State)}
    for name, plain in (("step", int), ("slid", int), ("box", lambda box: tuple(map(float, box)))):
        state[name] = None if state[name] is None else plain(state[name])
    return State(**state)


def checksum_of(arrays: Mapping[str, np.ndarray]) -> str:
    """Digest of names, types, shapes and values."""
    total = hashlib.sha256()
    for name in sorted(arrays):
        array = np.asarray(arrays[name])
        total.update(f"{name} {array.dtype.str} {array.shape}".encode())
        total.update(array.tobytes())
    return total.hexdigest()
