"""Pictures: what they show is chosen and scaled as said, and they are drawn without a display."""

import cv2
import numpy as np
import pandas as pd
import pytest

from tests.vtbench.data import fakes
from vtbench.data import Dataset, import_folder, write_dataset
from vtbench.data.fabricslide16 import FabricSlide16
from vtbench.show import contact_sheet, difference, force_history, line_styles, pick_samples, show, slide_traces


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return write_dataset(
        tmp_path_factory.mktemp("show") / "set",
        fakes.FakeScene(),
        truth=("pressure",),
        simulate=fakes.simulate,
        describe=fakes.describe,
    )


def picture(path):
    image = cv2.imread(str(path))
    assert image is not None
    return image


def test_samples_show_different_objects_and_both_presses(folder):
    frame = Dataset.open(folder).columns()
    chosen = pick_samples(frame, 4)
    assert len(set(frame["object"][chosen])) == 4
    assert set(frame["press"][chosen]) == {"deep", "shallow"}
    many = pick_samples(frame, 12)
    assert len(set(many)) == 12
    assert set(frame["unit"][many]) == {0, 1}


def test_no_more_samples_are_picked_than_there_are():
    frame = pd.DataFrame({"label": [0, 1], "press": ["deep", "deep"], "unit": [0, 0]})
    assert sorted(pick_samples(frame, 12)) == [0, 1]


def test_a_difference_is_grey_where_nothing_changed_and_antisymmetric():
    rng = np.random.default_rng(0)
    a, b = rng.integers(100, 140, (2, 5, 5, 3)).astype(np.uint8)
    assert (difference(a, a, 8.0) == 128).all()
    np.testing.assert_array_equal(difference(a, b, 2.0).astype(int) + difference(b, a, 2.0), 256)


def test_the_contact_sheet_has_a_panel_more_with_pressure(folder, tmp_path):
    plain = write_dataset(
        tmp_path / "plain", fakes.FakeScene(), samples=8, simulate=fakes.simulate, describe=fakes.describe
    )
    with_truth = picture(contact_sheet(folder, tmp_path / "a.png", count=4))
    without = picture(contact_sheet(plain, tmp_path / "b.png", count=4))
    assert with_truth.shape[1] / without.shape[1] == pytest.approx(4 / 3, abs=0.1)


def test_the_same_dataset_gives_the_same_picture(folder, tmp_path):
    first = contact_sheet(folder, tmp_path / "a.png", count=2).read_bytes()
    assert first == contact_sheet(folder, tmp_path / "b.png", count=2).read_bytes()
    assert first != contact_sheet(folder, tmp_path / "c.png", count=3).read_bytes()


def test_one_press_in_time_depends_on_the_press(folder, tmp_path):
    first = force_history(folder, 0, tmp_path / "a.png").read_bytes()
    assert first != force_history(folder, 1, tmp_path / "b.png").read_bytes()


def inked(style, at):
    """Whether a line of this Matplotlib style has ink at the places `at`, in line widths from its start."""
    if style == "-":
        return np.ones(at.shape, bool)
    offset, (dash, gap) = style
    return (at + offset) % (dash + gap) < dash


def test_traces_on_one_another_take_turns_and_none_is_hidden():
    rng = np.random.default_rng(0)
    press = np.sin(np.linspace(0, np.pi, 200))
    series = np.outer(press, [1.5, 1.5, 1.5, 1.0, 0.6, 0.6]) + 1e-3 * rng.standard_normal((200, 6))
    styles = line_styles(series, 0.03)
    assert [style == "-" for style in styles] == [False, False, False, True, False, False]
    at = np.arange(0.5, 150.0)
    for together in ((0, 1, 2), (4, 5)):
        np.testing.assert_array_equal(sum(inked(styles[trace], at).astype(int) for trace in together), 1)
    assert set(line_styles(series, 1e-6)) == {"-"}


def test_imported_frames_without_history_or_square_array_are_drawn(tmp_path):
    for name in ("a", "b"):
        cv2.imwrite(str(tmp_path / f"{name}.png"), np.full((12, 16, 3), 90, np.uint8))
    (tmp_path / "forces.csv").write_text("file,object,f1,f2,f3\na.png,cup,1,2,3\nb.png,pen,0,1,-0.1\n")
    out = import_folder(tmp_path, tmp_path / "set")
    picture(show(out, tmp_path / "sheet.png"))
    with pytest.raises(ValueError, match="no force histories"):
        show(out, tmp_path / "x.png", sample=0)


def test_a_run_shows_its_dataset(folder, tmp_path):
    (tmp_path / "run/datasets").mkdir(parents=True)
    (tmp_path / "run/datasets/presses").symlink_to(folder)
    expected = contact_sheet(folder, tmp_path / "a.png").read_bytes()
    assert show(tmp_path / "run", tmp_path / "b.png").read_bytes() == expected


def test_sliding_recordings_are_drawn_fabric_by_fabric(tmp_path):
    rng = np.random.default_rng(0)
    names = np.array(["Canvas", "Denim", "Linen", "Canvas", "Wool", "Felt"])
    n = len(names)
    recordings = FabricSlide16(
        series=[rng.normal(100, 10, (50, 16)) for _ in range(n)],
        proximity=[np.zeros((50, 2))] * n,
        time_ms=[np.arange(50) * 28.0] * n,
        fabric=names,
        setting=np.full(n, 180),
        speed=np.full(n, -20),
        repetition=np.zeros(n, int),
        path=[""] * n,
    )
    picture(slide_traces(recordings, tmp_path / "slide.png"))


def test_what_cannot_be_drawn_is_said_in_one_line(folder, tmp_path):
    with pytest.raises(ValueError, match="nothing to draw; expected a dataset"):
        show(tmp_path, tmp_path / "x.png")
    with pytest.raises(ValueError, match=r"sample indices must lie in 0\.\.25"):
        show(folder, tmp_path / "x.png", sample=26)
    (tmp_path / "file").touch()
    with pytest.raises(OSError, match="cannot write here"):
        show(folder, tmp_path / "file" / "x.png")
