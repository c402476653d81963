from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from pydantic import ValidationError

from leaderboard.record import (
    Identity,
    Record,
    RecordWarning,
    canonical_json,
    read_predictions,
    read_records,
    record_key,
    scan_records,
    write_record,
)

RecordFactory = Callable[..., Record]


def test_key_depends_on_content_not_on_order(make_record: RecordFactory) -> None:
    a = make_record(params={"C": 1.0, "gamma": 0.1}).identity
    b = make_record(params={"gamma": 0.1, "C": 1.0}).identity
    assert record_key(a) == record_key(b)
    assert len(record_key(a)) == 64


@pytest.mark.parametrize(
    "change",
    [
        {"task": "t/v2"},
        {"variant": "hard"},
        {"split": "held-out-unit"},
        {"method": "knn"},
        {"modality": "image"},
        {"role": "probe"},
        {"kind": "real"},
        {"params": {"C": 2}},
        {"seed": 1},
        {"dataset_hash": "e"},
        {"protocol_version": 2},
    ],
)
def test_every_part_of_the_identity_changes_the_key(make_record: RecordFactory, change: dict[str, object]) -> None:
    assert make_record().key != make_record(**change).key


def test_nothing_measured_changes_the_key(make_record: RecordFactory) -> None:
    assert make_record().key == make_record(0.5, 0.4, 0.6, us=3.0, fingerprint="other").key


def test_record_round_trips_through_disk(make_record: RecordFactory, tmp_path: Path) -> None:
    record = make_record(params={"kernel": "rbf", "grid": [1, 2, {"x": None}]})
    folder = write_record(tmp_path, record)
    assert folder == tmp_path / "runs" / record.key
    assert read_records(tmp_path) == [record]
    assert read_records(tmp_path / "runs") == [record]


def test_unknown_keys_are_refused(make_record: RecordFactory) -> None:
    data = make_record().model_dump(mode="json")
    with pytest.raises(ValidationError, match="acuracy"):
        Record.model_validate(data | {"acuracy": 1})
    data["identity"]["sede"] = 3
    with pytest.raises(ValidationError, match="sede"):
        Record.model_validate(data)


def test_frozen(make_record: RecordFactory) -> None:
    with pytest.raises(ValidationError, match="frozen"):
        make_record().key = "x"


def test_a_key_that_is_not_the_identity_s_is_refused(make_record: RecordFactory) -> None:
    data = make_record().model_dump(mode="json") | {"key": "0" * 64}
    with pytest.raises(ValidationError, match="hash of the identity"):
        Record.model_validate(data)


def test_failure_needs_a_reason_and_success_a_result(make_record: RecordFactory) -> None:
    with pytest.raises(ValidationError, match="needs a reason"):
        make_record(state="failed")
    with pytest.raises(ValidationError, match="neither a metric nor a verdict"):
        make_record(None)


def test_failure_stays_a_record(make_record: RecordFactory, tmp_path: Path) -> None:
    write_record(tmp_path, make_record(state="skipped", reason="run `vtbench fetch fabricslide16`"))
    (record,) = read_records(tmp_path)
    assert record.status.reason.endswith("fabricslide16`")
    assert record.metrics == ()


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_non_finite_numbers_are_refused(make_record: RecordFactory, value: float) -> None:
    with pytest.raises(ValidationError, match="finite"):
        make_record(value, None, None)
    with pytest.raises(ValueError, match="not JSON compliant"):
        canonical_json({"x": value})


def test_interval_ends_come_together_and_in_order(make_record: RecordFactory) -> None:
    with pytest.raises(ValidationError, match="neither"):
        make_record(0.5, None, 0.6)
    with pytest.raises(ValidationError, match="upside down"):
        make_record(0.5, 0.6, 0.4)


def test_predictions_need_no_pickle(make_record: RecordFactory, tmp_path: Path) -> None:
    record = make_record()
    arrays = {
        "sample_id": np.array(["s1", "s22"]),
        "fold": np.array([0, 1]),
        "scores": np.eye(2, dtype=np.float32),
    }
    folder = write_record(tmp_path, record, arrays)
    with np.load(folder / "predictions.npz", allow_pickle=False) as archive:
        assert sorted(archive.files) == ["fold", "sample_id", "scores"]
    back = read_predictions(tmp_path, record.key)
    for name, array in arrays.items():
        np.testing.assert_array_equal(back[name], array)
        assert back[name].dtype == array.dtype


def test_object_arrays_are_refused_before_anything_is_written(make_record: RecordFactory, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="fixed-width text"):
        write_record(tmp_path, make_record(), {"label": np.array([{}, None], dtype=object)})
    assert not (tmp_path / "runs").exists()


def test_same_predictions_give_the_same_bytes(make_record: RecordFactory, tmp_path: Path) -> None:
    arrays = {"scores": np.arange(6, dtype=np.float32)}
    a = write_record(tmp_path / "a", make_record(), arrays)
    b = write_record(tmp_path / "b", make_record(), arrays)
    assert (a / "predictions.npz").read_bytes() == (b / "predictions.npz").read_bytes()


def test_rescoring_keeps_predictions_and_failing_removes_them(make_record: RecordFactory, tmp_path: Path) -> None:
    record = make_record()
    write_record(tmp_path, record, {"x": np.zeros(2)})
    write_record(tmp_path, make_record(0.8, 0.7, 0.9))
    assert read_predictions(tmp_path, record.key)["x"].shape == (2,)
    write_record(tmp_path, make_record(state="failed", reason="out of memory"))
    with pytest.raises(ValueError, match="run the cell again"):
        read_predictions(tmp_path, record.key)


def test_broken_predictions_are_named(make_record: RecordFactory, tmp_path: Path) -> None:
    record = make_record()
    folder = write_record(tmp_path, record, {"x": np.zeros(200)})
    whole = (folder / "predictions.npz").read_bytes()
    (folder / "predictions.npz").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(ValueError, match=r"predictions\.npz.*broken"):
        read_predictions(tmp_path, record.key)


def test_nothing_temporary_is_left(make_record: RecordFactory, tmp_path: Path) -> None:
    folder = write_record(tmp_path, make_record(), {"x": np.zeros(3)})
    assert sorted(p.name for p in folder.iterdir()) == ["predictions.npz", "record.json"]


def test_a_write_that_dies_leaves_the_old_record(
    make_record: RecordFactory, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    old = make_record()
    folder = write_record(tmp_path, old)

    def full_disk(_: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("leaderboard._files.os.fsync", full_disk)
    with pytest.raises(OSError, match="No space left"):
        write_record(tmp_path, make_record(0.1, 0.0, 0.2))
    assert read_records(tmp_path) == [old]
    assert [p.name for p in folder.iterdir()] == ["record.json"]


def test_one_broken_record_voids_no_other(make_record: RecordFactory, tmp_path: Path) -> None:
    good = make_record()
    write_record(tmp_path, good)
    broken = {
        "truncated": (tmp_path / "runs" / good.key / "record.json").read_bytes()[:100],
        "binary": b"\x00\xff\xfe",
        "future": json.dumps(good.model_dump(mode="json") | {"schema_version": 99}).encode(),
        "moved": json.dumps(good.model_dump(mode="json")).encode(),
    }
    for name, content in broken.items():
        (tmp_path / "runs" / name).mkdir()
        (tmp_path / "runs" / name / "record.json").write_bytes(content)
    records, problems = scan_records(tmp_path)
    assert records == [good]
    assert len(problems) == len(broken)
    for name, problem in zip(sorted(broken), problems, strict=True):
        assert f"{name}/record.json: left out: " in problem
        assert "\n" not in problem
    with pytest.warns(RecordWarning, match="left out") as seen:
        assert read_records(tmp_path) == [good]
    assert len(seen) == len(broken)


def test_a_missing_folder_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="expected a folder of records"):
        read_records(tmp_path / "nowhere")


def test_identity_seed_is_required() -> None:
    with pytest.raises(ValidationError, match="seed"):
        Identity.model_validate({"task": "t", "method": "m"})
