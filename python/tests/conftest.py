"""The installed package, and clusters of separate processes on loopback addresses."""

import os
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


def program():
    """`hdrm-fmu` of the same build."""
    found = os.environ.get("HDRM_FMU", str(ROOT / "target/release/hdrm-fmu"))
    assert os.access(found, os.X_OK), f"{found}: build it by `cargo xtask hdrm-fmu`, or name it in HDRM_FMU"
    return found


def free_port():
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


class Cluster:
    """A scheduler and workers, each a process; ends those that it started."""

    def __init__(self):
        self.address = f"tcp://127.0.0.1:{free_port()}"
        self.workers = []
        self.start_scheduler()

    def _start(self, *arguments, environment=None):
        command = [sys.executable, "-m", "dask", *arguments]
        return subprocess.Popen(command, env={**os.environ, **(environment or {})}, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def start_scheduler(self):
        host, port = self.address.removeprefix("tcp://").split(":")
        self.scheduler = self._start("scheduler", "--host", host, "--port", port, "--no-dashboard")

    def start_workers(self, count, environment=None):
        options = ("--nthreads", "1", "--no-nanny", "--no-dashboard", "--host", "127.0.0.1", "--death-timeout", "60")
        self.workers += [self._start("worker", self.address, *options, environment=environment) for _ in range(count)]

    def client(self):
        from distributed import Client

        deadline = time.monotonic() + 120
        while True:
            try:
                return Client(self.address, timeout=20)
            except OSError:
                if time.monotonic() > deadline:
                    raise

    def close(self):
        for process in (*self.workers, self.scheduler):
            process.kill()
            process.wait()


@pytest.fixture
def cluster():
    made = Cluster()
    yield made
    made.close()


@pytest.fixture(scope="module")
def two_workers():
    """A client of two workers."""
    made = Cluster()
    made.start_workers(2)
    with made.client() as client:
        client.wait_for_workers(2, timeout=120)
        yield client
    made.close()
