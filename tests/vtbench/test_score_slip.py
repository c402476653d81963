"""`vtbench score-slip`: every detector on a folder of sequences, thresholds from the other objects."""

import json

import numpy as np
import pytest

from leaderboard.record import Record, read_records
from leaderboard.slips import metric
from vtbench.data.slip_folder import object_of, read_slip_folder
from vtbench.run.detection.own import score_own, sequence_data

OBJECTS = ("ball", "mug", "shoe")


def sequence(seed, slips, samples=2500, taxels=6):
    """Noise at rest; with a slip a pattern that moves over the taxels, else a step that all feel alike."""
    rng = np.random.default_rng(seed)
    force = 1.0 + 0.01 * rng.standard_normal((samples, taxels))
    slipping = np.zeros(samples, int)
    if slips:
        slipping[1200:2000] = 1
        force[1200:2000] += 0.2 * np.sin(0.7 * np.arange(800)[:, None] + np.arange(taxels))
    return force, slipping


def write(root, *, onsets=True, heading=True, labels=("slip", "rest", "step"), objects=OBJECTS, samples=2500):
    for at, name in enumerate(objects):
        for number in range(2):
            for label in labels:
                force, slipping = sequence(at + 10 * number, label == "slip", samples)
                if label == "step":
                    force[1000:] += 0.5
                columns = [f"f{taxel + 1}" for taxel in range(force.shape[1])]
                if onsets:
                    force, columns = np.column_stack([force, slipping]), [*columns, "slip"]
                path = root / label / f"{name}_{number:02d}.csv"
                path.parent.mkdir(parents=True, exist_ok=True)
                np.savetxt(path, force, "%.6g", ",", header=",".join(columns) if heading else "", comments="")
    return root


def edit(path, line, text):
    lines = path.read_text().splitlines()
    lines[line - 1] = text
    path.write_text("\n".join(lines) + "\n")


@pytest.mark.slow
def test_one_command_scores_every_detector_and_keeps_records(vtbench, tmp_path):
    folder = write(tmp_path / "mine", labels=("slip", "rest"))
    answer = vtbench("score-slip", folder, "--rate-hz", 1000, "--detectors", "covariance", "-o", tmp_path / "out")
    assert answer.code == 0, answer.err
    assert "12 sequences (6 with slip) of 3 objects, 6 taxels" in answer.out
    assert "Delay at fixed false alarms" in answer.out
    records = read_records(tmp_path / "out")
    assert {(r.identity.method, r.identity.modality) for r in records} == {
        (method, rule) for method in ("covariance", "energy") for rule in ("prior", "cfar")
    }
    for record in records:
        assert record.status.state == "ok", record.status.reason
        assert record.identity.kind == "real"
        assert metric(record, "detected").value == 1.0
        assert abs(metric(record, "delay_ms").value) < 100.0
    assert vtbench("board", tmp_path / "out", "-o", tmp_path / "board").code == 0


def test_without_onsets_there_are_shares_and_no_delays(vtbench, tmp_path):
    folder = write(tmp_path / "mine", onsets=False, heading=False, labels=("slip", "step"))
    answer = vtbench("score-slip", folder, "--rate-hz", 1000, "--detectors", "energy", "--json")
    assert answer.code == 0, answer.err
    records = [r for r in json.loads(answer.out) if r["identity"]["modality"] == "prior"]
    names = {each["name"] for each in records[0]["metrics"]}
    assert {"detected", "roc_area", "called[kind=step]"} <= names
    assert not any("delay" in name for name in names)
    (no_rest,) = [r for r in json.loads(answer.out) if r["identity"]["modality"] == "cfar"]
    assert no_rest["status"]["state"] == "skipped"
    assert "rest" in no_rest["status"]["reason"]


def test_a_threshold_comes_from_the_other_objects_only(tmp_path):
    data = sequence_data(read_slip_folder(write(tmp_path, labels=("slip", "rest")), 1000.0), 1000.0)
    louder = sequence_data(read_slip_folder(tmp_path, 1000.0), 1000.0)
    louder.forces = tuple(
        force * (50.0 if what.object == "mug" else 1.0) for force, what in zip(data.forces, data.truth, strict=True)
    )
    from vtbench.run.detection.thresholds import fit
    from vtbench.tasks.slides import held_out_object

    for before, after in zip(held_out_object(data, 0).folds, held_out_object(louder, 0).folds, strict=True):
        same = (
            fit("energy", "prior", data, before.train, 1e-2).beta
            == fit("energy", "prior", louder, after.train, 1e-2).beta
        )
        assert same == (before.name == "object-mug")


def test_one_object_cannot_be_left_out_but_its_sequences_can(vtbench, refused, tmp_path):
    folder = write(tmp_path / "mine", objects=("mug",), labels=("slip", "rest"))
    words = ("score-slip", folder, "--rate-hz", 1000, "--detectors", "energy")
    assert "--leave-out sequence" in refused(*words)
    assert vtbench(*words, "--leave-out", "sequence").code == 0


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("mug_03", "mug"),
        ("mug-3", "mug"),
        ("mug", "mug"),
        ("pen2_1", "pen2"),
        ("007", "007"),
        ("red ball 12", "red ball"),
    ],
)
def test_the_object_is_the_name_without_its_number(name, expected):
    assert object_of(name) == expected


def test_what_is_read_is_what_was_written(tmp_path):
    write(tmp_path)
    (found,) = [s for s in read_slip_folder(tmp_path, 1000.0) if s.path == "slip/mug_01.csv"]
    force, slipping = sequence(11, True)
    np.testing.assert_allclose(found.force, force, rtol=1e-5)
    np.testing.assert_array_equal(found.slipping, slipping == 1)
    assert (found.label, found.object) == ("slip", "mug")


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda root: (root / "slip" / "mug_01.csv").write_text(""), "mug_01.csv: empty"),
        (lambda root: (root / "rest" / "a_1.csv").write_text("1;2;3\n" * 30), "expected columns separated by commas"),
        (lambda root: edit(root / "slip" / "mug_01.csv", 5, "1,2,3,4,5,x,0"), "line 5, column 'f6': expected"),
        (
            lambda root: edit(root / "slip" / "mug_01.csv", 5, "1,2,3,4,5,nan,0"),
            "line 5, column 'f6': expected a finite",
        ),
        (lambda root: edit(root / "slip" / "mug_01.csv", 5, "1,2,3"), "line 5: 3 cells, the first line has 7"),
        (lambda root: edit(root / "slip" / "mug_01.csv", 5, "1,2,3,4,5,6,2"), "line 5, column 'slip': expected 0 or 1"),
        (lambda root: edit(root / "rest" / "mug_01.csv", 5, "1,2,3,4,5,6,1"), "the label is 'rest', but"),
        (lambda root: edit(root / "rest" / "mug_01.csv", 1, "time_s,b,c,d,e,f,slip"), "column 'time_s': a step of"),
        (lambda root: (root / "rest" / "a_1.csv").write_text("1,2\n" * 30), "6 taxels"),
        (lambda root: (root / "rest" / "a_1.csv").write_text("1,2,3,4,5,6\n" * 3), "3 samples, expected at least"),
        (
            lambda root: [path.unlink() for path in (root / "slip").iterdir()],
            "expected a sub-folder 'slip', found rest",
        ),
    ],
)
def test_a_bad_folder_is_one_line_that_names_the_file(refused, tmp_path, spoil, message):
    folder = write(tmp_path / "mine", labels=("slip", "rest"), samples=2100)
    spoil(folder)
    assert message in refused("score-slip", folder, "--rate-hz", 1000)


def test_folders_without_sequences_or_rates_are_refused(refused, tmp_path):
    assert "LABEL/NAME.csv" in refused("score-slip", tmp_path, "--rate-hz", 1000)
    assert "found none" in refused("score-slip", tmp_path / "nowhere", "--rate-hz", 1000)
    assert "samples a second" in refused("score-slip", tmp_path, "--rate-hz", "fast")
    assert "did you mean 'energy'" in refused("score-slip", tmp_path, "--rate-hz", 1000, "--detectors", "enrgy")
    write(tmp_path, onsets=False, labels=("slip",))
    assert "no sequences without slip" in refused("score-slip", tmp_path, "--rate-hz", 1000)


def test_slips_with_onsets_alone_are_enough(tmp_path):
    data = sequence_data(read_slip_folder(write(tmp_path, labels=("slip",)), 1000.0), 1000.0)
    where = {"version": "0", "python": "3", "fingerprint": "a"}
    (record, *_) = score_own(data, "mine", where, detectors=("energy",))
    assert isinstance(record, Record)
    assert metric(record, "detected").value == 1.0
    assert metric(record, "roc_area") is None
