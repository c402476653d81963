"""`vtbench calibrate-taxels`: the table, the pictures, one line for what is wrong."""

import json

import cv2
import pytest

from vtbench.cli import main

PICTURES = ("loading-loop.png", "scanning.png", "velostat.png", "weights.png")


@pytest.mark.slow
def test_it_draws_and_prints(tmp_path, capsys):
    assert main(["calibrate-taxels", "--preset", "velostat", "-o", str(tmp_path / "out"), "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == list(PICTURES)
    assert all(cv2.imread(path).std() > 10 for path in report["pictures"])
    assert all(row["inside"] for row in report["velostat"])
    assert [row["quantity"] for row in report["static"]][:3] == ["linearity", "hysteresis", "accuracy"]
    assert len(report["weights"]["mean_n"][0]) == 16


def test_an_unknown_preset_is_one_line(tmp_path, capsys):
    assert main(["calibrate-taxels", "--preset", "velostatt", "-o", str(tmp_path)]) == 2
    assert "did you mean 'velostat'" in capsys.readouterr().err
