from __future__ import annotations

from collections.abc import Callable

import pytest

from leaderboard.audit import laws_table, missing, probe_warning, probes_table, reached, too_easy
from leaderboard.curves import pose_curve, speed_table
from leaderboard.frame import latest, records_frame, records_of
from leaderboard.names import METHODS, MODALITIES, VARIANTS, order, title
from leaderboard.paper import FIGURES, TABLE_II, TABLE_III, TABLE_IV
from leaderboard.record import Record, Verdict
from leaderboard.tables import paper_tables, task_tables

RecordFactory = Callable[..., Record]


def test_the_paper_s_figures() -> None:
    """Between the tables the accuracies fall as the paper's text says."""
    assert len(TABLE_II) == len(TABLE_III) == 9
    said = {"force": (11, 16), "image": (8, 19), "fused": (8, 15.5)}
    for deep, both in zip(TABLE_II, TABLE_III, strict=True):
        assert (deep.modality, deep.method) == (both.modality, both.method)
        least, most = said[deep.modality]
        assert least <= deep.percent - both.percent <= most
    assert [(f.found, f.trials) for f in TABLE_IV] == [(20, 20), (20, 20), (19, 20)]


def test_only_two_of_the_paper_s_figures_are_multiples_of_1_in_270() -> None:
    whole = [f.percent for f in FIGURES if any(round(100 * k / 270, 2) == f.percent for k in range(271))]
    assert whole == [90.00, 98.89]


def test_the_paper_s_intervals() -> None:
    (jksc,) = (f for f in TABLE_II if f.method == "jksc")
    assert jksc.interval == pytest.approx((96.8, 99.6), abs=0.05)
    assert "98.39" in jksc.note
    assert TABLE_IV[2].interval[0] == pytest.approx(76.4, abs=0.05)


def test_known_ids_first_then_by_the_number_in_them() -> None:
    names = ["zeta", "svm", "alpha", "ksc"]
    assert sorted(names, key=lambda n: order(METHODS, n)) == ["ksc", "svm", "alpha", "zeta"]
    variants = ["jitter-10mm", "hard", "jitter-2mm", "paper"]
    assert sorted(variants, key=lambda n: order(VARIANTS, n)) == ["paper", "hard", "jitter-2mm", "jitter-10mm"]


def test_a_row_a_record_in_percent(make_record: RecordFactory) -> None:
    frame = records_frame([make_record(method="svm"), make_record(method="ksc", us=10, feature_us=5000)])
    assert list(frame["method"]) == ["ksc", "svm"]
    assert list(frame["value"]) == [90.0, 90.0]
    assert list(frame["total_us"]) == [5010, 120]


def test_no_records_make_an_empty_board() -> None:
    cells = records_frame([])
    assert task_tables(cells) == paper_tables(cells) == missing(cells) == too_easy(cells) == []
    assert len(probes_table(cells)) == len(laws_table(cells)) == len(pose_curve(cells)) == len(speed_table(cells)) == 0


def test_of_records_that_differ_in_seed_the_latest_stands(make_record: RecordFactory) -> None:
    old = make_record(0.5, 0.4, 0.6, seed=0, started="2026-01-01T00:00:00+00:00")
    new = make_record(0.7, 0.6, 0.8, seed=1, started="2026-02-01T00:00:00+00:00")
    cells = records_frame([new, old])
    assert list(latest(cells)["value"]) == [70.0]
    (table,) = paper_tables(cells)
    assert table.superseded == 1


def _paper(table_frame: object) -> dict[tuple[str, str], dict[str, object]]:
    return {(row["modality"], row["method"]): row for row in records_of(table_frame)}  # type: ignore[arg-type]


def test_backbones_of_one_feed_are_rows_of_their_own(make_record: RecordFactory) -> None:
    usual = make_record(0.6, variant="default", modality="image", params={"backbone": "efficientnet-lite0"})
    other = make_record(0.9, variant="default", modality="image", params={"backbone": "vt-vgg"})
    frame = latest(records_frame([other, usual]))
    assert frame["modality"].tolist() == ["image", "image@vt-vgg"]
    (table,) = task_tables(frame)
    assert sorted(table.frame["modality"]) == ["image", "image@vt-vgg"]
    assert title(MODALITIES, "image@vt-vgg") == "image (vt-vgg)"


def test_paper_table_has_every_figure_and_our_two_columns(make_record: RecordFactory) -> None:
    records = [
        make_record(0.95, method="jksc", modality="fused"),
        make_record(0.60, 0.5, 0.7, method="jksc", modality="fused", split="held-out-unit"),
        make_record(method="wknn", modality="image"),
    ]
    (table,) = paper_tables(records_frame(records))
    assert (table.paper_table, table.press, table.splits) == ("II", "deep", ("random", "held-out-unit"))
    rows = _paper(table.frame)
    assert len(rows) == 10
    jksc = rows["fused", "jksc"]
    assert (jksc["paper"], jksc["random"], jksc["held-out-unit"]) == (98.89, 95.0, 60.0)
    assert jksc["paper_low"] == pytest.approx(96.8, abs=0.05)
    assert rows["force", "svm"]["random"] is None
    assert rows["force", "svm"]["paper"] == 90.0
    assert rows["image", "wknn"]["paper"] is None
    assert [m for m, _ in rows] == sorted((m for m, _ in rows), key=["force", "image", "fused"].index)


def test_the_paper_stands_beside_both_ways_to_weigh(make_record: RecordFactory) -> None:
    records = [make_record(method="svm", modality=m) for m in ("fused", "fused-equal")]
    (table,) = paper_tables(records_frame(records))
    rows = _paper(table.frame)
    assert rows["fused", "svm"]["paper"] == rows["fused-equal", "svm"]["paper"] == 95.0


def test_interference_is_table_iii_and_other_variants_are_no_paper_table(make_record: RecordFactory) -> None:
    records = [
        make_record(task="objects/interference/v1"),
        make_record(task="objects/interference/v1", variant="hard", split="held-out-unit"),
    ]
    cells = records_frame(records)
    (paper,) = paper_tables(cells)
    (task,) = task_tables(cells)
    assert paper.paper_table == "III"
    assert (task.variant, task.splits, task.paper_table) == ("hard", ("held-out-unit",), "")


def test_what_was_not_measured_on_the_same_data_shares_no_table(make_record: RecordFactory) -> None:
    same = {"variant": "default", "dataset": "a"}
    records = [
        make_record(**same),
        make_record(**same, dataset_hash="e" * 64),
        make_record(**same, kind="real"),
        make_record(**same, protocol_version=2),
    ]
    tables = task_tables(records_frame(records))
    assert sorted(table.label for table in tables) == ["", "", "dataset a dddddddd", "dataset a eeeeeeee"]


def test_real_fabrics_have_their_table_and_a_skipped_row_its_reason(make_record: RecordFactory) -> None:
    real = {"task": "texture/fabricslide16/v1", "variant": "public", "kind": "real", "modality": "spectrum"}
    hint = "no recordings; run `vtbench fetch fabricslide16`"
    records = [
        make_record(state="skipped", reason=hint, split=split, **real) for split in ("held-out-setting", "random")
    ]
    cells = records_frame(records)
    (table,) = task_tables(cells)
    assert table.kind == "real"
    assert table.splits == ("random", "held-out-setting")
    (row,) = records_of(table.frame)
    assert row["random"] is None
    assert (row["random_state"], row["random_reason"]) == ("skipped", hint)
    assert missing(cells) == [f"texture/fabricslide16/v1: 2 rows skipped: {hint}"]


@pytest.mark.parametrize(
    ("value", "low", "high", "warned"),
    [
        (0.70, 0.65, 0.75, False),
        (0.86, 0.855, 0.869, True),  # within five points of the best
        (0.80, 0.70, 0.88, True),  # intervals overlap
        (0.95, 0.94, 0.96, True),  # better than the best
    ],
)
def test_a_probe_that_comes_near_is_a_warning(
    make_record: RecordFactory, value: float, low: float, high: float, warned: bool
) -> None:
    records = [
        make_record(0.90, 0.87, 0.93),
        make_record(0.50, 0.40, 0.60, method="knn"),
        make_record(value, low, high, role="probe", modality="total-force"),
    ]
    (row,) = records_of(probes_table(records_frame(records)))
    assert row["warning"] is warned
    assert (row["best_method"], row["best_value"]) == ("svm", 90.0)
    assert f"{100 * value:.1f} %" in probe_warning(row)


@pytest.mark.parametrize(("groups", "warned"), [(1, False), (2, False), (3, True)])
@pytest.mark.parametrize("few", ["probe", "method"])
def test_intervals_of_one_or_two_groups_overlap_with_everything_and_warn_of_nothing(
    make_record: RecordFactory, groups: int, warned: bool, few: str
) -> None:
    counts = {name: groups if name == few else 27 for name in ("probe", "method")}
    best = make_record(0.98, 0.10, 1.0, groups=counts["method"])
    shuffled = make_record(0.04, 0.0, 0.6, groups=counts["probe"], role="probe", modality="shuffled-labels")
    near = make_record(0.94, 0.0, 1.0, groups=groups, role="probe", modality="total-force")
    cells = records_frame([best, shuffled, near])
    found = {row["modality"]: row["warning"] for row in records_of(probes_table(cells))}
    assert found == {"shuffled-labels": warned, "total-force": True}  # within five points, whatever the groups
    said = reached(records_frame([best, shuffled]))
    assert (best.key in said) is warned


def test_a_probe_compares_with_its_own_protocol_only(make_record: RecordFactory) -> None:
    records = [
        make_record(0.99, 0.98, 1.0, split="random"),
        make_record(0.30, 0.25, 0.35, split="held-out-unit"),
        make_record(0.31, 0.26, 0.36, role="probe", modality="rest-frame", split="held-out-unit"),
        make_record(0.31, 0.26, 0.36, role="probe", modality="rest-frame", split="random"),
        make_record(role="probe", modality="rest-frame", variant="hard", state="failed", reason="x"),
    ]
    warned = {(r["variant"], r["split"]): r["warning"] for r in records_of(probes_table(records_frame(records)))}
    assert warned == {("paper", "random"): False, ("paper", "held-out-unit"): True, ("hard", "random"): False}


def test_laws_keep_their_verdict(make_record: RecordFactory) -> None:
    verdict = Verdict(law="all alike", expected="100 %", observed="99 %", passed=False)
    records = [
        make_record(0.99, role="law", variant="no-variation", verdict=verdict),
        make_record(role="law", variant="no-variation", method="knn", state="failed", reason="x"),
    ]
    knn, svm = records_of(laws_table(records_frame(records)))
    assert (svm["law"], svm["passed"], svm["observed"]) == ("all alike", False, "99 %")
    assert knn["passed"] is None


def test_too_easy_needs_best_and_worst_above_99(make_record: RecordFactory) -> None:
    easy = [make_record(v, 0.98, 1.0, method=m) for v, m in ((0.995, "svm"), (1.0, "knn"))]
    (sentence,) = too_easy(records_frame(easy))
    assert "too easy to rank" in sentence
    assert "99.5 to 100.0 %" in sentence
    assert too_easy(records_frame(easy[:1])) == []
    assert too_easy(records_frame([*easy, make_record(0.98, method="ksc")])) == []


def test_pose_curve_reads_millimetres_from_the_variant(make_record: RecordFactory) -> None:
    records = [
        make_record(0.9 - mm / 20, 0.4, 1.0, task="objects/pose/v1", variant=f"jitter-{mm}mm") for mm in (8, 0, 2)
    ]
    records.append(make_record(task="objects/pose/v1", variant="own"))
    curve = pose_curve(records_frame(records))
    assert list(curve["jitter_mm"]) == [0, 2, 8]
    assert list(curve["value"]) == pytest.approx([90, 80, 50])


def test_speed_keeps_machines_apart_and_turns_accuracy_to_error(make_record: RecordFactory) -> None:
    records = [make_record(fingerprint=f, us=us, feature_us=1000) for f, us in (("a", 5), ("b", 6))]
    records += [make_record(us=None, method="knn"), make_record(role="probe")]
    speed = speed_table(records_frame(records))
    assert list(speed["fingerprint"]) == ["a", "b"]
    assert list(speed["total_us"]) == [1005, 1006]
    assert list(speed.loc[0, ["error", "error_low", "error_high"]]) == pytest.approx([10, 6, 15])
