"""Study on a SLURM of this machine: the array of `python -m ballistic_gel slurm`, dask-jobqueue, and no SLURM at all.

    apt-get install slurmctld slurmd slurm-client munge
    python python/bench/slurm.py        # as root; some seconds

Starts munge, a controller and a node in a folder that is removed with them, runs the study three times, and fails if
the tables differ. Needs the extra `dask`.
"""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import ballistic_gel as bg

STUDY = """
scene = "ball-bounce"
out = "array"
[set]
"scene.end_time" = 2e-4
"mesh.size" = 4e-3
[keys]
"projectile.velocity[3]" = [-2.0, -1.5, -1.0, -0.5, -0.25]
"""
TASKS = 3
JOBS = 2
# A node without control groups, whose jobs are told from their parent processes.
CONFIGURATION = """
ClusterName=local
SlurmctldHost={host}
SlurmUser=root
SlurmdUser=root
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
ReturnToService=2
NodeName={host} CPUs={cores} RealMemory=4096 State=UNKNOWN
PartitionName=local Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


def call(*command: str | Path, **options: str) -> str:
    """Run a command and return its output; end this one with its errors if it fails."""
    done = subprocess.run(command, capture_output=True, text=True, **options)
    if done.returncode != 0:
        raise SystemExit(f"{command[0]} failed: {done.stderr or done.stdout}")
    return done.stdout


@contextmanager
def local_slurm(folder: Path) -> Iterator[None]:
    """Give a SLURM of one node, this machine, with its files in a folder."""
    configuration = folder / "slurm.conf"
    host, cores = socket.gethostname().split(".")[0], os.cpu_count()
    configuration.write_text(CONFIGURATION.format(host=host, cores=cores, folder=folder))
    os.environ["SLURM_CONF"] = str(configuration)
    for name in ("state", "spool"):
        (folder / name).mkdir()
    Path("/run/munge").mkdir(exist_ok=True)
    call("chown", "munge:", "/run/munge")
    call("su", "-s", "/bin/sh", "munge", "-c", "/usr/sbin/munged --force")
    started = [Path("/run/munge/munged.pid")]
    try:
        for name in ("slurmctld", "slurmd"):
            call(f"/usr/sbin/{name}")
            started.append(folder / f"{name}.pid")
        await_output("idle", "sinfo", "--noheader", "--format=%T")
        yield
    finally:
        for pid_file in reversed(started):
            stop(pid_file)


def stop(pid_file: Path) -> None:
    """End a daemon and wait until it has removed its file."""
    if pid_file.exists():
        os.kill(int(pid_file.read_text()), signal.SIGTERM)
    deadline = time.monotonic() + 20.0
    while pid_file.exists() and time.monotonic() < deadline:
        time.sleep(0.1)


def await_output(wanted: str, *command: str) -> None:
    """Wait until a command prints the wanted text."""
    deadline = time.monotonic() + 120.0
    while call(*command).strip() != wanted:
        if time.monotonic() > deadline:
            raise SystemExit(f"{' '.join(command)} does not print {wanted!r}: {call(*command)}")
        time.sleep(0.2)


def run_array(study: Path) -> Path:
    """Submit the array of a study, and return the folder of its rows once no job is left."""
    script = call(sys.executable, "-m", "ballistic_gel", "slurm", study, "--tasks", str(TASKS))
    print(call("sbatch", f"--output={study.parent}/%A-%a.log", input=script).strip())
    await_output("", "squeue", "--noheader")
    return study.parent / "array"


def run_by_dask(study: bg.Study, folder: Path) -> Path:
    """Run a study by jobs of dask-jobqueue, and return the folder of its rows."""
    import dask_jobqueue
    import distributed

    options = {"cores": 1, "memory": "1GB", "log_directory": str(folder / "logs"), "interface": "lo"}
    scheduler = {"dashboard_address": None}
    with dask_jobqueue.SLURMCluster(**options, scheduler_options=scheduler) as cluster:
        cluster.scale(jobs=JOBS)
        with distributed.Client(cluster) as client:
            client.wait_for_workers(JOBS, timeout=120)
            bg.sweep(study.scene(), study.samples(), folder / "dask", client=client, progress=False)
    return folder / "dask"


def main() -> int:
    """Run the study three times, and return the exit status."""
    with tempfile.TemporaryDirectory(prefix="ballistic-gel-") as name:
        folder = Path(name)
        (folder / "my study.toml").write_text(STUDY)
        study = bg.Study.load(folder / "my study.toml")
        with local_slurm(folder):
            folders = [run_array(study.path), run_by_dask(study, folder)]
        bg.sweep(study.scene(), study.samples(), folder / "alone", workers=1, progress=False)
        tables = [(made / "results.csv").read_bytes() for made in (*folders, folder / "alone")]
    equal = len(set(tables)) == 1
    count = tables[0].count(b"\n") - 1
    print(f"{count} shots by an array of {TASKS} tasks, by {JOBS} jobs of dask-jobqueue, and alone: tables", end=" ")
    print("equal" if equal else "DIFFERENT")
    return 0 if equal else 1


if __name__ == "__main__":
    sys.exit(main())
