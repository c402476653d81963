"""The package loads lazily and keeps to itself."""

import subprocess
import sys

import pytest

import fusion
import fusion.features


@pytest.mark.parametrize("package", [fusion, fusion.features])
def test_every_public_name_resolves(package):
    for name in package.__all__:
        assert getattr(package, name).__doc__
        assert name in dir(package)
    with pytest.raises(AttributeError, match="no attribute 'KSB'"):
        _ = package.KSB


def test_importing_the_package_loads_nothing_heavy_and_no_other_part():
    code = (
        "import sys, fusion, fusion.features\n"
        "heavy = {'torch', 'torchvision', 'sklearn', 'scipy', 'cv2', 'onnx', 'onnxruntime', 'pandas',"
        " 'vtbench', 'sensors', 'slip', 'leaderboard'}\n"
        "print(*sorted(heavy & set(sys.modules)))"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.split() == []
