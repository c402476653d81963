"""The command line in this process: exit code, standard output and standard error of one call."""

from dataclasses import dataclass

import pytest

from vtbench import environment
from vtbench.cli import main


@dataclass(frozen=True)
class Call:
    code: int
    out: str
    err: str


@pytest.fixture
def vtbench(capsys, monkeypatch):
    """`vtbench("list", "scenes")` -> Call."""
    monkeypatch.delenv("VTBENCH_DEBUG", raising=False)
    for name in environment.THREAD_VARIABLES:
        monkeypatch.setenv(name, "1")

    def call(*words):
        capsys.readouterr()
        code = main([str(word) for word in words])
        return Call(code, *capsys.readouterr())

    return call


@pytest.fixture
def refused(vtbench):
    """`refused(*words)` -> the one line on standard error, without its label, of a call that must be bad input."""

    def call(*words):
        answer = vtbench(*words)
        assert answer.code == 2
        assert answer.err.startswith("vtbench: error: ")
        assert answer.err.count("\n") == 1, answer.err
        assert answer.out == ""
        return answer.err.removeprefix("vtbench: error: ").strip()

    return call
