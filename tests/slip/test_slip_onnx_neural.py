import numpy as np
import onnx
import pytest
from slip_sequences import disagreement
from slip_trials import stream_with_frames, trial, view

import slip
from slip.graph.builder import Graph
from slip.graph.camera import held_embedding
from slip.net_camera import Camera
from slip.neural import NeuralForceFrames
from slip.onnx_run import OnnxBatch, OnnxStream, load_session
from slip.training_trial import latest_frame

FLOAT32 = 2e-7


@pytest.fixture(scope="module")
def force_graphs(force_net, tmp_path_factory):
    return exported(force_net, tmp_path_factory.mktemp("force"))


@pytest.fixture(scope="module")
def frames_graphs(frames_net, tmp_path_factory):
    return exported(frames_net, tmp_path_factory.mktemp("frames"), **view(trial(200, samples=300)))


def exported(detector, folder, **film):
    for kind in ("batch", "stream"):
        report = slip.export_onnx(detector, folder / kind, kind, 4, **film)
        assert report.relative_difference <= FLOAT32
        assert report.samples > 2 * detector.settling
    return OnnxBatch(folder / "batch"), OnnxStream(folder / "stream")


def seen(seed, samples=300):
    """A trial whose forces are as a graph reads them."""
    found = trial(seed, samples=samples)
    return slip.TrainingTrial(found.force.astype(np.float32), found.state, **view(found))


@pytest.mark.parametrize("samples", [1, 2, 30, 31, 32, 400])
def test_both_graphs_of_the_force_net_score_as_it_does(force_net, force_graphs, samples):
    force = seen(201, 400).force[:samples]
    for graph in force_graphs:
        assert disagreement(graph.score(force), force_net.score(force), 31) <= FLOAT32


def test_both_graphs_of_the_camera_net_score_as_it_does(frames_net, frames_graphs):
    film = seen(202)
    expected = frames_net.score(film.force, **view(film))
    for graph in frames_graphs:
        assert disagreement(graph.score(film.force, **view(film)), expected, 31) <= FLOAT32
        assert disagreement(graph.score(film.force), frames_net.score(film.force), 31) <= FLOAT32


def test_a_stream_graph_takes_a_frame_with_the_sample_it_came_with(frames_net, frames_graphs):
    _, streaming = frames_graphs
    film = seen(203)
    streaming.reset()
    streamed = stream_with_frames(streaming, film)
    np.testing.assert_array_equal(streamed, streaming.score(film.force, **view(film)))
    streaming.reset()
    np.testing.assert_array_equal(stream_with_frames(streaming, film), streamed)


def test_sequences_with_unlike_frames_score_together_as_one_by_one(frames_graphs):
    batch, _ = frames_graphs
    films = [seen(204 + k) for k in range(3)]
    counts = [9, 4, 0]
    frames = np.stack([film.frames[:9] for film in films])
    at = np.stack([film.frame_samples[:9] for film in films])
    for row, count in enumerate(counts):
        at[row, count:] = 300 + np.arange(9 - count)  # beyond the end: never seen
    together = batch.score(np.stack([film.force for film in films]), frames=frames, frame_samples=at)
    for film, count, scores in zip(films, counts, together, strict=True):
        alone = batch.score(film.force, frames=film.frames[:count], frame_samples=film.frame_samples[:count])
        np.testing.assert_allclose(scores, alone, rtol=1e-6)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_reading_that_is_not_finite_is_never_hidden(force_net, force_graphs, frames_graphs, bad):
    film = seen(205)
    broken = film.force.copy()
    broken[100, 2] = bad
    told = np.zeros(300, dtype=bool)
    told[100 : 100 + force_net.settling] = True
    for graphs, given in ((force_graphs, {}), (frames_graphs, view(film))):
        clean = graphs[0].score(film.force, **given)
        for graph in graphs:
            scores = graph.score(broken, **given)
            np.testing.assert_array_equal(np.isnan(scores), told)
            assert disagreement(scores[~told], clean[~told], 300) <= FLOAT32


def test_a_spike_is_forgotten_after_the_window(force_net, force_graphs):
    force = seen(206).force
    spiked = force.copy()
    spiked[100] += 1e6
    gone = 100 + force_net.settling
    for graph in force_graphs:
        np.testing.assert_array_equal(graph.score(spiked)[gone:], graph.score(force)[gone:])


def test_weights_travel_as_float32(force_net, force_graphs, tmp_path):
    slip.export_onnx(force_net, tmp_path / "a", "stream", 4)
    stored = {(*c.dims, c.data_type) for c in onnx.load(tmp_path / "a").graph.initializer}
    for values in force_net.net.weights.values():
        assert (*values.shape, onnx.TensorProto.FLOAT) in stored
    assert OnnxStream(tmp_path / "a").metadata["detector"]["parameters"] == force_net.net.shape.parameters


@pytest.mark.parametrize("side", [(20, 24), (9, 31)])
def test_the_camera_part_alone_is_that_of_the_detector(frames_net, side):
    """Embeddings in the graph of a sequence against the camera's own stream, for frames of any size."""
    g = Graph(stream=False)
    force = g.input("force", onnx.TensorProto.DOUBLE, ["N", "T", 4])
    held = held_embedding(g, force, frames_net.net, *side)
    g.output("held", held, onnx.TensorProto.DOUBLE, ["N", "T", 4])
    film = trial(207, samples=200, side=side)
    session = load_session(g.model("camera").SerializeToString())
    feed = {"force": np.zeros((1, 200, 4)), "frames": film.frames[None], "frame_samples": film.frame_samples[None]}
    found = session.run(["held"], feed)[0][0]
    camera = Camera(frames_net.net)
    embeddings = [camera.embedding.copy()]
    for frame in film.frames:
        camera.push(frame)
        embeddings.append(camera.embedding.copy())
    np.testing.assert_allclose(found, np.array(embeddings)[latest_frame(film.frame_samples, 200)], rtol=1e-10)


def test_a_camera_net_is_exported_for_the_frames_it_is_given(frames_net, frames_graphs, tmp_path):
    with pytest.raises(ValueError, match="to check a net with a camera"):
        slip.export_onnx(frames_net, tmp_path / "a", "batch", 4)
    assert not list(tmp_path.iterdir())
    batch, streaming = frames_graphs
    other = np.zeros((1, 20, 23, 3), dtype=np.uint8)
    with pytest.raises(ValueError, match="expected frames uint8"):
        batch.score(np.zeros((5, 4)), frames=other, frame_samples=[0])
    with pytest.raises(ValueError, match="expected a frame uint8"):
        streaming.update(np.zeros(4), frame=other[0])


def test_a_net_is_exported_for_its_own_taxels(force_net, tmp_path):
    with pytest.raises(ValueError, match="n_taxels=4"):
        slip.export_onnx(force_net, tmp_path / "a")


@pytest.mark.slow
def test_a_net_of_full_size_over_a_minute(tmp_path):
    trials = [trial(seed, samples=1000, taxels=16) for seed in range(4)]
    detector = NeuralForceFrames().fit(trials, epochs=1)
    film = trial(210, samples=60_000, taxels=16)
    force = film.force.astype(np.float32)
    expected = detector.score(force, **view(film))
    for kind, runner, samples in (("batch", OnnxBatch, 60_000), ("stream", OnnxStream, 8_000)):
        report = slip.export_onnx(detector, tmp_path / kind, kind, **view(trials[0]))
        assert report.relative_difference <= FLOAT32
        scores = runner(tmp_path / kind).score(force[:samples], **view(film))
        assert disagreement(scores, expected[:samples], detector.window) <= FLOAT32
