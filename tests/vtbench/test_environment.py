import json
import os
import re
import subprocess
import sys

import pytest

from vtbench import environment


def test_the_description_is_plain_json():
    found = environment.describe()
    assert json.loads(json.dumps(found)) == found
    assert {"version", "python", "packages", "machine", "fingerprint", "threads", "cache", "recordings"} <= set(found)


def test_packages_are_those_required_with_their_versions():
    found = environment.packages()
    assert {"numpy", "pydantic", "torch"} <= set(found)
    assert "pytest" not in found
    assert all(re.match(r"\d", version) for version in found.values())


def test_the_fingerprint_is_the_machines_and_not_the_moments():
    assert environment.fingerprint() == environment.fingerprint()
    assert re.fullmatch(r"[0-9a-f]{12}", environment.fingerprint())


def test_another_processor_has_another_fingerprint(monkeypatch):
    here = environment.fingerprint()
    monkeypatch.setattr(environment, "_processor", lambda: "another processor")
    assert environment.fingerprint() != here


def test_cores_are_those_this_process_may_use():
    assert 1 <= environment.usable_cores() <= (os.cpu_count() or 1)


def test_the_commit_is_a_hash_or_nothing():
    assert re.fullmatch(r"([0-9a-f]{40}(-dirty)?)?", environment.commit())


def test_recordings_name_the_command_that_brings_them(tmp_path, monkeypatch):
    monkeypatch.setenv("VTBENCH_CACHE", str(tmp_path))
    monkeypatch.delenv("VTBENCH_DATA", raising=False)
    found = environment.recordings()["fabricslide16"]
    assert found["path"] is None
    assert found["fetch"] == "vtbench fetch fabricslide16"
    (tmp_path / "mine" / "fabricslide16").mkdir(parents=True)
    monkeypatch.setenv("VTBENCH_DATA", str(tmp_path / "mine"))
    assert environment.recordings()["fabricslide16"]["path"] == str(tmp_path / "mine" / "fabricslide16")


@pytest.mark.parametrize("chosen", [None, "3"])
def test_threads_are_pinned_unless_chosen(monkeypatch, chosen):
    for name in environment.THREAD_VARIABLES:
        monkeypatch.setenv(name, "placeholder")  # so that what is set below is undone
        monkeypatch.delenv(name)
    if chosen:
        monkeypatch.setenv("OMP_NUM_THREADS", chosen)
    environment.pin_threads()
    expected = dict.fromkeys(environment.THREAD_VARIABLES, "1") | ({"OMP_NUM_THREADS": chosen} if chosen else {})
    assert environment.threads() == expected


def test_pinning_comes_before_numpy_and_limits_its_libraries():
    code = """
import sys
from vtbench import cli
assert "numpy" not in sys.modules
cli.main(["--version"])
assert "numpy" not in sys.modules
import numpy, threadpoolctl
numpy.ones((2, 2)) @ numpy.ones((2, 2))
print([pool["num_threads"] for pool in threadpoolctl.threadpool_info()])
"""
    free = {name: value for name, value in os.environ.items() if name not in environment.THREAD_VARIABLES}
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=free, check=True)
    assert set(json.loads(answer.stdout.splitlines()[-1])) <= {1}
