"""A slip graph of one sample and its states, run over whole sequences as a robot would run it.

Inputs `force` (1, taxels) float32 and every `state_*`, of a fixed shape; outputs `slip_score` (1, 1) float32 and every
`state_*_out`, which is fed back as `state_*`. A sequence begins with states of zeros.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from vtbench.onnx_eval.contract import Contract, Port

PREFIX, SUFFIX = "state_", "_out"
SAMPLE, SERIES, SCORE = "force", "force_series", "slip_score"
STATES = ("float32", "float64", "int64", "int32", "bool")
MOST_STATE = 2**24
"""Numbers that the states of a graph may hold together."""

Run = Callable[[list[str], Mapping[str, Any]], list[Any]]


def is_stream(inputs: Sequence[Port]) -> bool:
    """Whether a graph carries states from one sample to the next."""
    return any(port.name.startswith(PREFIX) for port in inputs)


def breaches(contract: Contract, inputs: Sequence[Port], outputs: Sequence[Port]) -> list[str]:
    """Return one line for each thing that keeps a graph with states from being run over the sequences of a task."""
    series = next((port for port in contract.inputs if port.name == SERIES), None)
    if contract.output.name != SCORE or series is None or series.shape is None:
        return ["a graph that carries states (inputs state_*) is scored by slip tasks only; export one without states"]
    found = []
    taken = {port.name: port for port in inputs}
    given = {port.name: port for port in outputs}
    taxels = series.shape[-1]
    if SAMPLE not in taken:
        found.append(f"a graph with states takes one sample a call: input {SAMPLE!r} (1, taxels) is missing")
    elif not _is(taken[SAMPLE], "float32", (1, taxels)):
        found.append(f"input {SAMPLE!r}: expected {Port(SAMPLE, 'float32', (1, taxels))}, found {taken[SAMPLE]}")
    if SCORE not in given or not _is(given[SCORE], "float32", (1, 1)):
        there = given.get(SCORE, "none")
        found.append(f"output {SCORE!r}: expected {Port(SCORE, 'float32', (1, 1))} of a graph with states, got {there}")
    states = [port for port in inputs if port.name.startswith(PREFIX)]
    strange = [port.name for port in inputs if port.name != SAMPLE and port not in states]
    if strange:
        found.append(
            f"input {strange[0]!r}: expected {SAMPLE} and {PREFIX}* alone in a graph with states; leave it out"
        )
    for port in states:
        if not _sizes(port) or port.dtype not in STATES:
            found.append(f"input {port.name!r}: expected a fixed shape of {', '.join(STATES)}, found {port}")
        elif (back := given.get(port.name + SUFFIX)) is None or not _is(back, port.dtype, port.shape or ()):
            found.append(f"output {port.name + SUFFIX!r}: expected it like {port}, found {back or 'none'}")
    if not found and sum(int(np.prod(_sizes(port))) for port in states) > MOST_STATE:
        found.append(f"the states hold more than {MOST_STATE} numbers together")
    return found


def over_sequences(run: Run, inputs: Sequence[Port]) -> Callable[[dict[str, Any]], Any]:
    """The graph as a function of `force_series` (N, T, taxels), giving scores (N, T)."""
    states = [port for port in inputs if port.name.startswith(PREFIX)]
    names = [SCORE, *(port.name + SUFFIX for port in states)]

    def call(given: dict[str, Any]) -> Any:
        sequences = given[SERIES]
        scores = np.empty(sequences.shape[:2], np.float32)
        for row, sequence in enumerate(sequences):
            fed: dict[str, Any] = {port.name: np.zeros(_sizes(port), port.dtype) for port in states}
            for at in range(len(sequence)):
                fed[SAMPLE] = sequence[at : at + 1]
                answer = run(names, fed)
                scores[row, at] = _score(answer[0])
                fed = dict(zip((port.name for port in states), answer[1:], strict=True))
        return scores

    return call


def _score(value: Any) -> Any:
    from vtbench.onnx_eval.batches import OutputError

    if not isinstance(value, np.ndarray) or value.shape != (1, 1) or value.dtype != np.float32:
        raise OutputError(f"the output is {getattr(value, 'dtype', type(value).__name__)}, expected float32 (1, 1)")
    return value[0, 0]


def _is(port: Port, dtype: str, shape: Sequence[Any]) -> bool:
    """Whether a port has this type, and this shape as far as both sides say."""
    if port.dtype != dtype or port.shape is None or len(port.shape) != len(shape):
        return False
    return all(not isinstance(need, int) or have == need for have, need in zip(port.shape, shape, strict=True))


def _sizes(port: Port) -> tuple[int, ...]:
    """The shape, where every axis of it is fixed; else nothing."""
    return tuple(axis for axis in port.shape or () if isinstance(axis, int)) if _fixed(port) else ()


def _fixed(port: Port) -> bool:
    return bool(port.shape) and all(isinstance(axis, int) for axis in port.shape or ())
