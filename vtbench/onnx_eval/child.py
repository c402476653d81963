"""The locked process: reads the job, locks itself, opens the model, runs it, sends what it gave.

Everything that comes from a model happens here and nowhere else. It knows the samples in a shuffled order and by no
name; the truth never enters.
"""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NoReturn

from vtbench.onnx_eval import channel, protect

RESULT_HANDLE = 3
_MEMORY_WORDS = ("bad_alloc", "failed to allocate", "bfcarena", "not enough memory", "out of memory", "cannot allocate")
_MOST_REASON = 900


def main() -> NoReturn:
    """Do the job in the folder given as the only argument; the exit code is 0 when a result or a reason was sent."""
    held = protect.isolate()
    job = json.loads(Path(sys.argv[1], "job.json").read_text())
    try:
        _work(Path(sys.argv[1]), job, held)
    except MemoryError:
        _fail("memory", "")
    except _ModelError as error:
        _fail(error.kind, str(error))
    except Exception as error:
        kind = "output" if type(error).__name__ == "OutputError" else "run"
        _fail(kind, str(error) if kind == "output" else f"{type(error).__name__}: {error}")
    os._exit(0)


class _ModelError(Exception):
    def __init__(self, kind: str, reason: str) -> None:
        super().__init__(reason)
        self.kind = kind


def _fail(kind: str, reason: str) -> NoReturn:
    line = " ".join(reason.split())[:_MOST_REASON]
    channel.send(RESULT_HANDLE, {"failed": kind, "reason": "".join(c if " " <= c <= "~" else "?" for c in line)})
    os._exit(0)


def _stage(name: str, **more: Any) -> None:
    channel.send(RESULT_HANDLE, {"stage": name, **more})


def _work(folder: Path, job: dict[str, Any], held: dict[str, str]) -> None:
    import onnx  # noqa: F401  # loaded before files close
    import onnxruntime

    from vtbench.onnx_eval import stream
    from vtbench.onnx_eval.batches import Inputs, run_all, time_calls
    from vtbench.onnx_eval.contract import Contract, Port, breaches
    from vtbench.onnx_eval.inspect_graph import read

    inputs = Inputs.open(folder, job["inputs"])
    content = (folder / "model.onnx").read_bytes()
    memory = os.open("/proc/self/status", os.O_RDONLY) if os.path.exists("/proc/self/status") else -1
    held |= protect.limit(job["memory_mb"], job["time_s"])
    held |= protect.close_files()
    _stage("reading the model", protections=held, runtime=f"ONNX Runtime {onnxruntime.__version__}")

    contract = Contract(
        tuple(Port(each["name"], each["dtype"], tuple(each["shape"])) for each in job["offered"]),
        Port(job["output"]["name"], job["output"]["dtype"], tuple(job["output"]["shape"])),
    )
    try:
        graph, refused = read(content)
    except ValueError as error:
        raise _ModelError("contract", str(error)) from None
    streamed = stream.is_stream(graph.inputs)
    problems = refused + (stream.breaches if streamed else breaches)(contract, graph.inputs, graph.outputs)
    if problems:
        raise _ModelError("contract", "; ".join(problems))
    names = [stream.SERIES] if streamed else [port.name for port in graph.inputs]
    _stage("loading the model", inputs=names, parameters=graph.parameters, nodes=graph.nodes, fitted_on=graph.fitted_on)
    if not job["batches"]:
        return
    started = time.perf_counter()
    run = _load(content)
    del content
    output = job["output"]["name"]
    call = stream.over_sequences(run, graph.inputs) if streamed else lambda given: run([output], given)[0]
    _stage("predicting", load_s=time.perf_counter() - started)

    width = job["output"]["width"]
    first = inputs.take(names, job["batches"][0][:1])
    started = time.perf_counter()
    call(first)
    first_ms = 1e3 * (time.perf_counter() - started)
    scores = run_all(call, inputs, names, job["batches"], width)
    channel.send(RESULT_HANDLE, {"scores": len(scores)}, scores.tobytes())
    _stage("predicting again in another order")
    again = run_all(call, inputs, names, job["recheck"], width)
    channel.send(RESULT_HANDLE, {"recheck": len(again)}, again.tobytes())
    _stage("timing")
    for plan in job["timing"]:
        try:
            latency, timed = time_calls(call, inputs, names, plan["batches"], plan["budget_s"], width)
        except _ModelError as error:
            if error.kind == "memory" and plan["batch"] > 1:
                continue  # a batch that no task asks for: its time is unknown, the scores stand
            raise
        if plan["batch"] == 1:
            latency["first_ms"] = first_ms
        channel.send(RESULT_HANDLE, {"timed": plan["batch"], "latency": latency}, timed.tobytes())
    _stage("done", peak_rss_mb=_peak_mb(memory))


def _load(content: bytes) -> Callable[[list[str], Mapping[str, Any]], list[Any]]:
    """The model as a function of output names and inputs; ONNX Runtime on one thread, what it throws in plain words."""
    import onnxruntime

    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    options.log_severity_level = 4
    try:
        session = onnxruntime.InferenceSession(content, options, providers=["CPUExecutionProvider"])
    except Exception as error:
        raise _plain("load", error) from None

    def run(outputs: list[str], inputs: Mapping[str, Any]) -> list[Any]:
        try:
            return list(session.run(outputs, inputs))
        except Exception as error:
            raise _plain("run", error) from None

    return run


def _plain(kind: str, error: Exception) -> _ModelError:
    text = str(error).replace("[ONNXRuntimeError] : ", "")
    if isinstance(error, MemoryError) or any(word in text.lower() for word in _MEMORY_WORDS):
        return _ModelError("memory", text)
    return _ModelError(kind, text)


def _peak_mb(handle: int) -> float | None:
    """Most memory that was resident in this process, MB; its own, unlike what getrusage inherits from the parent."""
    if handle < 0:
        return None
    for line in os.pread(handle, 8192, 0).decode().splitlines():
        if line.startswith("VmHWM:"):
            return round(int(line.split()[1]) / 1024, 1)
    return None


if __name__ == "__main__":
    main()
