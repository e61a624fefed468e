"""A command as a child process: what it printed, and what it cost."""

import os
import subprocess
import tempfile
import time
from dataclasses import dataclass

# One thread for the libraries that would otherwise start as many as there are cores.
ONE_THREAD = {name: "1" for name in ["OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"]}


class Failed(Exception):
    """A command that did not end well."""


@dataclass
class Measured:
    """What a child printed, its CPU seconds (user and system, its own children too), wall seconds and peak memory, MB."""

    output: str
    cpu_s: float
    wall_s: float
    peak_mb: float


def run(command):
    """Run a command to its end, one thread for each library; only this child is accounted, not what ran before."""
    with tempfile.TemporaryFile("w+") as output, tempfile.TemporaryFile("w+") as errors:
        start = time.perf_counter()
        words = [str(word) for word in command]
        child = subprocess.Popen(words, env=os.environ | ONE_THREAD, stdout=output, stderr=errors)
        _, status, usage = os.wait4(child.pid, 0)
        wall = time.perf_counter() - start
        child.returncode = os.waitstatus_to_exitcode(status)  # or Popen would wait for it again
        said, complaint = (text_of(file) for file in (output, errors))
    if child.returncode != 0:
        raise Failed(f"{' '.join(map(str, command))}: ended with {child.returncode}\n{complaint or said}")
    return Measured(said, usage.ru_utime + usage.ru_stime, wall, usage.ru_maxrss / 1024)


def text_of(file):
    """Everything in a file, without the empty lines at its ends."""
    file.seek(0)
    return file.read().strip()
