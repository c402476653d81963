"""Slip records on the board: the paper beside ours, the baseline beside all, no verdict from an area."""

import re
from datetime import UTC, datetime

import pytest

from leaderboard import board_tables, build_board, format_console
from leaderboard.record import Metric
from leaderboard.slip_plot import delay_figure
from leaderboard.slip_tables import metrics_frame, slip_blocks, verdicts
from leaderboard.slip_views import slip_views, table_iv
from leaderboard.slips import MISSED_MS
from leaderboard.submission import Submission
from leaderboard.text import console_table

SHAPES = ("ball", "cuboid", "cylinder")


def share(name, found, of=20):
    return Metric(name=name, value=found / of, n=of, groups=of, low=0.0, high=1.0, interval="Wilson")


def ms(name, value, low, high):
    return Metric(name=name, value=value, unit="ms", direction="lower", n=60, groups=60, low=low, high=high)


def amount(name, value, unit="µs a sample"):
    return Metric(name=name, value=value, unit=unit, direction="lower", n=1, groups=1)


@pytest.fixture
def slip_record(make_record):
    def make(method="covariance", difference=(5.0, 2.0, 9.0), delay=40.0, minutes=45.0, **identity):
        who = {"task": "slip/fvsight/v1", "variant": "paper", "modality": "prior", "split": "held-out-object"}
        record = make_record(method=method, **{**who, **identity})
        metrics = [share("detected", 57, 60), share("false_alarm_trials", 4, 60)]
        metrics += [share(f"detected[object={shape}]", 19) for shape in SHAPES]
        for rate in (1.0, 10.0):
            metrics += [
                amount(f"expected_alarms@{rate:g}", rate * minutes, "alarms"),
                share(f"detected@{rate:g}", 50, 60),
                ms(f"delay_ms@{rate:g}", delay, delay, max(delay, 90.0)),
                ms(f"delay_minus_energy_ms@{rate:g}", *difference),
                *(ms(f"delay_ms@{rate:g}[speed={speed}]", delay, delay, delay) for speed in ("2 mm/s", "10 mm/s")),
                *(share(f"detected@{rate:g}[speed={speed}]", 15) for speed in ("2 mm/s", "10 mm/s")),
            ]
        metrics += [amount("batch_us", 0.9), amount("stream_us", 9.0), amount("roc_area", 0.99, "area")]
        return record.model_copy(update={"metrics": tuple(metrics)})

    return make


def block(*records):
    (only,) = slip_blocks(records)
    return only


def text(view):
    return console_table(view, 1000)


def test_the_papers_table_stands_above_ours_with_intervals(slip_record):
    view = table_iv(block(slip_record(), slip_record("energy", (0.0, 0.0, 0.0))))
    lines = text(view).splitlines()
    assert "20/20" in lines[2]
    assert "19/20 95 %, 76.4–99.1" in " ".join(lines[2].split())
    assert "59/60" in lines[2]
    assert sum("19/20" in line for line in lines[3:]) == 2
    assert "4/60" in text(view)


def test_only_the_papers_protocol_has_table_iv(slip_record):
    assert table_iv(block(slip_record(task="slip/hard/v1", variant="hard"))) is None


@pytest.mark.parametrize(
    ("difference", "said"),
    [
        ((5.0, 2.0, 9.0), "it loses (+2 to +9 ms)"),
        ((-5.0, -9.0, -2.0), "it alarms earlier (−9 to −2 ms)"),
        ((5.0, -2.0, 9.0), "no difference (−2 to +9 ms)"),
        ((MISSED_MS, 4.0, MISSED_MS), "it loses (+4 to +∞ ms)"),
    ],
)
def test_the_verdict_is_the_paired_interval_of_the_delays_whatever_the_area(slip_record, difference, said):
    (sentence,) = verdicts(block(slip_record(difference=difference), slip_record("energy", (0.0, 0.0, 0.0))))
    assert said in sentence
    assert "area" not in sentence


def test_where_one_kind_of_disturbance_tells_them_apart_the_verdict_says_it(slip_record):
    record = slip_record()
    by_kind = [
        ms("delay_minus_energy_ms@10[negatives=load_change]", 40.0, 12.0, MISSED_MS),
        ms("delay_ms@10[negatives=load_change]", 90.0, 80.0, MISSED_MS),
        ms("delay_minus_energy_ms@10[negatives=drift]", 4.0, -12.0, 15.0),
        ms("delay_ms@10[negatives=drift]", 90.0, 80.0, 99.0),
    ]
    (sentence,) = verdicts(block(record.model_copy(update={"metrics": (*record.metrics, *by_kind)})))
    assert "it loses to energy beside load change (+12 to +∞ ms)" in sentence
    assert "drift" not in sentence


def test_hard_negatives_stand_beside_the_slips_found_of_each_object(slip_record):
    called = (share("called[kind=tapping]", 20), share("called[kind=drift]", 5))
    record = slip_record(task="slip/hard/v1", variant="hard")
    record = record.model_copy(update={"metrics": record.metrics + called})
    (view,) = [view for view in slip_views(block(record)) if "hard negatives" in view.title]
    heads = [column.title for column in view.columns]
    assert heads[2:6] == ["Ball: found", "Cuboid: found", "Cylinder: found", "All slips found"]
    assert heads[-2:] == ["Tapping, %", "Drift, %"]
    (row,) = view.rows
    assert [cell.text for cell in row[2:6]] == ["19/20", "19/20", "19/20", "57/60"]
    assert [cell.text for cell in row[-2:]] == ["100.0", "25.0"]


@pytest.mark.parametrize(("measured", "tone"), [((0.02, 0.01, 0.03), "bad"), ((0.0012, 0.0008, 0.002), "")])
def test_what_cfar_was_asked_stands_beside_what_was_measured(slip_record, measured, tone):
    def rate(name, value, low, high):
        return Metric(name=name, value=value, direction="lower", n=3, groups=3, low=low, high=high)

    rates = (rate("asked_rate", 0.001, 0.0009, 0.0011), rate("rest_rate", *measured), amount("coloured", 1.0))
    record = slip_record(modality="cfar")
    record = record.model_copy(update={"metrics": record.metrics + rates})
    (view,) = [view for view in slip_views(block(record)) if view.title.startswith("cfar")]
    (row,) = view.rows
    assert row[3].tone == tone
    assert row[4].text == f"{1e3 * (measured[0] - 0.001):+,.2f}"
    assert not any(view.title.startswith("cfar") for view in slip_views(block(slip_record())))


def test_two_that_miss_most_slips_are_not_called_equal(slip_record):
    record = slip_record(difference=(0.0, 0.0, 0.0), delay=MISSED_MS)
    assert "both miss most slips" in verdicts(block(record))[0]
    (view, *_) = slip_views(block(record))
    assert "∞" in text(view)


def test_a_rate_that_the_trials_do_not_support_is_marked(slip_record):
    (view, *_) = slip_views(block(slip_record(minutes=4.0)))
    heads = [column.title for column in view.columns]
    assert "Delay at 1/min, ms †" in heads
    assert "Delay at 10/min, ms" in heads
    assert any(note.startswith("† 1 a minute") for note in view.notes)
    assert "too little time to support the rate" in verdicts(block(slip_record(minutes=4.0)))[0]


def test_the_board_says_it_all_and_the_console_less(slip_record, tmp_path):
    records = [slip_record(), slip_record("energy", (0.0, 0.0, 0.0)), slip_record("spectral", delay=70.0)]
    files = build_board(records, tmp_path, generated=datetime(2026, 1, 2, tzinfo=UTC))
    for page in (files.html.read_text(), files.markdown.read_text()):
        for words in ("Table IV of the paper beside ours", "Delay at fixed false alarms", "By speed", "it loses"):
            assert words in page
    assert "Delay against cost" in files.html.read_text()
    assert any(path.name == "slip.csv" for path in files.csv)
    printed = format_console(board_tables(records))
    assert "Delay at fixed false alarms" in printed
    assert "By speed" not in printed


def test_no_two_tables_of_a_board_have_the_same_title(slip_record, tmp_path):
    """The same protocol on other trials, both splits, and all kinds of tables."""
    more = (share("called[kind=tapping]", 20), share("called[kind=drift]", 5), amount("asked_rate", 0.001))
    more += tuple(
        each
        for kind in ("tapping", "drift")
        for each in (
            ms(f"delay_ms@10[negatives={kind}]", 9, 8, 9),
            amount(f"false_alarms_per_min@1[kind={kind}]", 1.0),
        )
    )
    hard = {"task": "slip/hard/v1", "variant": "hard"}
    records = [slip_record(split=split) for split in ("random", "held-out-object")]
    for name in ("hard+negatives", "seen"):
        made = {**hard, "dataset": name, "dataset_hash": f"{len(name)}" * 64}
        records += [slip_record(**made), slip_record(**made, role="probe", modality="total-force")]
    records = [record.model_copy(update={"metrics": (*record.metrics, *more)}) for record in records]
    files = build_board(records, tmp_path, generated=datetime(2026, 1, 2, tzinfo=UTC))
    text = files.markdown.read_text(encoding="utf-8")
    titles = re.findall(r"^### (.*)", text, re.MULTILINE)
    titles = [title for title in titles if title not in ("slip/fvsight/v1", "slip/hard/v1")]  # of the probes
    assert len(titles) > 20
    assert len(set(titles)) == len(titles)
    for name in ("hard+negatives", "seen"):
        assert f"Protocol hard, dataset {name}" in titles
        assert f"Delay at fixed false alarms · hard, dataset {name}, held-out object" in titles
        assert f"\n| hard, dataset {name} | held-out object" in text.partition("## What should not suffice")[2]
    assert "Protocol paper" in titles
    printed = [line for line in format_console(board_tables(records)).splitlines() if line.endswith("(simulated)")]
    assert len(set(printed)) == len(printed) > 8


def test_the_front_of_delay_against_cost_holds_what_no_cheaper_detector_beats(slip_record):
    def made(method, us, delay):
        record = slip_record(method, delay=delay)
        cost = [amount("batch_us", us) if each.name == "batch_us" else each for each in record.metrics]
        return record.model_copy(update={"metrics": tuple(cost)})

    def points(*records):
        figure = delay_figure(block(*records), "held-out-object", "x")
        (strip,) = figure.strips
        lines = [re.findall(r'<polyline points="([^"]*)" class="front"', str(panel)) for panel in strip.panels]
        assert lines[0] == lines[1]  # one a rate
        return [tuple(map(float, point.split(","))) for line in lines[0] for point in line.split()]

    dear, cheap, beaten = made("spectral", 9.0, 20.0), made("energy", 1.0, 60.0), made("covariance", 5.0, 60.0)
    line = points(dear, cheap, beaten)
    (x0, y0), (x1, y1), (x2, y2), (x3, y3) = line
    assert x0 < x1 == x2 < x3
    assert y0 == y1 < y2 == y3  # less delay is further down
    assert points(dear, cheap) == line
    missed = made("energy", 1.0, MISSED_MS)
    assert len(points(dear, missed, beaten)) == 4  # from beaten, which is cheaper, to dear
    assert points(missed, made("covariance", 5.0, MISSED_MS)) == []


def test_a_detector_that_was_handed_in_has_its_title_and_standing_and_a_flagged_one_is_not_drawn(slip_record):
    def given(status):
        block = Submission(id=status, title=f"Net, {status}", status=status, reason="odd")
        return slip_record(f"{status}@00000000", delay=1.0).model_copy(update={"submission": block})

    trials = block(slip_record(), slip_record("energy"), given("verified"), given("flagged"))
    (view, *_) = slip_views(trials)
    assert {row[1].text: row[1].badge for row in view.rows} == {
        "covariance": "",
        "energy": "",
        "Net, verified": "verified",
        "Net, flagged": "flagged",
    }
    figure = delay_figure(trials, "held-out-object", "x")
    assert [key.title for key in figure.legend] == ["covariance", "energy", "verified (00000000)"]


def test_every_metric_is_in_the_csv_by_its_parts(slip_record):
    record = slip_record()
    frame = metrics_frame([block(record)])
    assert len(frame) == len(record.metrics)
    by_speed = frame[(frame["what"] == "delay_ms") & (frame["per_minute"] == 10.0) & (frame["factor"] == "speed")]
    assert by_speed["level"].tolist() == ["2 mm/s", "10 mm/s"]


def test_the_newest_record_of_a_cell_counts(slip_record):
    old, new = slip_record(delay=40.0), slip_record(delay=50.0, seed=1)
    moved = new.provenance.model_copy(update={"started": datetime(2027, 1, 1, tzinfo=UTC)})
    assert block(new.model_copy(update={"provenance": moved}), old).of("held-out-object")[0].identity.seed == 1


def test_a_detector_that_misses_everything_stays_inside_its_panel(slip_record):
    figure = delay_figure(
        block(slip_record(delay=MISSED_MS), slip_record("energy", (0.0, 0.0, 0.0))), "held-out-object", "x"
    )
    assert figure is not None
    drawn = "".join(str(panel) for strip in figure.strips for panel in strip.panels)
    assert "∞" in drawn
    assert not any(float(y) < 0 for y in re.findall(r'y[12]?="(-?[\d.]+)"', drawn))
