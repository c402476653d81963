"""A cluster gives the bytes of one process, and loses nothing when a worker is killed on the way."""

import contextlib
import os
import shutil
import socket
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from vtbench.run.executor import OutOfTimeError, _limit
from vtbench.scheduling import connect

ROOT = Path(__file__).resolve().parents[2]
CODE = ("vtbench", "sensors", "fusion", "slip", "leaderboard", "configs", "tests")

GENERATE = """
from tests.vtbench.data import fakes
from vtbench.data import write_dataset
from vtbench.scheduling import connect
with connect({address!r}) as cluster:
    write_dataset({out!r}, fakes.FakeScene(), seed=3, samples_per_shard=2, simulate=fakes.{simulate},
                  describe=fakes.describe, cluster=cluster)
"""
RUN = """
from tests.vtbench.run import small
from vtbench.run import run_suite
from vtbench.scheduling import connect
own = {{"own": small.own("Nearest")}}
with connect({address!r}) as cluster:
    summary = run_suite(small.suite({data!r}, methods=("knn", "svm", "ksc", "own"), own_methods=own), {out!r},
                        cluster=cluster, progress=False)
    assert summary.failed == summary.timeout == 0, [r.status for r in summary.records]
"""
PRESSES = "from tests.vtbench.run import small; small.write({data!r})"


def free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


@contextlib.contextmanager
def ended(*processes):
    try:
        yield
    finally:
        for process in processes:
            process.kill()
            process.wait()


class Place:
    """A copy of the code, which nobody edits while processes run it."""

    def __init__(self, root):
        self.root = root
        self.environment = {**os.environ, "PYTHONPATH": str(root), "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
        for name in CODE:
            shutil.copytree(ROOT / name, root / name)

    def start(self, *words, **more):
        return subprocess.Popen([sys.executable, *words], cwd=self.root, env=self.environment, **more)

    def dask(self, *words):
        return self.start("-m", "dask", *words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def worker(self, address):
        return self.dask("worker", address, "--no-nanny", "--nthreads", "1", "--no-dashboard")

    def client(self, code, **values):
        return self.start("-c", code.format(**values), stderr=subprocess.PIPE)


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    return Place(tmp_path_factory.mktemp("code"))


@pytest.fixture(scope="module")
def address(place):
    address = f"tcp://127.0.0.1:{free_port()}"
    scheduler = place.dask("scheduler", "--host", "127.0.0.1", "--port", address.rpartition(":")[2], "--no-dashboard")
    with ended(scheduler):
        yield address


def finish(process):
    _, err = process.communicate(timeout=120)
    assert process.returncode == 0, err.decode()[-2000:]


def kill_when(there, process, worker):
    """Let a worker die when `there()` says that the work is on its way; then wait until the work is done."""
    while not there():
        assert process.poll() is None, process.stderr.read().decode()[-2000:]
        time.sleep(0.01)
    worker.kill()
    assert process.poll() is None
    finish(process)


def contents(folder):
    return {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def predictions(out):
    return {path.parent.name: path.read_bytes() for path in out.glob("runs/*/predictions.npz")}


@pytest.mark.slow
def test_a_killed_worker_loses_nothing_and_changes_no_byte(place, address, tmp_path):
    alone, out, data = tmp_path / "alone", tmp_path / "set", tmp_path / "presses"
    finish(place.client(GENERATE, address=None, out=str(alone), simulate="simulate"))
    finish(place.client(PRESSES, data=str(data)))
    first, second, third = (place.worker(address) for _ in range(3))
    with ended(first, second, third):
        work = place.client(GENERATE, address=address, out=str(out), simulate="simulate_slowly")
        kill_when(lambda: any(out.glob("shard-*.parquet")), work, first)
        assert contents(out) == contents(alone)

        work = place.client(RUN, address=address, data=str(data), out=str(tmp_path / "run"))
        kill_when(lambda: predictions(tmp_path / "run"), work, second)
    finish(place.client(RUN, address=None, data=str(data), out=str(tmp_path / "run-alone")))
    assert len(predictions(tmp_path / "run")) == 8
    assert predictions(tmp_path / "run") == predictions(tmp_path / "run-alone")


@pytest.mark.slow
def test_a_worker_of_another_version_is_refused(place, address, tmp_path):
    other = tmp_path / "other"
    other.mkdir()
    changed = Place(other)
    with (other / "sensors/press.py").open("a") as file:
        file.write("# changed\n")
    with ended(changed.worker(address)), pytest.raises(ValueError, match="source of vtbench is"), connect(address):
        pass


@pytest.mark.parametrize("address", ["127.0.0.1:8786", "http://127.0.0.1:8786", "tcp://host", "tcp://a b:1", ""])
def test_an_address_that_is_none_is_said(address):
    with pytest.raises(ValueError, match=r"expected an address such as tcp://127.0.0.1:8786"), connect(address):
        pass


def test_without_an_address_there_is_no_cluster():
    with connect(None) as cluster:
        assert cluster is None


def test_a_scheduler_that_is_not_there_is_said_by_the_command(refused, tmp_path, monkeypatch):
    monkeypatch.setattr("vtbench.scheduling.CONNECT_S", 0.5)
    place = f"tcp://127.0.0.1:{free_port()}"
    line = refused("generate", "fvsight-press", "--samples", "2", "-o", tmp_path / "set", "--scheduler", place)
    assert line.startswith(f"{place}: no Dask scheduler answers there")
    assert not (tmp_path / "set").exists()


def test_without_dask_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(ValueError, match=r"needs Dask .*vtbench\[cluster\]"), connect("tcp://127.0.0.1:1"):
        pass


def test_a_thread_that_hears_no_alarm_is_limited_too():
    def endless():
        with _limit(0.05):
            while True:
                pass

    with ThreadPoolExecutor(1) as pool:
        with pytest.raises(OutOfTimeError):
            pool.submit(endless).result()
        assert pool.submit(lambda: sum(range(100_000))).result() == 4999950000
