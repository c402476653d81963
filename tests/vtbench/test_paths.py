from pathlib import Path

import pytest

from vtbench import paths


def test_the_clone_has_its_configurations():
    assert {"scenes", "suites"} <= {folder.name for folder in paths.configs_dir().iterdir()}


def test_configurations_inside_the_package_win(tmp_path, monkeypatch):
    package = tmp_path / "site-packages" / "vtbench"
    (package / "_configs").mkdir(parents=True)
    (package.parent / "configs").mkdir()
    monkeypatch.setattr(paths, "_PACKAGE", package)
    assert paths.configs_dir() == package / "_configs"


def test_an_incomplete_installation_says_so(tmp_path, monkeypatch):
    monkeypatch.setattr(paths, "_PACKAGE", tmp_path / "vtbench")
    with pytest.raises(ValueError, match="install vtbench again"):
        paths.configs_dir()


def test_the_cache_moves_with_its_variable_and_is_not_made(tmp_path, monkeypatch):
    monkeypatch.setenv("VTBENCH_CACHE", str(tmp_path / "elsewhere"))
    assert paths.cache_dir() == tmp_path / "elsewhere"
    assert not paths.cache_dir().exists()


def test_the_default_cache_is_the_users(monkeypatch):
    monkeypatch.delenv("VTBENCH_CACHE", raising=False)
    assert paths.cache_dir().name == "vtbench"
    assert paths.cache_dir() != Path("vtbench")
