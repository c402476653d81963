"""Curves of the studies, and which of the paper's orderings hold."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from leaderboard.board import build_board
from leaderboard.contents import board_tables
from leaderboard.orderings import orderings
from leaderboard.record import Record
from leaderboard.studies import STUDIES, study_of, study_rows, study_views
from leaderboard.study_plots import study_figure
from leaderboard.tally import Tally, tally
from leaderboard.versus import name_of
from vtbench.tasks import TASKS

RecordFactory = Callable[..., Record]
SVG = "{http://www.w3.org/2000/svg}"


def study(make: RecordFactory) -> list[Record]:
    made = [
        make(
            0.9 - 0.1 * at,
            0.8 - 0.1 * at,
            0.95,
            task="pairing/v1",
            variant=name,
            method=method,
            modality="fused-change",
        )
        for at, name in enumerate(("paired", "place-2mm", "place-4mm", "place-6mm"))
        for method in ("jksc", "svm")
    ]
    return [*made, make(0.7, 0.6, 0.8, task="pairing/v1", variant="paired", method="ksc", modality="image-change")]


def test_every_level_is_a_variant_or_a_feed_of_its_task() -> None:
    """The board may not import the tasks, so their names are written twice."""
    for known in STUDIES:
        task = next(TASKS.get(name) for name in TASKS if name.startswith(known.task))
        levels = [level for panel in known.panels for level in panel.levels]
        assert {level.variant for level in levels} <= {None, *task.variants}
        assert {level.modality for level in levels} <= {None, *task.modalities}
        if not any(panel.by_feed for panel in known.panels):
            assert {level.variant for level in levels} == set(task.variants)


def test_a_curve_has_a_mark_for_each_level_and_a_line_for_what_has_one_level(make_record: RecordFactory) -> None:
    rows = study_rows(board_tables(study(make_record)).cells, "pairing/v1", "simulated")
    figure = study_figure(rows, "x")
    assert figure is not None
    (strip,) = figure.strips
    (panel,) = strip.panels  # the other axes have one level
    drawn = ET.fromstring(str(panel))
    assert len(drawn.findall(f".//{SVG}path")) == 8
    assert sum("upper" in line.get("class", "") for line in drawn.findall(f".//{SVG}polyline")) == 1
    (view,) = study_views(rows)
    assert [column.title for column in view.columns[3:]] == ["own, %", "2, %", "4, %", "6, %"]
    assert [cell.text for cell in view.rows[0][3:]] == ["70.0", "–", "–", "–"]
    assert {row[2].text for row in view.rows} == {"KSC", "JKSC", "SVM"}


def test_the_curve_takes_the_place_of_the_tables_of_its_levels(make_record: RecordFactory, tmp_path: Path) -> None:
    (group,) = board_tables(study(make_record)).groups
    assert not group.tables
    (alone,) = board_tables(study(make_record)[:1]).groups  # one level is no curve
    assert len(alone.tables) == 1
    assert not study_rows(board_tables([make_record()]).cells, "objects/deep/v1", "simulated")
    files = build_board(study(make_record), tmp_path)
    assert "force of a press about so far away" in files.markdown.read_text()
    assert 'id="study-task-0"' in files.html.read_text()
    assert study_of("pairing/v2") is study_of("pairing/v1") is not study_of("objects/deep/v1")


def judged(make: RecordFactory, shares: dict[str, float], **who: str) -> dict[tuple[str, str], str]:
    """Words on the orderings of methods that are right on a given share of 400 presses, the easiest first."""
    records, tallies = [], dict[str, Tally]()
    for name, share in shares.items():
        method, modality = name.split("@")
        record = make(share, share - 0.05, min(1.0, share + 0.05), method=method, modality=modality, **who)
        right = np.arange(400) < round(400 * share)
        tallies[record.key] = tally(right, np.arange(400), np.arange(400), np.zeros(400))
        records.append(record)
    found = orderings(records, tallies, {})
    return {(name_of(each.result.first), name_of(each.result.second)): each.word for each in found}


def test_an_ordering_holds_is_reversed_or_is_not_shown(make_record: RecordFactory) -> None:
    jksc, svm = "jksc@fused-equal", "svm@fused-equal"
    assert judged(make_record, {jksc: 0.95, svm: 0.85}) == {(jksc, svm): "holds"}
    assert judged(make_record, {jksc: 0.85, svm: 0.95}) == {(jksc, svm): "reversed"}
    assert judged(make_record, {jksc: 0.90, svm: 0.90}) == {(jksc, svm): "equal here"}
    assert judged(make_record, {jksc: 0.90, svm: 0.9125}) == {(jksc, svm): "not shown"}


def test_orderings_run_as_the_papers_table_of_that_task(make_record: RecordFactory) -> None:
    """In table III the SVM stands above JKSC; a task that the paper lacks is held to table II."""
    shares = {"jksc@fused-equal": 0.95, "svm@fused-equal": 0.85, "knn@force": 0.5}
    one, two = "jksc@fused-equal", "svm@fused-equal"
    assert judged(make_record, shares, task="objects/interference/v1") == {(two, one): "reversed"}
    assert judged(make_record, shares, task="pairing/v1", variant="press-other") == {(one, two): "holds"}


def test_one_support_against_a_code_each_has_no_figure_of_the_paper(make_record: RecordFactory) -> None:
    pair = [make_record(method=name, modality="fused") for name in ("jksc", "jksc-independent")]
    (each,) = orderings(pair, {}, {})
    assert name_of(each.result.first) == "jksc@fused"
    assert each.paper is None


def test_frames_of_each_backbone_are_ordered_among_themselves(make_record: RecordFactory) -> None:
    """Forces alone belong to all of them, frames of two backbones are never each other's."""

    def made(method: str, modality: str, backbone: str = "") -> Record:
        who = {"method": method, "modality": modality, "task": "pairing/v1"}
        return make_record(**who, params={"backbone": backbone} if backbone else {})

    ours = [made("jksc", "fused-equal", "vt-vgg"), made("svm", "fused-equal", "vt-vgg"), made("ksc", "image", "vt-vgg")]
    forces = [made("ksc", "force"), made("knn", "force")]
    found = {
        (each.backbone, name_of(each.result.first), name_of(each.result.second)) for each in orderings(ours, {}, {})
    }
    jksc = "jksc@fused-equal@vt-vgg"
    assert found == {("vt-vgg", jksc, "svm@fused-equal@vt-vgg"), ("vt-vgg", jksc, "ksc@image@vt-vgg")}

    usual = [made("jksc", "fused-equal", "efficientnet-lite0"), made("knn", "fused-equal", "efficientnet-lite0")]
    both = orderings([*ours, *forces, *usual], {}, {})
    framed = [
        {r.identity.params["backbone"] for r in (each.result.first, each.result.second) if r.identity.params}
        for each in both
    ]
    assert all(used <= {each.backbone} for used, each in zip(framed, both, strict=True))
    assert [each.backbone for each in both] == sorted(each.backbone for each in both)  # the usual one first
    assert framed.count(set()) == 1  # forces alone are judged once
    against_force = [each.backbone for each in both if name_of(each.result.second) == "ksc@force"]
    assert against_force.count("vt-vgg") == against_force.count("efficientnet-lite0") == 1


@pytest.mark.parametrize("records", [[], ["knn"]])
def test_nothing_to_order_is_nothing(make_record: RecordFactory, records: list[str]) -> None:
    assert orderings([make_record(method=name) for name in records], {}, {}) == []
