"""`vtbench explain` and `vtbench physics` as a user meets them."""

import json
import re

import pytest

from sensors import explain
from vtbench.cli import main

SCENE = """
id: mine
title: mine
objects: [button, hex-nut]
protocol: {units: 1}
error_bound: {frame: BOUND}
"""


@pytest.fixture
def scene(tmp_path, monkeypatch):
    monkeypatch.setattr(explain, "REPEATS", 1)

    def write(bound):
        path = tmp_path / "mine.yaml"
        path.write_text(SCENE.replace("BOUND", str(bound)))
        return str(path)

    return write


def test_explain_names_the_grid_that_the_bound_took(scene, capsys):
    assert main(["explain", scene(100), "--samples", "1", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert [row["grid"] for row in found["grids"] if row["taken"]] == [64]
    assert found["grids"][0]["bound"] == {"frame": 100}
    noise = next(row for row in found["effects"] if row["name"] == "camera noise")
    assert noise["on"]
    assert noise["frame_levels"] > 0


def test_explain_prints_tables(scene, capsys):
    assert main(["explain", scene(100), "--samples", "1"]) == 0
    out = capsys.readouterr().out
    for word in ("unit spread", "shadows", "skin 64x64", "taken", "frame 100", "frame total"):
        assert word in out
    assert re.search(r"taken: force [\d.]+% of (button|hardware) \(median class [\d.]+%\), displacement ", out)


def test_a_bound_that_no_grid_meets_is_one_line(scene, capsys):
    assert main(["explain", scene(1e-9)]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "no contact grid is within the error bound" in error
    assert "mine.yaml" in error


@pytest.mark.slow
def test_physics_prints_draws_and_says_what_two_per_cent_costs(tmp_path, capsys, monkeypatch):
    from sensors.contact import scoring

    whole = scoring.score_closed_forms
    monkeypatch.setattr(scoring, "score_closed_forms", lambda grids: whole((32,)) if grids == (64,) else [])
    peer = scoring.compare_with_tamaas
    monkeypatch.setattr(scoring, "compare_with_tamaas", lambda grids: peer((32,), 1) if grids == (64,) else [])
    assert main(["physics", "-o", str(tmp_path / "new" / "physics.png")]) == 0
    out = capsys.readouterr().out
    for word in ("layer-fine, pads 8 thicknesses wide", "bonded sphere", "BESIDE TAMAAS", "physics.png"):
        assert word in out
    assert (tmp_path / "new" / "physics.png").read_bytes()[:4] == b"\x89PNG"
