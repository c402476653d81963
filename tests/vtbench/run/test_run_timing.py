"""A run is timed in processes of its own; what was taken stays and goes into the records."""

import json

import pytest

from leaderboard.record import read_records
from tests.vtbench.run import small
from vtbench.environment import fingerprint
from vtbench.run import run_suite
from vtbench.run.planned import planned
from vtbench.timing import report
from vtbench.timing.schedule import collect
from vtbench.timing.subject import Subject, subjects_of


@pytest.mark.slow
def test_a_run_is_timed_and_its_records_say_so(presses, tmp_path):
    out = tmp_path / "run"
    suite = small.suite(presses, ["knn"], entry={"splits": ["random"]})
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

    assert report.into_records(out, subjects, samples) == 1
    for record in read_records(out):
        (row,) = [row for row in table if row["what"].endswith(record.identity.method)]
        assert record.timing.predict_us_per_sample == row["us_one"]
        assert record.timing.predict_low_us <= row["us_one"] <= record.timing.predict_high_us
        assert record.metrics == before[record.key].metrics


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
