import subprocess
import sys

import cv2
import numpy as np
import pytest

from sensors.objects import draw_gallery, draw_object
from sensors.objects.gallery import shade


@pytest.mark.slow
def test_gallery_is_a_picture_with_a_panel_an_object(tmp_path):
    path = draw_gallery(tmp_path / "gallery.png")
    picture = cv2.imread(str(path))
    assert picture.shape[0] > 1000
    assert picture.shape[1] > 2000
    assert picture.std() > 10.0


def test_objects_have_pictures_of_their_own(tmp_path):
    pictures = [cv2.imread(str(draw_object(name, tmp_path / f"{name}.png"))) for name in ("spoon", "hex-nut")]
    assert pictures[0].shape == pictures[1].shape
    assert np.abs(pictures[0].astype(int) - pictures[1]).mean() > 1.0
    with pytest.raises(ValueError, match="no household object"):
        draw_object("spon", tmp_path / "x.png")


def test_light_comes_from_the_upper_left():
    y, x = np.mgrid[-40:40, -40:40] * 0.5
    mound = 8.0 * np.exp(-(x**2 + y**2) / 60.0)
    picture = shade(mound.astype(np.float32), 0.5)
    assert picture.shape == (80, 80, 3)
    assert picture.min() >= 0.0
    assert picture.max() <= 1.0
    assert picture[30, 30].mean() > picture[50, 50].mean() + 0.1


def test_an_empty_table_is_drawn_flat():
    picture = shade(np.zeros((16, 16), np.float32), 1.0)
    assert np.ptp(picture.reshape(-1, 3), axis=0) == pytest.approx(np.zeros(3), abs=1e-12)


def test_names_load_neither_opencv_nor_matplotlib():
    code = (
        "import sys; from sensors import objects; objects.names();"
        "print([m for m in ('cv2', 'matplotlib', 'scipy', 'torch') if m in sys.modules])"
    )
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert answer.stdout.strip() == "[]"
