"""The README's examples run as they stand, on less data."""

import csv
import json
import re
from pathlib import Path

import cv2
import numpy as np
import pytest

from vtbench.cli import main

README = Path(__file__).parents[2] / "README.md"


def blocks(language: str) -> dict[str, str]:
    """Code blocks of a language whose first line is a comment with a file's name."""
    found = re.findall(rf"```{language}\n(# (\S+)\n.*?)```", README.read_text(encoding="utf-8"), flags=re.DOTALL)
    return {name: text for text, name in found}


@pytest.fixture
def in_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.slow
def test_your_own_classifier(in_folder, capsys):
    Path("my_method.py").write_text(blocks("python")["my_method.py"])
    suite = blocks("yaml")["my-suite.yaml"].replace("samples: 648", "samples: 135")
    Path("my-suite.yaml").write_text(suite.replace("modalities: [force]", "modalities: [force]\n    splits: [random]"))
    assert main(["run", "my-suite.yaml", "-o", "out/mine"]) == 0
    assert main(["board", "out/mine", "-o", "out/board"]) == 0
    assert "nearest-mean" in Path("out/board/board.md").read_text()


def test_your_own_recordings(in_folder, capsys):
    rng = np.random.default_rng(0)
    folder = in_folder / "my-recordings"
    folder.mkdir()
    with (folder / "forces.csv").open("w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["file", "object", "unit", "session", *(f"f{i}" for i in range(1, 10))])
        for press in range(24):
            kind, unit = press % 3, press // 12
            image = rng.integers(0, 80, (64, 64, 3), dtype=np.uint8)
            image[:, 20 * kind : 20 * kind + 20] += 100
            cv2.imwrite(str(folder / f"{press}.png"), image)
            force = rng.normal(0, 0.05, 9)
            force[3 * kind] += 2
            table.writerow([f"{press}.png", f"thing-{kind}", unit, 0, *force.round(3)])
    assert main(["import", "my-recordings", "-o", "data/mine"]) == 0
    assert main(["validate", "data/mine"]) == 0
    Path("mine.yaml").write_text(blocks("yaml")["mine.yaml"].replace("[ksc, jksc, knn, svm]", "[knn]"))
    text = Path("mine.yaml").read_text().replace("methods: [knn]", "modalities: [force]\n    methods: [knn]")
    Path("mine.yaml").write_text(text.replace("probes: true", "probes: false"))
    capsys.readouterr()
    assert main(["run", "mine.yaml", "-o", "out/mine", "--json"]) == 0
    summary = json.loads(capsys.readouterr().out)
    assert summary["failed"] == summary["timeout"] == 0
    assert summary["done"] == summary["total"] == 3
