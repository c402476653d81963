"""Laws of the fusion nets: missing modalities, the choice of the epoch, determinism, files, graphs."""

import warnings

import numpy as np
import pytest

from fusion.neural import FusionTransformer, LateFusionNet
from fusion.neural.folds import held_back_folds
from fusion.neural.layout import Layout
from fusion.neural.net import patches, start_weights
from fusion.neural.ops import NumpyOps, TorchOps
from fusion.neural.training import Schedule, drop_modalities
from fusion.onnx import EXPORTERS, class_path

CLASSES = 4
MODALITIES = {"image": slice(0, 192), "force": slice(192, 256)}
SHAPES = {"image": (3, 8, 8), "force": (16, -1)}
NETS = [LateFusionNet, FusionTransformer]


def samples(n, seed):
    """Images 3 x 8 x 8 and series of 16 steps of 4 taxels; either tells the class."""
    means = np.random.default_rng(0).standard_normal((CLASSES, 256))
    y = np.arange(n) % CLASSES
    return means[y] + 0.8 * np.random.default_rng(seed).standard_normal((n, 256)), y


def net(kind, **params):
    small = {"epochs": 15, "width": 16, "validation_folds": 0, **params}
    return kind(MODALITIES, SHAPES, **small)


@pytest.fixture(scope="module", params=NETS, ids=lambda kind: kind.__name__)
def fitted(request):
    return net(request.param).fit(*samples(96, 1))


def test_learnt_with_dropout_either_modality_alone_beats_chance(fitted):
    X, y = samples(80, 2)
    assert (fitted.predict(X) == y).mean() > 0.9
    for missing in ("image", "force"):
        assert (fitted.predict(X, missing=(missing,)) == y).mean() > 0.6  # chance 0.25


def test_a_missing_modality_is_not_looked_at(fitted):
    X, _ = samples(20, 3)
    one = fitted.decision_function(X, missing=("image",))
    for dead in (np.nan, np.inf, 1e6):
        other = X.copy()
        other[:, MODALITIES["image"]] = dead
        np.testing.assert_array_equal(fitted.decision_function(other, missing=("image",)), one)
    with pytest.raises(ValueError, match="NaN"):
        fitted.predict(np.full_like(X, np.nan), missing=("image",))
    assert not np.allclose(fitted.decision_function(X), fitted.decision_function(other))


@pytest.mark.parametrize("kind", NETS)
def test_rows_masked_in_training_are_what_is_left_out_in_prediction(kind):
    """`present` of a batch equals leaving the modality out; torch equals NumPy."""
    import torch

    made = net(kind)._sized(Layout.of(MODALITIES, SHAPES, 256), CLASSES)
    weights = start_weights(made, np.random.default_rng(0))
    X, _ = samples(6, 4)
    parts = {part.name: part.of(X).astype(np.float32) for part in made.layout.parts}
    for there in ([1, 1], [0, 1], [1, 0]):
        kept = {name: values for (name, values), keep in zip(parts.items(), there, strict=True) if keep}
        left_out = made.logits(NumpyOps(), weights, kept)
        masked = made.logits(
            TorchOps(),
            {name: torch.from_numpy(values) for name, values in weights.items()},
            {name: torch.from_numpy(values) for name, values in parts.items()},
            torch.tensor([there] * 6, dtype=torch.float32),
        )
        np.testing.assert_allclose(masked.numpy(), left_out, rtol=1e-3, atol=1e-4)


def test_dropout_leaves_one_modality_at_least_and_takes_the_share_it_should():
    rng = np.random.default_rng(0)
    present = drop_modalities(20_000, 3, 0.4, rng)
    assert present.sum(axis=1).min() == 1
    assert abs((present.sum(axis=1) < 3).mean() - 0.4) < 0.02
    assert np.ptp(present.mean(axis=0)) < 0.02
    assert drop_modalities(50, 1, 1.0, rng).all()
    assert drop_modalities(50, 2, 0.0, rng).all()


@pytest.mark.parametrize("kind", NETS)
def test_the_same_seed_gives_the_same_net_and_leaves_torch_alone(kind):
    import torch

    X, y = samples(40, 5)
    torch.manual_seed(1)
    before = torch.random.get_rng_state()
    one = net(kind, epochs=2).fit(X, y).decision_function(X)
    assert torch.equal(torch.random.get_rng_state(), before)
    torch.manual_seed(2)
    np.testing.assert_array_equal(net(kind, epochs=2).fit(X, y).decision_function(X), one)
    assert not np.allclose(net(kind, epochs=2, random_state=1).fit(X, y).decision_function(X), one)


def test_the_epoch_is_chosen_where_the_held_back_loss_is_least():
    X, y = samples(48, 6)
    guessed = np.random.default_rng(0).permutation(y)  # labels without meaning: learning longer only remembers them
    params = {"noise": 0.0, "label_smoothing": 0.0, "modality_dropout": 0.0, "validation_folds": 3}
    made = net(LateFusionNet, epochs=30, **params).fit(X, guessed)
    assert len(made.validation_loss_) == 30
    assert made.n_epochs_ == made.validation_loss_.argmin() + 1 < 30


def test_folds_hold_back_whole_groups_or_deal_classes_evenly():
    rng = np.random.default_rng(0)
    y, units = np.arange(60) % 3, np.repeat([7, 8, 9], 20)
    by_unit = held_back_folds(y, units, 3, rng)
    assert [set(units[held]) for _, held in by_unit] == [{7}, {8}, {9}]
    assert all(not set(units[learnt]) & set(units[held]) for learnt, held in by_unit)
    dealt = held_back_folds(y, np.zeros(60), 3, rng)  # one group cannot be held back
    assert sorted(np.concatenate([held for _, held in dealt])) == list(range(60))
    assert all(np.ptp(np.bincount(y[held])) <= 1 for _, held in dealt)
    assert held_back_folds(np.array([0, 1]), None, 2, rng) == []  # a class would be held back unlearnt


def test_patches_are_the_squares_of_the_image():
    image = np.random.default_rng(0).standard_normal((2, 3, 6, 4))
    got = patches(image, (3, 6, 4), 3, 2)
    assert got.shape == (2, 4, 18)
    for number, (row, column) in enumerate([(0, 0), (0, 2), (3, 0), (3, 2)]):
        square = image[1, :, row : row + 3, column : column + 2]
        np.testing.assert_array_equal(np.sort(got[1, number]), np.sort(square.ravel()))


def test_the_rate_rises_then_falls_to_nothing():
    rates = [Schedule(10, 8, 1.0, 0, 0, 0, 0).rate(t) for t in np.linspace(0, 1, 101)]
    assert rates[0] == 0.0
    assert max(rates) == rates[10] == 1.0
    assert (np.diff(rates[10:]) < 0).all()
    assert rates[-1] < 1e-12


def test_a_saved_net_answers_as_before(fitted, tmp_path):
    X, _ = samples(10, 7)
    again = type(fitted).load(fitted.save(tmp_path / "net.npz"))
    np.testing.assert_array_equal(again.decision_function(X), fitted.decision_function(X))
    np.testing.assert_array_equal(again.predict(X, missing=("force",)), fitted.predict(X, missing=("force",)))
    other = NETS[fitted.__class__ is NETS[0]]
    with pytest.raises(ValueError, match=f"holds a {type(fitted).__name__}"):
        other.load(tmp_path / "net.npz")
    (tmp_path / "net.npz").write_bytes(b"PK something else")
    with pytest.raises(ValueError, match="no saved fusion net"):
        type(fitted).load(tmp_path / "net.npz")
    assert [path.name for path in tmp_path.iterdir()] == ["net.npz"]


@pytest.mark.parametrize(
    "given",
    [
        {"image": slice(0, 192), "force": slice(192, None)},
        {"image": slice(None, -64), "force": slice(-64, 256)},
        {"image": np.arange(256) < 192, "force": (np.arange(256) >= 192).tolist()},
        {"image": slice(191, None, -1), "force": range(192, 256)},
    ],
    ids=["open", "negative", "masks", "backwards"],
)
def test_a_net_is_saved_with_the_columns_that_it_learnt_from(given, tmp_path):
    X, y = samples(24, 9)
    made = LateFusionNet(given, SHAPES, epochs=1, width=8, validation_folds=0).fit(X, y)
    again = LateFusionNet.load(made.save(tmp_path / "net.npz"))
    np.testing.assert_array_equal(again.decision_function(X), made.decision_function(X))
    columns = {part.name: part.columns for part in made._net.layout.parts}
    assert {name: tuple(each) for name, each in again.modalities.items()} == columns
    assert sorted(columns["image"]) == list(range(192))


def test_modalities_that_a_file_cannot_name_are_refused(tmp_path):
    made = LateFusionNet({0: slice(0, 256)}, epochs=1, width=8, validation_folds=0).fit(*samples(8, 9))
    with pytest.raises(ValueError, match="names of text"):
        made.save(tmp_path / "net.npz")
    with pytest.raises(ValueError, match="missing names 1; the modalities are 0"):
        made.predict(samples(2, 0)[0], missing=(1,))


@pytest.mark.parametrize("params", [{"learning_rate": 1e9}, {"learning_rate": 1e9, "validation_folds": 2}], ids=str)
@pytest.mark.parametrize("kind", NETS)
def test_learning_that_diverges_is_refused(kind, params):
    with pytest.raises(ValueError, match=r"learning diverged: .* learning_rate=1000000000\.0"):
        net(kind, **{"epochs": 12, **params}).fit(*samples(40, 1))


def test_the_graph_answers_as_the_net(fitted):
    import onnxruntime
    from onnx import TensorProto

    from fusion.onnx import add_estimator
    from fusion.onnx.builder import Graph

    assert class_path(fitted) in EXPORTERS
    g = Graph()
    x = g.double(g.input("x", TensorProto.FLOAT, ["N", 256]))
    g.output("scores", g.op("Cast", add_estimator(g, fitted, x), to=TensorProto.FLOAT), ["N", CLASSES])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        session = onnxruntime.InferenceSession(g.model("net").SerializeToString(), providers=["CPUExecutionProvider"])
    X = samples(50, 8)[0].astype(np.float32)
    scores = session.run(None, {"x": X})[0]
    np.testing.assert_allclose(scores, fitted.decision_function(X), rtol=1e-5, atol=1e-5)
    assert np.array_equal(scores.argmax(1), fitted.predict(X))
    np.testing.assert_allclose(session.run(None, {"x": X[3:4]})[0], scores[3:4], rtol=1e-6)


@pytest.mark.parametrize(
    ("params", "match"),
    [
        ({"modalities": {"a": slice(0, 300)}}, "do not fit the 256 columns"),
        ({"shapes": {"sound": (2, 8)}}, "shapes name sound"),
        ({"shapes": {"image": (3, 7, 8)}}, "does not fold 192 columns"),
        ({"shapes": {"image": (3, 8, 8, 1)}}, "does not fold"),
        ({"epochs": 0}, "epochs must be a whole number of at least 1"),
        ({"validation_folds": 1}, "validation_folds must be 0 or at least 2"),
        ({"modality_dropout": 1.5}, "modality_dropout must lie in 0 to 1"),
        ({"learning_rate": 0}, "learning_rate must be positive"),
        ({"learning_rate": np.inf}, "learning_rate must be positive and finite"),
        ({"learning_rate": "x"}, "learning_rate must be positive and finite"),
        ({"noise": "x"}, "noise must be finite and not negative"),
        ({"modality_dropout": None}, "modality_dropout must lie in 0 to 1"),
        ({"device": "tpu"}, "'cpu' or 'cuda'"),
        ({"device": None}, "'cpu' or 'cuda'"),
        ({"heads": 3, "width": 16}, "multiple of heads"),
    ],
)
def test_wrong_settings_are_refused(params, match):
    with pytest.raises(ValueError, match=match):
        FusionTransformer(**{"modalities": MODALITIES, "shapes": SHAPES, **params}).fit(*samples(8, 0))


def test_a_gpu_that_is_not_there_is_refused():
    import torch

    if torch.cuda.is_available():
        pytest.skip("there is one")
    with pytest.raises(ValueError, match="no CUDA device"):
        net(LateFusionNet, device="cuda").fit(*samples(8, 0))


@pytest.mark.parametrize(
    ("missing", "match"), [(("sound",), "names sound"), (("image", "force"), "every modality"), ("image", "a text")]
)
def test_missing_names_must_make_sense(fitted, missing, match):
    with pytest.raises(ValueError, match=match):
        fitted.predict(samples(2, 0)[0], missing=missing)
