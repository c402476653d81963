import functools
import json

import numpy as np
import onnx
import onnxruntime
import pytest
from slip_sequences import disagreement, eventful, rest, stream

import slip
from slip.covariance import Covariance
from slip.detector import Detector
from slip.energy import Energy
from slip.graph.parity import Parity, compare
from slip.onnx import build_model
from slip.onnx_run import OnnxBatch, OnnxStream
from slip.spectral import Spectral

FLOAT32 = 2e-7  # rounding of a score, with room


def read(force):
    """As a graph reads forces."""
    return np.asarray(force).astype(np.float32).astype(np.float64)


@functools.cache
def graphs(name, window, taxels=16):
    detector = slip.make_detector(name, window=window)
    return detector, *(of(detector, taxels) for of in (batch_of, stream_of))


def batch_of(detector, taxels):
    return OnnxBatch(build_model(detector, "batch", taxels, None).SerializeToString())


def stream_of(detector, taxels):
    return OnnxStream(build_model(detector, "stream", taxels, None).SerializeToString())


@pytest.fixture(params=slip.detector_names())
def name(request):
    return request.param


@pytest.mark.parametrize("window", [2, 17, 50])
def test_batch_and_stream_graphs_score_as_the_detector_does_also_after_a_spike(name, window):
    detector, batch, streaming = graphs(name, window)
    force = read(eventful(600, spike_at=200))
    expected = detector.score(force)
    assert disagreement(batch.score(force), expected, window) <= FLOAT32
    assert disagreement(streaming.score(force), expected, window) <= FLOAT32


@pytest.mark.parametrize("samples", [0, 1, 2, 15, 16, 17, 49, 50, 51, 52, 99, 100, 101])
def test_sequences_that_end_anywhere_in_a_window_or_a_tile(name, samples):
    detector, batch, streaming = graphs(name, 50)
    force = read(eventful(360)[200 : 200 + samples])
    expected = detector.score(force)
    for scores in (batch.score(force), streaming.score(force)):
        assert scores.shape == (samples,)
        assert disagreement(scores, expected, 50) <= FLOAT32


def test_sequences_score_together_as_one_by_one(name):
    _, batch, _ = graphs(name, 17)
    force = np.stack([eventful(150, seed=seed) for seed in range(4)])
    np.testing.assert_array_equal(batch.score(force), [batch.score(each) for each in force])


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_reading_that_is_not_finite_is_never_hidden_and_leaves_nothing_behind(name, bad):
    detector, batch, streaming = graphs(name, 17)
    force = read(eventful(300))
    broken = force.copy()
    broken[120, 3] = bad
    broken[0, 0] = bad
    told = np.zeros(300, dtype=bool)
    for at in (0, 120):
        told[at : at + detector.settling] = True
    clean = batch.score(force)
    for scores in (batch.score(broken), streaming.score(broken)):
        np.testing.assert_array_equal(np.isnan(scores), told)
        assert disagreement(scores[~told], clean[~told], 300) <= FLOAT32


def test_a_sequence_without_any_reading_has_no_score(name):
    _, batch, streaming = graphs(name, 17)
    nothing = np.full((60, 16), np.nan)
    assert np.isnan(batch.score(nothing)).all()
    assert np.isnan(streaming.score(nothing)).all()


def test_a_gap_in_one_sequence_is_not_seen_in_another(name):
    _, batch, _ = graphs(name, 17)
    force = np.stack([eventful(100), eventful(100, seed=1)])
    alone = batch.score(force[1])
    force[0, 50] = np.nan
    np.testing.assert_array_equal(batch.score(force)[1], alone)


def test_a_stream_graph_is_a_detector_that_forgets_when_told(name):
    _, _, streaming = graphs(name, 17)
    assert isinstance(streaming, Detector)
    force = eventful(80)
    streaming.reset()
    first = stream(streaming, force)
    again = stream(streaming, force)
    streaming.reset()
    half = stream(streaming, force[:40])
    np.testing.assert_array_equal(streaming.score(force), first)  # and leaves the stream where it was
    np.testing.assert_array_equal(np.concatenate([half, stream(streaming, force[40:])]), first)
    assert not np.array_equal(again, first)


def test_forces_that_stand_still_score_zero_exactly(name):
    _, batch, streaming = graphs(name, 17)
    still = np.tile(np.linspace(0.0, 50.0, 16), (60, 1))
    assert (batch.score(still) == 0.0).all()
    assert (streaming.score(still) == 0.0).all()


@pytest.mark.parametrize("taxels", [1, 3])
def test_any_number_of_taxels_and_each_with_its_scale(name, taxels):
    detector = slip.make_detector(name, window=9, scale=np.geomspace(1e-3, 1e-2, taxels))
    force = read(eventful(200, taxels))
    expected = detector.score(force)
    assert disagreement(batch_of(detector, taxels).score(force), expected, 9) <= FLOAT32
    assert disagreement(stream_of(detector, taxels).score(force), expected, 9) <= FLOAT32


def test_taps_of_the_high_pass_are_those_of_the_detector():
    detector = Spectral(12, cutoff_hz=200.0, taps=5, common_mode="mean")
    force = read(eventful(200))
    for graph in (batch_of(detector, 16), stream_of(detector, 16)):
        assert disagreement(graph.score(force), detector.score(force), 12) <= FLOAT32


def test_the_file_keeps_to_the_contract(tmp_path):
    for kind in ("batch", "stream"):
        slip.export_onnx(Covariance(5), tmp_path / f"{kind}.onnx", kind, n_taxels=4)
    inputs, outputs = ports(tmp_path / "batch.onnx")
    assert inputs == {"force_series": (onnx.TensorProto.FLOAT, ["N", "T", 4])}
    assert outputs == {"slip_score": (onnx.TensorProto.FLOAT, ["N", "T"])}
    inputs, outputs = ports(tmp_path / "stream.onnx")
    assert inputs.pop("force") == (onnx.TensorProto.FLOAT, [1, 4])
    assert outputs.pop("slip_score") == (onnx.TensorProto.FLOAT, [1, 1])
    assert inputs
    assert all(name.startswith("state_") for name in inputs)
    assert {f"{name}_out": port for name, port in inputs.items()} == outputs
    model = onnx.load(tmp_path / "stream.onnx")
    assert {node.domain for node in model.graph.node} == {""}


def ports(path):
    def shape(port):
        kind = port.type.tensor_type
        return kind.elem_type, [dim.dim_param or dim.dim_value for dim in kind.shape.dim]

    graph = onnx.load(path).graph
    return ({port.name: shape(port) for port in ends} for ends in (graph.input, graph.output))


def test_the_report_is_measured_on_the_given_samples_and_stands_in_the_file(tmp_path):
    check = eventful(321, spike_at=100)
    for kind, runner in (("batch", OnnxBatch), ("stream", OnnxStream)):
        path = tmp_path / "a.onnx"
        report = slip.export_onnx(Energy(7), path, kind, check=check)
        scores, expected = runner(path).score(check), Energy(7).score(read(check))
        assert report.largest_difference == np.abs(scores - expected).max() > 0.0
        assert (report.samples, report.onnxruntime) == (321, onnxruntime.__version__)
        metadata = runner(path).metadata
        assert metadata["parity"] == report.to_dict()
        assert metadata["kind"] == kind
        assert metadata["settling"] == 8
        assert metadata["detector"] == {"class": "Energy", "window": 7, "scale": None, "common_mode": "keep"}


def test_the_same_detector_gives_the_same_file(tmp_path):
    for path in ("a", "b"):
        slip.export_onnx(Spectral(5), tmp_path / path, "stream")
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()
    entries = {p.key: p.value for p in onnx.load(tmp_path / "a").metadata_props}
    assert json.loads(entries["slip"])["detector"]["cutoff_hz"] == 150.0


class Own(Energy):
    """A subclass may score in its own way."""


@pytest.mark.parametrize(
    ("detector", "arguments", "says"),
    [
        (Energy(5, nan="skip"), {}, "skip"),
        (Own(5), {}, "Own has no graph"),
        (Energy(5, scale=np.ones(4)), {}, "n_taxels=4"),
        (Energy(5), {"n_taxels": 0}, "n_taxels"),
        (Energy(5), {"kind": "both"}, '"batch" or "stream"'),
        (Covariance(1025), {}, "up to 1024"),
        (Energy(5), {"check": np.full((9, 16), np.nan)}, "finite"),
        (Energy(5), {"check": np.zeros((9, 15))}, r"\(N, T, 16\)"),
        (slip.NeuralForce(), {}, "learnt nothing"),
    ],
)
def test_what_cannot_be_exported_exactly_is_refused_and_nothing_written(tmp_path, detector, arguments, says):
    with pytest.raises(ValueError, match=says):
        slip.export_onnx(detector, tmp_path / "a.onnx", **arguments)
    assert not list(tmp_path.iterdir())


def test_scores_that_differ_beyond_float32_are_refused():
    scores = np.linspace(1.0, 2.0, 50)
    assert compare(scores * (1 + 5e-8), scores, 10, "1") == Parity(pytest.approx(1e-7), pytest.approx(5e-8), 50, "1")
    for wrong in (scores * (1 + 5e-6), np.where(scores > 1.5, np.nan, scores)):
        with pytest.raises(ValueError, match="no file was written"):
            compare(wrong, scores, 10, "1")


def test_files_of_the_other_kind_or_of_none_are_refused(tmp_path):
    slip.export_onnx(Energy(5), tmp_path / "a.onnx")
    with pytest.raises(ValueError, match="no stream graph of a slip detector"):
        OnnxStream(tmp_path / "a.onnx")
    (tmp_path / "b.onnx").write_text("nothing")
    with pytest.raises(ValueError, match="ONNX Runtime can load"):
        OnnxBatch(tmp_path / "b.onnx")
    with pytest.raises(FileNotFoundError):
        OnnxBatch(tmp_path / "c.onnx")


def test_samples_and_sequences_of_another_shape_are_refused():
    _, batch, streaming = graphs("energy", 17)
    with pytest.raises(ValueError, match=r"\(16,\)"):
        streaming.update(np.zeros(4))
    with pytest.raises(ValueError, match=r"\(T, 16\)"):
        streaming.score(np.zeros(16))
    with pytest.raises(ValueError, match=r"\(N, T, 16\)"):
        batch.score(np.zeros((5, 4)))


def test_a_score_beyond_float32_is_infinite_and_not_a_finite_one():
    force = np.zeros((30, 16))
    force[10:] = 1e30
    assert np.isinf(graphs("covariance", 17)[1].score(force + rest(30))).sum() == 0  # one difference has no pair
    force[20:] = -1e30
    scores = graphs("covariance", 17)[1].score(force)
    assert np.isinf(scores[20:26]).all()
    assert np.isfinite(scores[:20]).all()


@pytest.mark.slow
@pytest.mark.parametrize("window", [50, 1024])
def test_a_minute_with_a_spike_and_long_windows(name, window):
    samples = 60_000 if window == 50 else 6_000
    detector, batch, streaming = graphs(name, window)
    force = read(eventful(samples, spike_at=samples // 6))
    expected = detector.score(force)
    assert disagreement(batch.score(force), expected, window) <= FLOAT32
    part = force[: 12_000 if window == 50 else 2_500]
    assert disagreement(streaming.score(part), expected[: len(part)], window) <= FLOAT32
