"""What a model must take and give for a task, and what of that a graph does not.

Inputs, of which a model takes those it wants: `image` and `image_rest` (N, H, W, 3) uint8, `force` (N, taxels) float32,
`force_series` (N, T, taxels) float32. Output: `scores` (N, classes) in the task's class order, of a slip task
`slip_score` (N, T). Forces are newtons where the recordings are.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from vtbench.registry import close_matches

Axis = int | str | None
"""A fixed length, the name of a free one, or None where a graph does not say."""


@dataclass(frozen=True)
class Port:
    """One input or output: its name, element type and shape; None where a graph leaves the shape open."""

    name: str
    dtype: str
    shape: tuple[Axis, ...] | None

    def __str__(self) -> str:
        if self.shape is None:
            return f"{self.name} of {self.dtype}"
        return f"{self.name} ({', '.join('?' if axis is None else str(axis) for axis in self.shape)}) {self.dtype}"


@dataclass(frozen=True)
class Contract:
    """Inputs that a task offers and the output that it scores; axes given as text are free, None is not yet known."""

    inputs: tuple[Port, ...]
    output: Port

    def taken(self, names: Sequence[str]) -> tuple[Port, ...]:
        """The offered inputs among `names`."""
        return tuple(port for port in self.inputs if port.name in names)


def breaches(contract: Contract, inputs: Sequence[Port], outputs: Sequence[Port]) -> list[str]:
    """Return one line for each thing that a graph's inputs and outputs do not keep of the contract."""
    offered = {port.name: port for port in contract.inputs}
    found = [_unknown_input(port, offered) for port in inputs if port.name not in offered]
    known = [port for port in inputs if port.name in offered]
    if not known and not found:
        found.append(f"no input: expected at least one of {_list(contract.inputs)}")
    for port in known:
        found += _differences("input", offered[port.name], port)
    given = {port.name: port for port in outputs}
    wanted = contract.output
    if wanted.name not in given:
        found.append(_missing_output(wanted, list(given)))
    else:
        found += _differences("output", wanted, given[wanted.name])
    return found


def _unknown_input(port: Port, offered: Mapping[str, Port]) -> str:
    if port.name in ("frames", "frame_samples"):
        return f"input {port.name!r}: models are offered no frames of slip trials; export a detector of forces alone"
    near = close_matches(port.name, offered)
    way = f"rename it to {near[0]!r}" if near else "rename it or make it a constant of the graph"
    return f"input {port.name!r}: expected names among {', '.join(offered)}; {way}"


def _missing_output(wanted: Port, given: list[str]) -> str:
    there = ", ".join(map(repr, given[:6])) or "none"
    return f"output {wanted.name!r} is missing: expected {wanted}, found {there}; rename the output that holds it"


def _differences(what: str, wanted: Port, found: Port) -> list[str]:
    lines = []
    if found.dtype != wanted.dtype:
        fix = f"end the graph with a Cast to {wanted.dtype}" if what == "output" else "begin the graph with a Cast"
        lines.append(f"{what} {wanted.name!r}: expected {wanted.dtype}, found {found.dtype}; {fix}")
    if found.shape is None or wanted.shape is None:
        return lines
    if len(found.shape) != len(wanted.shape):
        return [*lines, f"{what} {wanted.name!r}: expected {wanted}, found {found}; change its number of axes"]
    for place, (need, have) in enumerate(zip(wanted.shape, found.shape, strict=True)):
        if isinstance(have, int) and isinstance(need, str):
            fix = "export with a dynamic axis there"
            lines.append(f"{what} {wanted.name!r}: expected axis {place} ({need}) to be free, found {have}; {fix}")
        elif isinstance(have, int) and isinstance(need, int) and have != need:
            lines.append(f"{what} {wanted.name!r}: expected {need} on axis {place}, found {have}")
    return lines


def _list(ports: Sequence[Port]) -> str:
    return ", ".join(map(str, ports))
