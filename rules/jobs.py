"""Commands of the rules, each in a copy of one process that has imported what they need.

A command takes 0.8 s to start, nearly all of it imports, and a study has some three hundred; a copy
takes 0.2 s. So Snakemake begins with one process that imports everything and waits (`serve`). A
rule calls this file with the words of a command: it sends them there with its environment and its
standard streams, the process makes a copy of itself (a fork) that does what they say, and this one
ends with its exit code. Where there is no such process, or sources have changed since it began, the
command starts by itself, as `python -m dpd`.
"""

import marshal  # which is there without an import, as json is not
import os
import signal
import socket
import sys

PLACE = "DPD_JOBS"  # variable of the environment: the socket of the process
MODULES = (
    "dpd.commands.pipeline", "dpd.commands.user", "dpd.engine.simulation", "dpd.runs.run",
    "dpd.analysis.collect", "dpd.report.figures", "dpd.report.page", "scipy.special",
    "scipy.optimize", "matplotlib.backends.backend_agg", "matplotlib.backends.backend_pdf",
)  # fmt: skip


def call(words):
    """Have a command done, and end with its exit code."""
    with socket.socket(socket.AF_UNIX) as server:
        try:
            server.connect(os.environ[PLACE])
            message = marshal.dumps((os.getcwd(), words, dict(os.environ)))
            socket.send_fds(server, [len(message).to_bytes(8, "little")], [0, 1, 2])
            server.sendall(message)
            reply = server.makefile()
            copy = int(reply.readline())
        except (KeyError, OSError, ValueError):
            os.execv(sys.executable, [sys.executable, "-m", "dpd", *words])
        # A terminal sends its signals to all, so to the copy as well.
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        signal.signal(signal.SIGTERM, lambda number, frame: os.kill(copy, number))
        sys.exit(int(reply.readline() or 1))


def serve(path):
    """Make copies until Snakemake, which holds the other end of the standard input, has ended."""
    import gc
    import select
    import shutil
    from importlib import import_module
    from pathlib import Path

    folder = Path(__file__).parents[1] / "src"

    def sources():
        return {file: file.stat().st_mtime_ns for file in folder.rglob("*.py")}

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # no copy is waited for here
    known = sources()
    for module in MODULES:
        import_module(module)
    gc.freeze()  # or looking for garbage would write to pages that copies share
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(path)
        listener.listen()
        while sys.stdin not in select.select([listener, sys.stdin], [], [])[0]:
            connection, _ = listener.accept()
            if sources() != known:  # a copy would be of the former ones
                break
            if os.fork() == 0:
                listener.close()
                _do(connection)
            connection.close()
    shutil.rmtree(os.path.dirname(path))


def _do(connection):
    """Do a command in a copy of this copy, tell its number, and in the end its exit code."""
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    size, streams, _, _ = socket.recv_fds(connection, 8, 3)
    with connection.makefile("rb") as sent:
        where, words, environment = marshal.loads(sent.read(int.from_bytes(size, "little")))
    copy = os.fork()
    if copy == 0:
        from dpd.__main__ import command

        signal.signal(signal.SIGINT, signal.default_int_handler)
        for number, stream in enumerate(streams):
            os.dup2(stream, number)
        sys.stdin, sys.stdout = os.fdopen(0, closefd=False), os.fdopen(1, "w", closefd=False)
        sys.stderr = os.fdopen(2, "w", 1, closefd=False)
        os.chdir(where)
        os.environ.update(environment)
        sys.argv[1:] = words
        command()
    for stream in (0, 1, 2, *streams):  # or who reads them would wait for this one
        os.close(stream)
    connection.sendall(b"%d\n" % copy)
    code = os.waitstatus_to_exitcode(os.waitpid(copy, 0)[1])
    connection.sendall(b"%d\n" % (code if code >= 0 else 128 - code))
    os._exit(0)


if __name__ == "__main__":
    if sys.argv[1] == "--serve":
        serve(sys.argv[2])
    else:
        call(sys.argv[1:])
