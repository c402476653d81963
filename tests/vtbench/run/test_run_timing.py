"""A run is timed in processes of its own; what was taken stays and goes into the records."""

import json

import pytest

from leaderboard.record import Identity, read_records
from tests.vtbench.run import small
from vtbench.environment import fingerprint
from vtbench.run import run_suite
from vtbench.run.cells import Cell
from vtbench.run.methods import METHODS
from vtbench.run.planned import planned
from vtbench.tasks import TASKS
from vtbench.tasks.base import Block, Feed
from vtbench.timing import report
from vtbench.timing.schedule import collect
from vtbench.timing.subject import Subject, subjects_of


@pytest.mark.slow
def test_a_run_is_timed_and_its_records_say_so(presses, tmp_path):
    out = tmp_path / "run"
    suite = small.suite(presses, ["knn"])
    run_suite(suite, out, progress=False)
    before = {record.key: record for record in read_records(out)}
    subjects = subjects_of(planned(suite, out), set(before))
    assert [(s.kind, s.copy) for s in subjects] == [("classifier", "a"), ("classifier", "b")]

    folder = out / "timings" / fingerprint()
    samples = collect(subjects, out, folder, 2, progress=False)
    table, control = report.rows(subjects, samples), report.control(subjects, samples)
    assert [row["what"].split()[-1] for row in table] == ["knn"]
    for row in table:
        assert row["us_one_least"] <= row["us_one"] <= row["us_one_p95"] or row["us_one_low"] <= row["us_one_high"]
        assert row["us_batch"] < row["us_one"]  # a call costs more than a sample of it
        assert row["processes"] == 2
    assert control is not None
    assert control["what"] == table[0]["what"]

    files = {path: path.read_bytes() for path in folder.rglob("*.json")}
    assert len(files) == 4
    assert collect(subjects, out, folder, 2, progress=False) == samples
    assert {path: path.read_bytes() for path in folder.rglob("*.json")} == files

    assert report.into_records(out, subjects, samples) == 2  # one a split: a table shows one speed a row
    for record in read_records(out):
        (row,) = [row for row in table if row["what"].endswith(record.identity.method)]
        assert record.timing.predict_us_per_sample == row["us_one"]
        assert record.timing.predict_low_us <= row["us_one"] <= record.timing.predict_high_us
        assert record.metrics == before[record.key].metrics


def planned_cell(key, variant, split, dataset="d", backbone="", method="knn"):
    """A cell as `subjects_of` reads it: of frames where a backbone is given, else of forces."""
    who = Identity(
        task="objects/deep/v1",
        variant=variant,
        split=split,
        method=method,
        modality="image" if backbone else "force",
        kind="simulated",
        params={"backbone": backbone} if backbone else {},
        seed=0,
        dataset=dataset,
        dataset_hash=dataset * 64,
        protocol_version=1,
    )
    feed = Feed((Block("image"),)) if backbone else small.FORCE
    return Cell(who, key, TASKS.get(who.task), feed, METHODS.get(method), 1.0, backbone)


def test_the_row_that_a_table_shows_first_is_timed_and_each_backbone_by_itself():
    cells = [
        planned_cell("hard-random", "hard", "random"),
        planned_cell("paper-unit", "paper", "held-out-unit"),
        planned_cell("paper-random", "paper", "random"),
        planned_cell("other-data", "paper", "random", dataset="e"),
        planned_cell("not-done", "paper", "random", method="svm"),
        planned_cell("only-hard", "hard", "random", method="ksc"),
        planned_cell("lite", "paper", "random", backbone="efficientnet-lite0"),
        planned_cell("vgg", "paper", "random", backbone="vt-vgg"),
    ]
    found = {s.name: s for s in subjects_of(cells, {cell.key for cell in cells} - {"not-done"}) if s.copy == "a"}
    rows = {name: subject.row for name, subject in found.items() if subject.kind == "classifier"}
    assert rows == {
        "objects/deep/v1 force knn": ("paper-random", "paper-unit"),
        "objects/deep/v1 force ksc": ("only-hard",),
        "objects/deep/v1 image knn": ("lite",),
        "objects/deep/v1 image@vt-vgg knn": ("vgg",),
    }
    for name, network in (("image", "efficientnet-lite0, image"), ("image@vt-vgg", "vt-vgg, image")):
        assert found[f"objects/deep/v1 {name} knn"].features == (found[network].slug,)


def test_features_take_the_measured_time_where_their_network_was_timed(presses, tmp_path):
    out = tmp_path / "run"
    run_suite(small.suite(presses, ["knn"], entry={"splits": ["random"]}), out, progress=False)
    (before,) = read_records(out)
    network = Subject("net", "features", before.key, "image")
    method = Subject("knn", "classifier", before.key, row=(before.key,), features=(network.slug,))
    taken = {"import_s": 0, "load_s": 0, "first_call_ns": 1, "peak_mb": 1, "large": 1, "many_ns": [1000]}
    samples = {each.slug: [{**taken, "one_ns": [ns]}] for each, ns in ((network, 7_000), (method, 3_000))}
    report.into_records(out, [method], {method.slug: samples[method.slug]})
    (alone,) = read_records(out)
    assert alone.timing.predict_us_per_sample == 3.0
    assert alone.timing.feature_us_per_sample == before.timing.feature_us_per_sample
    report.into_records(out, [network, method], samples)
    (both,) = read_records(out)
    assert (both.timing.predict_us_per_sample, both.timing.feature_us_per_sample) == (3.0, 7.0)


def test_a_subject_that_fails_says_why(tmp_path):
    with pytest.raises(ValueError, match=r"lost thing: its timing failed: .*suite\.yaml"):
        collect([Subject("lost thing", "classifier", "0" * 64)], tmp_path, tmp_path / "t", 1, progress=False)


def test_samples_of_a_killed_timing_are_kept(tmp_path):
    """A file that is there is not timed again, one that is cut is."""
    subject = Subject("a thing", "classifier", "0" * 64)
    folder = tmp_path / "t" / subject.slug
    folder.mkdir(parents=True)
    (folder / "000.json").write_text(json.dumps({"one_ns": [1]}))
    assert collect([subject], tmp_path, tmp_path / "t", 1, progress=False) == {subject.slug: [{"one_ns": [1]}]}
    (folder / "000.json").write_text('{"one')
    with pytest.raises(ValueError, match="a thing: its timing failed"):
        collect([subject], tmp_path, tmp_path / "t", 1, progress=False)
