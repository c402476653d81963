"""Ball presses: as published, even numbers only; from the folder and from the fetched archive."""

import numpy as np
import pytest

from vtbench.data import fetching, load_gelsight_ball_presses
from vtbench.data.gelsight_ball_presses import keep_even_presses
from vtbench.data.manifest import manifest_of
from vtbench.data.png import encode_png
from vtbench.data.public import PublicSet, cached_root
from vtbench.gelsight_calibration import main
from vtbench.show import show

HEADING = "file,center_x_px,center_y_px,contact_radius_px\n"


def frame(seed):
    return np.random.default_rng(seed).integers(0, 256, (480, 640, 3), dtype=np.uint8)


@pytest.fixture
def root(tmp_path):
    folder = tmp_path / "set/gelsight"
    folder.mkdir(parents=True)
    for name, seed in (("background", 9), ("press_00", 0), ("press_02", 2)):
        (folder / f"{name}.png").write_bytes(encode_png(frame(seed)))
    (folder / "presses.csv").write_text(HEADING + "press_00.png,299.0,220.0,63\npress_02.png,296.5,302.0,59\n")
    return tmp_path / "set"


def test_frames_circles_and_scale_come_from_the_folder(root):
    data = load_gelsight_ball_presses(root)
    assert np.array_equal(data.rest, frame(9))
    assert [press.number for press in data.presses] == [0, 2]
    assert np.array_equal(data.presses[1].frame, frame(2))
    circles = [(press.center_x_px, press.center_y_px, press.contact_radius_px) for press in data.presses]
    assert circles == [(299.0, 220.0, 63.0), (296.5, 302.0, 59.0)]
    assert (data.ball_radius_mm, data.pixel_mm) == (2.0, 0.0295)


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("press_03.png,1,2,3", "line 2: press_03.png is odd-numbered"),
        ("ball.png,1,2,3", "line 2: expected a name such as press_04.png"),
        ("press_00.png,1,two,3", "line 2: expected numbers"),
        ("press_00.png,1", "line 2: expected numbers"),
        ("press_00.png,1,2,0", "positive radius"),
        ("press_00.png,nan,2,3", "finite"),
        ("press_04.png,1,2,3", r"press_04\.png: no such file; `vtbench fetch gelsight_ball_presses`"),
        ("", "no presses"),
    ],
)
def test_a_table_of_another_form_is_named(root, line, message):
    (root / "gelsight/presses.csv").write_text(HEADING + line + "\n")
    with pytest.raises(ValueError, match=message) as failure:
        load_gelsight_ball_presses(root)
    assert "\n" not in str(failure.value)


def test_other_columns_a_damaged_frame_and_an_empty_folder_are_named(root, tmp_path):
    (root / "gelsight/press_02.png").write_bytes(b"\x89PNG\r\n\x1a\nrest")
    with pytest.raises(ValueError, match=r"press_02\.png: truncated"):
        load_gelsight_ball_presses(root)
    (root / "gelsight/presses.csv").write_text("file,x\n")
    with pytest.raises(ValueError, match="expected the columns file, center_x_px"):
        load_gelsight_ball_presses(root)
    with pytest.raises(ValueError, match="`vtbench fetch gelsight_ball_presses` brings"):
        load_gelsight_ball_presses(tmp_path / "nowhere")


def archive(folder, count=4):
    """As published: all numbers, channels in the order of BGR."""
    folder.mkdir(parents=True)
    frames = np.stack([frame(number) for number in range(count)])[..., ::-1]
    centers = np.arange(2.0 * count).reshape(count, 2)
    np.savez(
        folder / "dataPack.npz",
        f0=frame(9)[..., ::-1],
        imgs=frames,
        touch_center=centers,
        touch_radius=np.arange(count) + 50,
    )


def test_the_archive_gives_its_even_presses_alone(tmp_path):
    archive(tmp_path / "download")
    keep_even_presses(tmp_path / "download", tmp_path / "out")
    data = load_gelsight_ball_presses(tmp_path / "out")
    assert np.array_equal(data.rest, frame(9))
    assert [press.number for press in data.presses] == [0, 2]
    assert all(np.array_equal(press.frame, frame(press.number)) for press in data.presses)
    assert [(p.center_x_px, p.center_y_px, p.contact_radius_px) for p in data.presses] == [(0, 1, 50), (4, 5, 52)]
    assert len(list((tmp_path / "out/gelsight").iterdir())) == 4


@pytest.mark.parametrize("fails_first", [False, True])
def test_fetching_leaves_the_set_whole_and_no_archive(tmp_path, monkeypatch, fails_first):
    monkeypatch.setenv("VTBENCH_CACHE", str(tmp_path / "cache"))
    archive(tmp_path / "served")
    manifest = tmp_path / "m.sha256"
    manifest.write_text(manifest_of(tmp_path / "served", "*.npz"))
    calls = []

    def unpack(download, out):
        calls.append(download)
        if fails_first and len(calls) == 1:
            out.mkdir()
            raise OSError("disk full")
        keep_even_presses(download, out)

    url = (tmp_path / "served").as_uri()
    source = PublicSet("balls", "t", "MIT", "c", "h", url, 1, manifest, unpack)
    monkeypatch.setattr(fetching, "public_set", lambda name: source)
    if fails_first:
        with pytest.raises(OSError, match="disk full"):
            fetching.fetch("balls", progress=False)
        assert not cached_root("balls").exists()
    root = fetching.fetch("balls", progress=False)
    assert root == cached_root("balls")
    assert len(load_gelsight_ball_presses(root).presses) == 2
    assert [path.name for path in root.parent.iterdir()] == ["balls"]
    done = len(calls)
    assert fetching.fetch("balls", progress=False) == root
    assert len(calls) == done


def test_the_published_presses(real_recordings):
    data = load_gelsight_ball_presses(real_recordings("gelsight_ball_presses"))
    assert [press.number for press in data.presses] == list(range(0, 48, 2))
    assert all(press.frame.shape == data.rest.shape == (480, 640, 3) for press in data.presses)
    assert all(59 <= press.contact_radius_px <= 67 for press in data.presses)
    # the contact is where the table says: the change inside the circle is far above that of the frame
    for press in data.presses:
        change = np.abs(press.frame.astype(float) - data.rest).mean(axis=2)
        y, x = np.ogrid[:480, :640]
        inside = np.hypot(x - press.center_x_px, y - press.center_y_px) < press.contact_radius_px
        assert change[inside].mean() > 3 * change[~inside].mean()


def test_scores_are_printed_and_missing_recordings_are_one_line(real_recordings, capsys, monkeypatch, tmp_path):
    real_recordings("gelsight_ball_presses")
    assert main(["score"]) == 0
    printed = capsys.readouterr().out
    assert "rest frame alone" in printed
    assert printed.count("\n") == 2 + 12 + 3
    monkeypatch.delenv("VTBENCH_DATA")
    monkeypatch.setenv("VTBENCH_CACHE", str(tmp_path))
    assert main(["score"]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_show_draws_a_folder_of_presses(root, tmp_path):
    assert show(root, tmp_path / "presses.png").read_bytes().startswith(b"\x89PNG")
