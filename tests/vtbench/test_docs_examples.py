"""The pages on one's own method and one's own data run word for word, and so do the orders for ONNX files."""

import json
import os
import re
import runpy
import shlex
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from fusion.features import get_backbone
from vtbench.cli import main
from vtbench.config import load_scene, load_suite

DOCS = Path(__file__).parents[2] / "vtbench" / "docs"


def write_files(page, folder):
    """Write each block whose first line is a comment with a file's name; return the lines of the `sh` blocks."""
    text = (DOCS / page).read_text(encoding="utf-8")
    for block, name in re.findall(r"```(?:python|yaml)\n(# (\S+)\n.*?)```", text, flags=re.DOTALL):
        (folder / name).write_text(block)
    return [line for block in re.findall(r"```sh\n(.*?)```", text, flags=re.DOTALL) for line in block.splitlines()]


def follow(lines):
    for line in lines:
        program, *words = shlex.split(line)
        assert program == "vtbench"
        assert main(words) == 0, line


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.slow
def test_your_own_method_reaches_the_board(place, capsys):
    follow(write_files("own-method.md", place))
    board = (place / "out/board/board.md").read_text()
    assert "nearest-mean" in board
    assert "failed" not in capsys.readouterr().out


def test_a_scene_of_your_own_stands_beside_the_suite(place, monkeypatch):
    write_files("own-method.md", place)
    (said,) = re.findall(r"its dataset is then `(.+)`\.", (DOCS / "own-method.md").read_text(encoding="utf-8"))
    suite = place / "my-suite.yaml"
    suite.write_text(re.sub(r"\{id: paper, .*\}", said, suite.read_text()))
    (place / "elsewhere").mkdir()
    monkeypatch.chdir(place / "elsewhere")
    (dataset,) = load_suite("../my-suite.yaml").datasets
    scene = load_scene(dataset.scene)
    assert (scene.id, scene.object_names[0], scene.load.deep_n) == ("my-coins", "coin-1-euro", 6.0)
    assert dataset.samples <= scene.n_samples


def test_a_backbone_of_your_own_gives_the_suite_its_features(place):
    write_files("own-method.md", place)
    runpy.run_path("my_backbone.py")
    text = (DOCS / "own-method.md").read_text(encoding="utf-8")
    (line,) = re.findall(r"In `my-suite\.yaml` it is `(backbone: .+?)`", text)
    (feeds,) = re.findall(r"`(modalities: .+?)`", text)
    suite = place / "my-suite.yaml"
    suite.write_text(re.sub(r"modalities: .*", feeds, suite.read_text()) + f"{line}\n")
    read = load_suite(suite)
    frames = np.random.default_rng(0).integers(0, 256, (2, 40, 30, 3), dtype=np.uint8)
    features = get_backbone(read.backbone).extract(frames)
    np.testing.assert_allclose(features, frames.mean((1, 2)), rtol=1e-5)
    assert read.entries[0].modalities == ("image", "image-change", "fused")


def record(folder):
    """What the page says that a logger wrote: three objects, two days, four presses of each."""
    rng = np.random.default_rng(0)
    for day in ("day-1", "day-2"):
        for number, name in enumerate(("cup", "nut", "pen")):
            (folder / day / name).mkdir(parents=True)
            for press in range(4):
                stem = folder / day / name / f"press_{press}"
                cv2.imwrite(f"{stem}.png", rng.integers(0, 256, (32, 32, 3), dtype=np.uint8))
                samples = rng.normal(20, 4, (10, 3)) + 300 * (np.arange(3) == number)
                rows = [[t / 100, *row] for t, row in enumerate(samples)]
                lines = [";".join(f"{value:.2f}".replace(".", ",") for value in row) for row in rows]
                Path(f"{stem}.csv").write_text("\n".join(["# logger v2", "t;ch 1;ch 2;ch 3", *lines]))
        cv2.imwrite(str(folder / day / "rest.png"), np.full((32, 32, 3), 90, np.uint8))


@pytest.mark.slow
def test_your_own_recordings_are_scored_and_open_elsewhere(place, capsys):
    record(place / "recordings")
    follow(write_files("own-data.md", place))
    out = capsys.readouterr().out
    assert "cup 8, nut 8, pen 8" in out
    kept = [json.loads(path.read_text()) for path in place.glob("out/mine/runs/*/record.json")]
    scores = {
        (record["identity"]["method"], record["identity"]["split"]): record["metrics"][0]["value"]
        for record in kept
        if record["identity"]["role"] == "method" and record["status"]["state"] == "ok"
    }
    assert {method for method, _ in scores} == {"knn", "svm"}
    assert min(scores.values()) > 0.9, "objects that press one taxel each are told apart"
    environment = {**os.environ, "HF_HUB_OFFLINE": "1", "HF_HOME": str(place / "hub")}
    look = subprocess.run([sys.executable, "look.py"], env=environment, capture_output=True, text=True, timeout=120)
    assert look.returncode == 0, look.stderr
    assert look.stdout.splitlines()[-1] == "(32, 32) ['cup', 'nut', 'pen']"


def test_every_folder_of_data_that_the_page_on_fusion_reads_is_made_there():
    """An order that reads a folder stands below the one that writes it, in one block."""
    blocks = re.findall(r"```sh\n(.*?)```", (DOCS / "fusion.md").read_text(encoding="utf-8"), flags=re.DOTALL)
    read = 0
    for block in blocks:
        made = set()
        for line in block.splitlines():
            words = shlex.split(line, comments=True)
            if "--data" in words:
                read += 1
                assert words[words.index("--data") + 1] in made, line
            if words[1] == "generate":
                made.add(words[words.index("-o") + 1])
    assert read >= 4


@pytest.mark.slow
def test_slip_detectors_are_exported_as_the_page_on_fusion_says(place):
    """With fewer trials; those on presses are the export command's own tests."""
    lines = [line for line in write_files("fusion.md", place) if "data/slip" in line]
    assert len(lines) == 3
    follow([re.sub(r"--samples \d+", "--samples 12", line.partition("#")[0]) for line in lines])
    assert (place / "covariance.onnx").is_file()
    assert (place / "on-robot.onnx").is_file()
