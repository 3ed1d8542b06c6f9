"""The first configuration is read from a file of any origin."""

import hashlib
import os
from collections.abc import Collection
from functools import cache
from pathlib import Path
from typing import Any, Self

from dpd.errors import UserError
from dpd.page import Start, setting

LAST_FRAME = -1  # of a file with several configurations


class FromFile(Start, key="file"):
    """As it stands in a file."""

    completes = "box", "molecules"
    path: str = setting(
        "GSD (.gsd), LAMMPS data (.data, .lmp, data.NAME), or a run.nc, start.nc or .checkpoint of "
        "this program; it must have the box and the molecules of the scene, if it names any, each "
        "of these with its beads in the order of the architecture; at constant pressure its box is "
        "that of the start. A relative path counts from the file of the scene.",
        min_length=1,
    )  # fmt: skip
    frame: int | None = setting(
        "Which configuration of a trajectory, from 0, or from the last with -1, -2 ...; if not "
        "given, the last.", None, ge=-(10**9), le=10**9,
    )  # fmt: skip
    sha256: str | None = setting(
        "The digest that its content must have. If not given, it is found and becomes part of the "
        "scene.", None, pattern=r"^[0-9a-f]{64}$",
    )  # fmt: skip

    def found(self, folder: str | Path, where: str) -> Self:
        """With the whole path and the digest; a file of a given digest is not yet looked at."""
        path = os.path.abspath(os.path.join(folder, self.path))
        digest = self.sha256 or file_digest(path, where)
        return self.model_copy(update={"path": path, "sha256": digest})

    def system(self, where: str, words: Collection[str]) -> dict[str, Any]:
        """Box and molecules that are in the file, with types that the scene may name."""
        from dpd.particles import read
        from dpd.particles.particles import molecules_of

        try:
            particles = read(self.path, self.read_frame)
        except UserError as problem:
            raise UserError(f"{where}: start.path: {problem}") from None
        types = {one: name for one, name in particles.types.items() if name in words}
        molecules = molecules_of(particles._replace(types=types))
        return {"box": list(map(float, particles.box)), "molecules": molecules}

    def content(self) -> Any:
        return {key: value for key, value in self.plain().items() if key != "path"}

    def decides(self, scene: Any) -> dict[str, Any]:
        """What is in the file; whether its box is taken, along which axes it may differ."""
        axes = {"box_of_file": scene.barostat_axes} if scene.barostat_axes else {}
        return {"file": [self.sha256, self.read_frame]} | axes

    @property
    def read_frame(self) -> int:
        return LAST_FRAME if self.frame is None else self.frame

    def make(self, scene: Any, progress: Any, say: Any) -> Any:
        """Read it, and relax it where the scene asks for that; refused if it is another by now."""
        if file_digest(self.path, scene.where) != self.sha256:
            raise UserError(
                f"{self.path}: is not the file that {scene.where} means: its content is not that "
                "of start.sha256. If it was changed on purpose, start again without that key"
            )
        from dpd.start.common.files import state_from_file
        from dpd.start.common.make import relaxed

        return relaxed(scene, state_from_file(scene, say), progress)

    def stand_in(self) -> dict[str, Any]:
        """Beads anywhere."""
        rest = self.model_dump(exclude_none=True, include=set(Start.model_fields))
        return rest | {"method": "random"}


def file_digest(path: str, where: str) -> str:
    """SHA-256 of what is in a file; refused, with ``where`` in front, if it cannot be read."""
    from dpd.files import check_input, reading  # NetCDF, which few scenes need to be read

    try:
        check_input(path)
        with reading(path):
            found = os.stat(path)
            return _digest_of(path, found.st_mtime_ns, found.st_size)
    except UserError as problem:
        raise UserError(f"{where}: start.path: {problem}") from None


@cache
def _digest_of(path, changed, size):
    """The same; a file that has not changed is read once for all scenes of a sweep."""
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
