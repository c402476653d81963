"""What stands beside a score: who faces whom, probes that come near, standings, dominance, reality, baselines."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser_records import METHODS, suite

from leaderboard import board_tables, build_board
from leaderboard.baselines import read_baselines, write_baselines
from leaderboard.counterparts import rank_correlation
from leaderboard.curves import front
from leaderboard.frame import records_of
from leaderboard.record import Record, read_predictions, write_record
from leaderboard.sections import result_view
from leaderboard.submission import Submission
from leaderboard.tally import read_tallies, tally, write_tally
from leaderboard.versus import between, compare_pairs, cost_ratio, unpaired, with_best, within

RecordFactory = Callable[..., Record]


def test_all_pairs_of_a_protocol_face_each_other_the_better_first(make_record: RecordFactory) -> None:
    records = [make_record(v, 0.1, 1.0, method=m) for m, v in (("knn", 0.5), ("svm", 0.9), ("ksc", 0.7))]
    records += [make_record(0.99, 0.9, 1.0, method="svm", split="held-out-unit"), make_record(role="probe")]
    pairs = within(records)
    assert [(a.identity.method, b.identity.method) for a, b in pairs] == [
        ("svm", "ksc"),
        ("svm", "knn"),
        ("ksc", "knn"),
    ]
    rows = compare_pairs(pairs, ({}, {}), {})
    assert [row.second.identity.method for row in with_best(rows)] == ["ksc", "knn"]
    assert len(within(records, ["knn@force", records[2].key[:8]])) == 1
    with pytest.raises(ValueError, match=r"no scored method 'x@y'.*there is knn@force, ksc@force, svm@force"):
        within(records, ["x@y"])


def test_two_runs_meet_in_their_equal_cells_on_equal_data_only(make_record: RecordFactory) -> None:
    ours, theirs = [make_record(method="svm"), make_record(method="knn")], [make_record(0.8, 0.7, 0.9, method="svm")]
    ((a, b),) = between(ours, theirs)
    assert (a.identity.method, b.metrics[0].value) == ("svm", 0.8)
    ((a, b),) = between(ours, theirs, ["knn@force", "svm@force"])
    assert (a.identity.method, b.identity.method) == ("knn", "svm")
    with pytest.raises(ValueError, match="share no scored cell"):
        between(ours, [make_record(method="ksc")])
    other = [make_record(method="svm", dataset_hash="e" * 64)]
    with pytest.raises(ValueError, match=r"different samples \(dataset dddddddddddd and eeeeeeeeeeee"):
        compare_pairs(between(ours, other), ({}, {}), {})


def test_cost_is_a_ratio_on_one_machine_and_never_across_two(make_record: RecordFactory) -> None:
    fast, slow = make_record(us=10.0), make_record(us=30.0, feature_us=70.0, method="knn")
    assert cost_ratio(slow, fast) == (pytest.approx(10.0), "")
    assert cost_ratio(fast, make_record(us=10.0, fingerprint="other")) == (None, "different machines")
    assert cost_ratio(fast, make_record(us=None)) == (None, "not timed")


def test_tallies_pair_what_intervals_alone_cannot_tell(make_record: RecordFactory) -> None:
    groups, ids, folds = np.repeat(np.arange(50), 4), np.arange(200), np.zeros(200)
    hard = np.random.default_rng(0).random(200) < 0.8
    better = hard | (np.arange(200) % 12 == 0)
    a, b = make_record(0.83, 0.77, 0.89, method="a"), make_record(0.8, 0.74, 0.86, method="b")
    both = {a.key: tally(better, groups, ids, folds), b.key: tally(hard, groups, ids, folds)}
    (paired,) = compare_pairs([(a, b)], (both, both), {})
    (alone,) = compare_pairs([(a, b)], ({}, {}), {})
    width = [row.comparison.difference.high - row.comparison.difference.low for row in (paired, alone)]
    assert (paired.paired, alone.paired) == (True, False)
    assert width[0] < width[1] / 2
    assert paired.comparison.difference.value == pytest.approx(better.mean() - hard.mean())


def test_unpaired_intervals_combine_as_squares(make_record: RecordFactory) -> None:
    a, b = make_record(0.9, 0.86, 0.93), make_record(0.8, 0.77, 0.84)
    got = unpaired(a, b, 0.02).difference
    assert (got.value - got.low, got.high - got.value) == (
        pytest.approx(np.hypot(0.04, 0.04)),
        pytest.approx(np.hypot(0.03, 0.03)),
    )


def test_a_score_that_a_probe_nearly_reaches_is_marked_wherever_it_is_shown(make_record: RecordFactory) -> None:
    far, near = make_record(0.99, 0.98, 1.0, method="ksc"), make_record(0.6, 0.5, 0.7, method="knn")
    probe = make_record(0.62, 0.55, 0.7, role="probe", modality="rest-frame", method="svm")
    tables = board_tables([far, near, probe])
    said = {row["method"]: row["probe"] for row in records_of(tables.cells) if row["role"] == "method"}
    assert said["ksc"] == ""
    assert "“frame without contact” (SVM) reaches 62.0 %" in said["knn"]
    assert {row["method"]: bool(row["probe"]) for row in records_of(tables.speed)} == {"ksc": False, "knn": True}
    rows = {row["method"]: row["random_probe"] for row in records_of(tables.papers[0].frame) if row["random"]}
    assert rows["knn"] == said["knn"]


def test_submissions_stand_apart_and_only_verified_ones_compete(make_record: RecordFactory) -> None:
    def given(status: str, value: float) -> Record:
        block = Submission(id="x", title="Net", status=status, reason="odd" if status == "flagged" else "")  # type: ignore[arg-type]
        record = make_record(value, value - 0.01, value + 0.005, method=f"net-{status}", variant="default")
        return record.model_copy(update={"submission": block})

    own = make_record(0.7, 0.65, 0.75, variant="default")
    tables = board_tables([own, given("verified", 0.8), given("self-reported", 0.99), given("flagged", 0.98)])
    assert [(t.apart, len(t.frame)) for t in tables.tasks] == [("", 2), ("self-reported", 1), ("flagged", 1)]
    assert {row["method"]: row["rank_worst"] for row in records_of(tables.cells)} == {
        "svm": 2,
        "net-verified": 1 if tables.cells["rank_worst"].min() == 1 else 2,
        "net-self-reported": 1,
        "net-flagged": 1,
    }
    assert set(tables.speed["method"]) == {"svm", "net-verified"}
    assert "flagged" in [notice.kind for notice in tables.notices]


def test_a_model_without_a_score_is_not_called_verified(make_record: RecordFactory, tmp_path: Path) -> None:
    def given(name: str, state: str, **identity: Any) -> Record:
        record = make_record(state=state, reason="" if state == "ok" else "NaN", method=name, **identity)
        return record.model_copy(update={"submission": Submission(id=name, title=name, status="verified")})

    records = [given("whole", "ok"), given("broken", "failed"), given("late", "timeout", variant="default")]
    records += [given("half", "ok"), given("half", "failed", split="held-out-unit")]
    files = build_board(records, tmp_path)
    rows = files.markdown.read_text(encoding="utf-8").replace("\\", "").splitlines()
    said = {row.split("|")[2].strip() for row in rows if row.startswith("| force")}
    assert {"whole [verified]", "half [verified]", "broken [unverified]", "late [unverified]"} <= said
    page = files.html.read_text(encoding="utf-8")
    outcomes = re.findall(r'<summary>.*badge (\w+)">.*"(dim|bad)">', page)
    assert sorted(outcomes) == sorted([("verified", "dim")] * 2 + [("unverified", "bad")] * 3)
    assert page.count("unverified: a submission whose model gave no score here") == 3


def test_times_taken_apart_and_during_the_run_do_not_compare(make_record: RecordFactory) -> None:
    def taken(record: Record, us: float) -> Record:
        assert record.timing is not None
        times = {"predict_us_per_sample": us, "predict_low_us": 0.9 * us, "predict_high_us": 1.1 * us, "batch": 1}
        return record.model_copy(update={"timing": record.timing.model_copy(update=times)})

    best, worst = make_record(0.99, 0.98, 1.0, us=10.0), make_record(0.5, 0.45, 0.55, us=500.0, method="knn")
    for pair, ratio in (
        ((best, worst), 0.02),
        ((taken(best, 20.0), taken(worst, 400.0)), 0.05),
        ((taken(best, 20.0), worst), None),
        ((best, taken(worst, 400.0)), None),
    ):
        assert cost_ratio(*pair) == ((pytest.approx(ratio), "") if ratio else (None, "timed in two ways"))
        tables = board_tables(pair)
        beaten = {row["method"]: row["dominated_by"] for row in records_of(tables.speed)}
        assert beaten == {"svm": "", "knn": best.key if ratio else ""}
        notes = " ".join(result_view(tables.papers[0], {}).notes)
        assert ("1 of 2 were taken apart by `vtbench time`" in notes) is (ratio is None)


def test_dominance_needs_less_time_and_intervals_that_separate(make_record: RecordFactory) -> None:
    records, tallies = suite(make_record)
    speed = board_tables(records, tallies=tallies).speed
    rows = [row for row in records_of(speed) if row["task"] == "objects/deep/v1" and row["variant"] == "paper"]
    by_name = {(row["method"], row["modality"], row["split"]): row for row in rows}
    for split in ("random", "held-out-unit"):
        assert by_name["slow-and-poor", "force", split]["dominated_by"]
        assert not by_name["knn", "force", split]["dominated_by"]  # the fastest of all
        assert not by_name["svm", "force", split]["dominated_by"]
    without = board_tables(records).speed
    assert set(without["dominated_by"]) >= {""}


def test_the_front_falls_from_fast_to_slow() -> None:
    rows = [{"t": t, "error": e} for t, e in ((1, 9), (2, 9), (3, 4), (4, 6), (5, 1))]
    assert [row["t"] for row in front(rows, "t")] == [1, 3, 5]


def test_simulated_and_real_ranks_stand_side_by_side(make_record: RecordFactory) -> None:
    records, tallies = suite(make_record)
    beside = board_tables(records, tallies=tallies).beside
    assert len(beside) == len(METHODS)
    assert set(beside["family"]) == {"texture"}
    assert set(beside["rank_correlation"]) == {1.0}
    first = records_of(beside)[0]
    assert (first["simulated_task"], first["real_task"]) == ("texture/slides/v1", "texture/fabricslide16/v1")


def test_rank_correlation_is_spearman_s() -> None:
    from scipy.stats import spearmanr

    a, b = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0], [2.0, 1.0, 4.0, 3.0, 6.0, 5.0]
    rho, low, high = rank_correlation(a, b)
    assert rho == pytest.approx(spearmanr(a, b).statistic)
    assert low is not None
    assert high is not None
    assert low < rho < high
    assert rank_correlation(a[:3], b[:3]) == (None, None, None)
    assert rank_correlation([1.0, 1.0, 1.0, 1.0], [1.0, 2.0, 3.0, 4.0]) == (None, None, None)


def test_baselines_come_back_as_they_were(make_record: RecordFactory, tmp_path: Path) -> None:
    records, tallies = suite(make_record)
    write_baselines(tmp_path / "x.json", records, tallies)
    assert read_baselines(tmp_path) == (records, tallies)
    (tmp_path / "y.json").write_text("{}")
    with pytest.raises(ValueError, match=r"y\.json: expected baseline records"):
        read_baselines(tmp_path)


def test_the_committed_baselines_make_the_paper_s_tables() -> None:
    records, tallies = read_baselines()
    tables = board_tables(records, tallies=tallies)
    assert [table.paper_table for table in tables.papers] == ["II", "III"]
    for table in tables.papers:
        ours = table.frame.dropna(subset=["random", "held-out-unit"])
        assert len(ours) >= 9
        assert (ours["random_ranked"] == "paired over groups, Holm").all()


def test_new_predictions_make_an_old_tally_void(make_record: RecordFactory, tmp_path: Path) -> None:
    record, label = make_record(), np.arange(3)
    folder = write_record(tmp_path, record, {"label": label})
    write_tally(folder, tally([1, 0, 1], label, label, label))
    assert list(read_tallies(tmp_path)) == [record.key]
    write_record(tmp_path, record)  # a new score of the same predictions
    assert list(read_tallies(tmp_path)) == [record.key]
    write_record(tmp_path, record, {"label": label})
    assert read_tallies(tmp_path) == {}
    assert list(read_predictions(tmp_path, record.key)) == ["label"]
