"""A Slurm cluster of one node on this machine, for tests and to try a profile.

    python tests/slurm/one_node.py start /tmp/cluster    in a new folder; it says what to export
    python tests/slurm/one_node.py stop /tmp/cluster     end all of it, jobs too

It needs Debian's packages slurm-wlm and munge, and no rights: all daemons belong to you. It leaves
alone any other Slurm of this machine.
"""

import argparse
import os
import re
import secrets
import shlex
import shutil
import socket
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import psutil

DAEMONS = ("munged", "slurmctld", "slurmd")
PATIENCE = 30.0  # s until daemons are up, or have ended
# Of the node, less if the machine has less; MiB. Each try of a job asks for 1000 more.
CPUS, MEMORY = 2, 20_000
MISSED = 10  # s after which a node that says nothing is down

CONFIGURATION = """\
ClusterName=one_node
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={controller}
SlurmdPort={node}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
SlurmUser={user}
SlurmdUser={user}
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
# Without control groups, which containers often lack.
ProctrackType=proctrack/linuxproc
TaskPlugin=task/affinity
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU_Memory
MpiDefault=none
SlurmdTimeout={missed}
ReturnToService=2
NodeName={host} NodeAddr=127.0.0.1 CPUs={cpus} RealMemory={memory}
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


def missing():
    """Programs that are not installed here."""
    return [name for name in (*DAEMONS, "sbatch", "squeue") if _program(name) is None]


def environment(folder):
    """Environment of commands that use the cluster."""
    return os.environ | _variables(Path(folder).resolve())


def _variables(folder):
    path = f"{folder / 'bin'}:{os.environ.get('PATH', '')}"
    return {"SLURM_CONF": str(folder / "slurm.conf"), "PATH": path}


def start(folder):
    """Start the cluster in an empty folder, wait until its node is idle; or exit and say why."""
    folder = Path(folder).resolve()
    if absent := missing():
        sys.exit(f"{', '.join(absent)}: not installed; on Debian: apt-get install slurm-wlm munge")
    if folder.exists() and any(folder.iterdir()):
        sys.exit(f"{folder}: is not empty; stop a cluster that is there, and name another folder")
    for name in ("state", "spool", "bin"):
        (folder / name).mkdir(parents=True)
    # Snakemake's executor calls srun in jobs without the variables of Slurm, SLURM_CONF among them.
    srun = folder / "bin" / "srun"
    srun.write_text(f'#!/bin/sh\nSLURM_CONF={folder}/slurm.conf exec {_program("srun")} "$@"\n')
    srun.chmod(0o755)
    key = folder / "munge.key"
    key.touch(mode=0o600)
    key.write_bytes(secrets.token_bytes(64))
    controller, node = _free_ports(2)
    text = CONFIGURATION.format(
        host=socket.gethostname().partition(".")[0], user=psutil.Process().username(),
        folder=folder, missed=MISSED,
        controller=controller, node=node, cpus=min(CPUS, os.cpu_count()),
        memory=min(MEMORY, psutil.virtual_memory().total // 2**20 * 9 // 10),
    )  # fmt: skip
    (folder / "slurm.conf").write_text(text)
    (folder / "cgroup.conf").write_text(f"CgroupPlugin={_cgroup_plugin()}\n")
    try:
        _run(folder, "munged", "--force", *(
            f"--{name}={folder / file}" for name, file in (
                ("key-file", "munge.key"), ("socket", "munge.socket"), ("pid-file", "munged.pid"),
                ("log-file", "munged.log"), ("seed-file", "munged.seed"),
            )
        ))  # fmt: skip
        _run(folder, "slurmctld", "-c")
        boot(folder)
    except BaseException:
        stop(folder)
        raise


def boot(folder):
    """Start the node, and wait until it can have jobs."""
    folder = Path(folder).resolve()
    _run(folder, "slurmd")
    _wait(lambda: state_of_node(folder) in ("idle", "mixed", "allocated"), folder, "slurmd")


def state_of_node(folder):
    """As sinfo has it, without the sign of a node that does not answer; empty if nobody knows."""
    done = subprocess.run(
        ["sinfo", "--noheader", "--format=%T"], env=environment(folder), capture_output=True,
        text=True, check=False,
    )  # fmt: skip
    return done.stdout.strip().rstrip("*")


def kill_node(folder):
    """End the node's daemon and all processes of its jobs at once, as a power cut would."""
    end = time.monotonic() + PATIENCE
    while left := _processes_of_node(Path(folder).resolve()):
        if time.monotonic() > end:
            sys.exit(f"processes {left} of the node could not be killed")
        for process in left:
            with suppress(psutil.NoSuchProcess):
                process.kill()
        psutil.wait_procs(left, 1)


def stop(folder):
    """End the cluster: jobs, daemons, and what is left of them. The folder stays, with its logs."""
    folder = Path(folder).resolve()
    kill_node(folder)
    for name in reversed(DAEMONS):
        with suppress(OSError, ValueError, psutil.Error):  # it is not there
            daemon = psutil.Process(int((folder / f"{name}.pid").read_text()))
            daemon.terminate()
            daemon.wait(PATIENCE)


def _program(name):
    return shutil.which(name, path=f"{os.environ.get('PATH', '')}:/usr/sbin:/usr/local/sbin")


def _cgroup_plugin():
    """Control groups are not used; how to say so depends on the version."""
    said = subprocess.run([_program("slurmd"), "-V"], capture_output=True, text=True, check=True)
    version = tuple(int(part) for part in re.findall(r"\d+", said.stdout)[:2])
    return "disabled" if version >= (23, 2) else "cgroup/v1"


def _free_ports(count):
    """Ports of this machine that nobody listens at."""
    sockets = [socket.create_server(("127.0.0.1", 0)) for _ in range(count)]
    ports = [each.getsockname()[1] for each in sockets]
    for each in sockets:
        each.close()
    return ports


def _run(folder, name, *arguments):
    """Start a daemon, which puts itself into the background."""
    with open(folder / f"{name}.out", "w") as out:
        done = subprocess.run(
            [_program(name), *arguments], env=environment(folder), stdin=subprocess.DEVNULL,
            stdout=out, stderr=out, check=False, start_new_session=True,
        )  # fmt: skip
    if done.returncode:
        sys.exit(f"{name} does not start: {(folder / f'{name}.out').read_text().strip()}")


def _wait(condition, folder, name):
    end = time.monotonic() + PATIENCE
    while not condition():
        if time.monotonic() > end:
            sys.exit(f"{name} is not up after {PATIENCE:g} s; see {folder / name}.log")
        time.sleep(0.2)


def _processes_of_node(folder):
    """Its daemon, and processes whose environment says that they are of its jobs."""
    found = []
    for process in psutil.process_iter(["name", "environ", "status"]):
        variables = process.info["environ"] or {}
        ours = variables.get("SLURM_CONF") == f"{folder}/slurm.conf"
        of_node = "SLURM_JOB_ID" in variables or process.info["name"] in ("slurmd", "slurmstepd")
        if ours and of_node and process.info["status"] != psutil.STATUS_ZOMBIE:
            found.append(process)
    return found


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    doing = {"start": start, "stop": stop}
    parser.add_argument("what", choices=doing)
    parser.add_argument("folder", type=Path)
    options = parser.parse_args()
    doing[options.what](options.folder)
    if options.what == "start":
        for name, value in _variables(options.folder.resolve()).items():
            print(f"export {name}={shlex.quote(value)}")
