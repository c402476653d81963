"""How a command ends that does not end by itself: terminated, or by a stranger's `sys.exit`; and where it may write."""

import os
import signal
import subprocess
import sys
import time

import pytest


@pytest.mark.slow
def test_a_terminated_command_takes_its_workers_with_it(tmp_path):
    """Standard error closes only when no worker holds it any more."""
    out = tmp_path / "set"
    words = ["generate", "fvsight-press", "-o", out, "--samples", "162", "--jobs", "2"]
    child = subprocess.Popen([sys.executable, "-m", "vtbench", *words], stderr=subprocess.PIPE, text=True)
    while not any(out.glob("shard-*.parquet")):
        assert child.poll() is None
        time.sleep(0.05)
    child.terminate()
    _, told = child.communicate(timeout=30)
    assert child.returncode == 143
    assert told.splitlines()[-1] == "vtbench: terminated; the same command goes on from the last whole shard"


def test_sigterm_is_an_exit_code_and_leaves_the_handler_as_it_was(vtbench, monkeypatch):
    before = signal.getsignal(signal.SIGTERM)
    monkeypatch.setattr("vtbench.commands.env.run", lambda args: os.kill(os.getpid(), signal.SIGTERM))
    answer = vtbench("env")
    assert (answer.code, answer.err) == (143, "vtbench: terminated; nothing was left half done\n")
    assert signal.getsignal(signal.SIGTERM) is before


def in_compiled_code(*_):
    """A press during which SIGTERM comes while compiled code takes its arguments: what numba's dispatcher raises."""
    try:
        os.kill(os.getpid(), signal.SIGTERM)
    except KeyboardInterrupt as signalled:
        raise SystemError("CPUDispatcher returned a result with an exception set") from signalled


def test_sigterm_inside_compiled_code_is_no_failure_of_a_sample(vtbench, monkeypatch, tmp_path):
    monkeypatch.setattr("sensors.press.simulate", in_compiled_code)
    answer = vtbench("generate", "fvsight-press", "-o", tmp_path / "set", "--samples", "1")
    assert answer.code == 143
    assert answer.err.endswith("vtbench: terminated; the same command goes on from the last whole shard\n")


def test_sigterm_inside_compiled_code_ends_any_command_and_any_cell(vtbench, monkeypatch):
    from vtbench.run.executor import attempt

    monkeypatch.setattr("vtbench.commands.env.run", in_compiled_code)
    assert vtbench("env").code == 143

    class Cell:
        key, timeout_s, evaluate = "cell", 60.0, staticmethod(in_compiled_code)

    monkeypatch.setattr("vtbench.commands.env.run", lambda args: attempt(Cell()))
    assert vtbench("env").code == 143


def test_a_system_error_of_its_own_is_a_failure_of_its_sample(tmp_path):
    from vtbench.data.shards import SampleError, naming_sample

    with pytest.raises(SampleError, match="set, sample 3: SystemError: broken"), naming_sample("set", 3):
        raise SystemError("broken")


@pytest.mark.parametrize("code", [0, None, 3, "bye"])
def test_a_strangers_exit_is_no_success(vtbench, monkeypatch, code):
    monkeypatch.setattr("vtbench.commands.env.run", lambda args: sys.exit(code))
    answer = vtbench("env")
    assert answer.code == 70
    assert f"something called sys.exit({code!r}) in the middle of the work" in answer.err


@pytest.mark.parametrize("empty", ["", " "])
@pytest.mark.parametrize("words", [["generate", "no-scene"], ["run", "no-suite"], ["import", "x"], ["board", "x"]])
def test_an_empty_folder_is_not_the_current_one(refused, monkeypatch, tmp_path, words, empty):
    monkeypatch.chdir(tmp_path)
    assert f"expected a folder, got {empty!r}; the current one is '.'" in refused(*words, "-o", empty)
    assert not any(tmp_path.iterdir())
