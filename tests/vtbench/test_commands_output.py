import json
import sys
from pathlib import Path

import numpy as np
import pytest

from vtbench.commands import output


def test_json_holds_no_value_that_readers_refuse(capsys):
    output.print_json(
        {"nan": float("nan"), "inf": np.inf, "array": np.array([1.5, np.nan]), "path": Path("a/b"), 1: np.int64(3)}
        | {"deep": ({"x": np.float32(0.5)}, None, True)}
    )
    assert json.loads(capsys.readouterr().out, parse_constant=pytest.fail) == {
        "nan": None,
        "inf": None,
        "array": [1.5, None],
        "path": "a/b",
        "1": 3,
        "deep": [{"x": 0.5}, None, True],
    }


def test_columns_of_a_table_stand_under_each_other(capsys):
    output.print_table(["name", "count", "about"], [["a", 1, "x y"], ["longer", 200, None]])
    assert capsys.readouterr().out == "name    count  about\na           1  x y\nlonger    200  -\n"


def test_a_table_without_rows_is_its_headings(capsys):
    output.print_table(["name", "about"], [])
    assert capsys.readouterr().out == "name  about\n"


def test_on_a_terminal_the_last_column_wraps(capsys, monkeypatch):
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True)
    monkeypatch.setenv("COLUMNS", "40")
    words = "word " * 30
    output.print_table(["name", "about"], [["a", words]])
    lines = capsys.readouterr().out.splitlines()
    assert max(map(len, lines)) <= 40
    assert " ".join(line[6:] for line in lines[1:]).split() == words.split()


@pytest.mark.parametrize(("size", "text"), [(1, "1 bytes"), (1500, "1.5 kB"), (4.2e6, "4.2 MB"), (3e9, "3.0 GB")])
def test_sizes_read_like_sizes(size, text):
    assert output.size_text(int(size)) == text
