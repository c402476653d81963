"""Starts the locked process, listens to it until a deadline, and ends it; what it says is checked, not believed."""

from __future__ import annotations

import json
import os
import select
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from leaderboard.record import State
from leaderboard.submission import Latency
from vtbench.onnx_eval.channel import BrokenMessageError, Reader
from vtbench.onnx_eval.contract import Contract, Port

LARGEST_MODEL_MB = 512
_HEADERS_BYTES = 200_000
_START_GRACE_S = 20.0
"""What starting Python and ONNX Runtime may take on a busy machine; the time limit is for the model."""
_ROOT = str(Path(__file__).resolve().parent.parent.parent)
_PROGRAM = "import sys; sys.path.insert(0, sys.argv.pop(1)); from vtbench.onnx_eval.child import main; main()"
_SIGNALS = {signal.SIGXCPU: "used up its processor time", signal.SIGKILL: "was killed by the system (memory?)"}


@dataclass(frozen=True)
class Limits:
    """What a model may use: seconds on the clock, and megabytes beside the runtime and the inputs."""

    time_s: float = 300.0
    memory_mb: int = 2048


class Told(BaseModel):
    """What the locked process said of itself and the model, checked for type and size."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    inputs: tuple[str, ...] = Field(default=(), max_length=16)
    parameters: int | None = Field(default=None, ge=0)
    nodes: int | None = Field(default=None, ge=0)
    load_s: float | None = Field(default=None, ge=0)
    peak_rss_mb: float | None = Field(default=None, ge=0)
    runtime: str = Field(default="", max_length=60)
    protections: dict[str, str] = Field(default_factory=dict, max_length=12)
    fitted_on: dict[str, Annotated[str, Field(max_length=64)]] = Field(default_factory=dict, max_length=5)


@dataclass
class Answer:
    """What came back: the state and a one-line reason, what was told, and the arrays as far as it got.

    `timed` holds scores by batch size; every array is (rows, width) float32, not yet looked at.
    """

    state: State = "ok"
    reason: str = ""
    kind: str = ""
    told: Told = field(default_factory=Told)
    scores: NDArray[np.float32] | None = None
    recheck: NDArray[np.float32] | None = None
    timed: dict[int, NDArray[np.float32]] = field(default_factory=dict)
    latency: tuple[Latency, ...] = ()


@dataclass(frozen=True)
class Job:
    """What to do with a model: batches of samples, the same again in another order, and calls to be timed."""

    inputs: tuple[dict[str, Any], ...] = ()
    batches: Sequence[Sequence[int]] = ()
    recheck: Sequence[Sequence[int]] = ()
    timing: Sequence[Mapping[str, Any]] = ()
    width: int = 0
    rows: int = 0
    """Rows of scores that all messages may hold together."""


@contextmanager
def private_folder(model: bytes) -> Iterator[Path]:
    """A folder of the model's own, with the model in it, gone afterwards."""
    with tempfile.TemporaryDirectory(prefix="vtbench-") as name:
        folder = Path(name)
        (folder / "model.onnx").write_bytes(model)
        yield folder


def run(folder: Path, contract: Contract, job: Job, limits: Limits) -> Answer:
    """Do a job with the model in `folder`; every way in which that can end is an answer."""
    width = max(job.width, 1)
    written = {
        "inputs": job.inputs,
        "batches": job.batches,
        "recheck": job.recheck,
        "timing": job.timing,
        "memory_mb": limits.memory_mb,
        "time_s": limits.time_s,
        "offered": [_port(port) for port in contract.inputs],
        "output": {**_port(contract.output), "width": job.width},
    }
    (folder / "job.json").write_text(json.dumps(written))
    listener = _Listener(Reader(job.rows * width * 4 + _HEADERS_BYTES), width)
    ended = _listen(folder, listener, limits.time_s)
    return listener.answer(ended, limits)


class _Listener:
    """Collects messages into an answer."""

    def __init__(self, reader: Reader, width: int) -> None:
        self.reader = reader
        self.width = width
        self.stage = "starting"
        self.begun = 0.0
        self.done = False
        self._told: dict[str, Any] = {}
        self._found = Answer()

    def take(self, data: bytes) -> None:
        """Read what came; BrokenMessageError for what was not agreed."""
        try:
            for header, payload in self.reader.feed(data):
                self._take(header, payload)
        except BrokenMessageError:
            raise
        except (ValueError, KeyError, TypeError) as error:
            raise BrokenMessageError(f"it sent a message that was not agreed ({type(error).__name__})") from None

    def _take(self, header: dict[str, Any], payload: bytes) -> None:
        if "failed" in header:
            self._found.state, self._found.kind = "failed", str(header["failed"])[:20]
            self._found.reason, self.done = _safe(str(header["reason"])), True
        elif "stage" in header:
            self.stage, self.begun = _safe(str(header["stage"]))[:60], self.begun or time.monotonic()
            self.done = self.stage == "done"
            self._told |= {name: value for name, value in header.items() if name not in ("stage", "bytes")}
            self._found.told = Told.model_validate(self._told)
        else:
            self._take_array(header, payload)

    def _take_array(self, header: dict[str, Any], payload: bytes) -> None:
        values = np.frombuffer(payload, np.float32).reshape(-1, self.width)
        if "scores" in header:
            self._found.scores = values
        elif "recheck" in header:
            self._found.recheck = values
        else:
            latency = Latency.model_validate(header["latency"])
            self._found.timed[latency.batch] = values
            self._found.latency = (*self._found.latency, latency)

    def answer(self, ended: str | int, limits: Limits) -> Answer:
        """The answer, by what was heard and by how the process ended (a word of ours, or its exit code)."""
        found = self._found
        if found.state == "failed":
            found.reason = _explained(found.kind, found.reason, self.stage, limits)
        elif ended == "late":
            found.state = "timeout"
            found.reason = f"took longer than {limits.time_s:g} s (--time-limit) while {self.stage}"
        elif isinstance(ended, str):
            found.state, found.reason = "failed", f"stopped: {ended}"
        elif ended != 0:
            how = _ending(ended)
            found.state = "timeout" if ended == -signal.SIGXCPU else "failed"
            found.reason = f"its process {how} while {self.stage} (limits: {limits.time_s:g} s, {limits.memory_mb} MB)"
        return found


def _ending(code: int) -> str:
    if code > 0:
        return f"ended with code {code}"
    return _SIGNALS.get(signal.Signals(-code), f"died of {signal.Signals(-code).name}")


def _listen(folder: Path, listener: _Listener, time_s: float) -> str | int:
    """Run the process and hear it; returns its exit code, `late`, or what it did that was not agreed."""
    reading, writing = os.pipe()
    process = subprocess.Popen(
        [sys.executable, "-I", "-B", "-c", _handing_over(writing), _ROOT, str(folder)],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        cwd=folder,
        env={"LANG": "C.UTF-8", "HOME": str(folder), **_one_thread()},
        pass_fds=(writing,),
        start_new_session=True,
    )
    os.close(writing)
    started = time.monotonic()
    try:
        while True:
            deadline = listener.begun + time_s if listener.begun else started + time_s + _START_GRACE_S
            left = deadline - time.monotonic()
            if left <= 0:
                return "late"
            ready, _, _ = select.select([reading], [], [], min(left, 1.0))
            if not ready:
                continue
            data = os.read(reading, 2**20)
            if not data:
                return process.wait(max(left, 1.0))
            listener.take(data)
    except BrokenMessageError as error:
        return str(error)
    except subprocess.TimeoutExpired:
        return "late"
    finally:
        os.close(reading)
        _end(process)


def _handing_over(writing: int) -> str:
    """The program, with its end of the pipe where it looks for it."""
    return f"import os; os.dup2({writing}, 3); {writing} == 3 or os.close({writing}); {_PROGRAM}"


def _one_thread() -> dict[str, str]:
    from vtbench.environment import THREAD_VARIABLES

    return dict.fromkeys(THREAD_VARIABLES, "1")


def _end(process: subprocess.Popen[bytes]) -> None:
    """End the process and what it may have started; its session is its own."""
    if process.poll() is None:
        try:
            os.killpg(process.pid, signal.SIGKILL)
        except (ProcessLookupError, PermissionError):
            process.kill()
    process.wait()


def _explained(kind: str, reason: str, stage: str, limits: Limits) -> str:
    if kind == "memory":
        return f"asked for more memory than the {limits.memory_mb} MB it may use (--memory-limit) while {stage}"
    if kind == "contract":
        return reason
    return f"failed while {stage}: {reason}"


def _port(port: Port) -> dict[str, Any]:
    return {"name": port.name, "dtype": port.dtype, "shape": list(port.shape or ())}


def _safe(text: str) -> str:
    return "".join(letter if " " <= letter <= "~" else "?" for letter in text)[:1000]
