"""Fetching from a server on this machine: checked, whole or absent, resumed."""

import http.server
import threading
from dataclasses import replace
from pathlib import Path

import pytest

from vtbench.data import data_root, fetch, public
from vtbench.data.fetching import fetch_set
from vtbench.data.manifest import manifest_of, read_manifest
from vtbench.data.public import PublicSet, cached_root, public_set

CONTENT = {f"data/kind/file {i}.csv": f"a,b\n{i},{i}\n".encode() * 50 for i in range(12)}


class QueueingServer(http.server.ThreadingHTTPServer):
    request_queue_size = 64


class Server:
    """Serves a folder; `asked` lists the requests, `spoil` may change or refuse an answer."""

    def __init__(self, folder):
        self.asked = []
        self.spoil = lambda path, count, data: data
        server = self

        class Handler(http.server.BaseHTTPRequestHandler):
            def do_GET(self):
                path = self.path.replace("%20", " ")
                server.asked.append(path)
                file = folder / path.lstrip("/")
                data = file.read_bytes() if file.is_file() else 404
                data = server.spoil(path, server.asked.count(path), data)
                if isinstance(data, int):
                    self.send_error(data)
                    return
                self.send_response(200)
                self.send_header("Content-Length", str(len(data) if data != b"cut" else 999))
                self.end_headers()
                self.wfile.write(data)

            def log_message(self, *arguments):
                pass

        self.http = QueueingServer(("127.0.0.1", 0), Handler)
        self.url = f"http://127.0.0.1:{self.http.server_port}"
        self.thread = threading.Thread(target=self.http.serve_forever, kwargs={"poll_interval": 0.01})
        self.thread.start()

    def close(self):
        if self.thread.is_alive():
            self.http.shutdown()
            self.http.server_close()
            self.thread.join()


@pytest.fixture
def server(tmp_path, monkeypatch):
    monkeypatch.setenv("NO_PROXY", "127.0.0.1")
    monkeypatch.setattr("vtbench.data.fetching._PAUSE_S", 0.0)
    for path, data in CONTENT.items():
        (tmp_path / "origin" / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "origin" / path).write_bytes(data)
    server = Server(tmp_path / "origin")
    yield server
    server.close()


@pytest.fixture
def source(server, tmp_path):
    manifest = tmp_path / "tiny.sha256"
    manifest.write_text(manifest_of(tmp_path / "origin", "data/*/*.csv"))
    return PublicSet("tiny", "", "MIT", "", "", server.url, 1, manifest)


def fetched(root):
    return {p.relative_to(root).as_posix(): p.read_bytes() for p in root.rglob("*") if p.is_file()}


def test_every_file_arrives_and_a_second_fetch_asks_for_nothing(server, source, tmp_path):
    root = tmp_path / "cache" / "tiny"
    assert fetched(fetch_set(source, root)) == CONTENT
    assert len(server.asked) == len(CONTENT)
    fetch_set(source, root)
    assert len(server.asked) == len(CONTENT)


def test_a_damaged_file_is_fetched_again(server, source, tmp_path):
    root = fetch_set(source, tmp_path / "tiny")
    (root / "data/kind/file 3.csv").write_bytes(b"a,b\n")
    assert fetched(fetch_set(source, root)) == CONTENT
    assert len(server.asked) == len(CONTENT) + 1


@pytest.mark.parametrize("first", [503, 429, b"cut"])
def test_a_passing_failure_is_tried_again(server, source, tmp_path, first):
    server.spoil = lambda path, count, data: first if count == 1 else data
    assert fetched(fetch_set(source, tmp_path / "tiny")) == CONTENT


def test_another_content_than_the_pinned_one_is_refused(server, source, tmp_path):
    server.spoil = lambda path, count, data: b"else" if "file 7" in path else data
    with pytest.raises(ValueError, match=r"file%207.csv: checksum is off") as failure:
        fetch_set(source, tmp_path / "tiny")
    assert "\n" not in str(failure.value)
    assert not (tmp_path / "tiny").exists()
    server.spoil = lambda path, count, data: data
    assert fetched(fetch_set(source, tmp_path / "tiny")) == CONTENT


def test_a_file_that_is_gone_is_not_asked_for_thrice(server, source, tmp_path):
    server.spoil = lambda path, count, data: 404 if "file 7" in path else data
    with pytest.raises(OSError, match=r"cannot download .*file%207.csv \(HTTP 404"):
        fetch_set(source, tmp_path / "tiny")
    assert server.asked.count("/data/kind/file 7.csv") == 1


def test_without_a_network_one_line_says_what_to_do(server, source, tmp_path):
    server.close()
    with pytest.raises(OSError, match=r"cannot download .*`vtbench fetch tiny` again.*VTBENCH_DATA") as failure:
        fetch_set(source, tmp_path / "tiny")
    assert "\n" not in str(failure.value)
    assert not (tmp_path / "tiny").exists()


@pytest.fixture
def no_recordings(tmp_path, monkeypatch):
    monkeypatch.delenv("VTBENCH_DATA", raising=False)
    monkeypatch.setenv("VTBENCH_CACHE", str(tmp_path / "cache"))


@pytest.mark.usefixtures("no_recordings")
def test_missing_recordings_name_the_command_that_brings_them():
    with pytest.raises(ValueError, match="`vtbench fetch fabricslide16` brings them"):
        data_root("fabricslide16")


@pytest.mark.usefixtures("no_recordings")
def test_the_folder_of_the_variable_goes_before_the_cache(tmp_path, monkeypatch):
    cached_root("fabricslide16").mkdir(parents=True)
    assert data_root("fabricslide16") == cached_root("fabricslide16")
    monkeypatch.setenv("VTBENCH_DATA", str(tmp_path))
    assert data_root("fabricslide16") == cached_root("fabricslide16")
    (tmp_path / "fabricslide16").mkdir()
    assert data_root("fabricslide16") == tmp_path / "fabricslide16"


@pytest.mark.parametrize("ask", [data_root, fetch])
def test_an_unknown_name_gets_a_suggestion(ask):
    with pytest.raises(ValueError, match="did you mean 'fabricslide16'"):
        ask("fabricslide")


@pytest.mark.parametrize("name", public.PUBLIC.ids())
def test_every_registered_set_is_pinned_and_says_whom_to_cite(name):
    source = public_set(name)
    assert source.name == name
    assert source.files
    assert all((source.licence, source.citation, source.homepage, source.base_url))


@pytest.mark.parametrize("line", ["abc  x.csv", f"{'0' * 64}  ../x.csv", f"{'0' * 64}  /x.csv"])
def test_a_bad_manifest_line_is_named(tmp_path, line):
    path = tmp_path / "m.sha256"
    path.write_text(f"{'0' * 64}  good.csv\n{line}\n")
    with pytest.raises(ValueError, match="line 2"):
        read_manifest(path)


def test_the_manifest_is_that_of_the_published_files(real_recordings):
    root = real_recordings("fabricslide16")
    assert manifest_of(root, "data/*/*.csv") == public_set("fabricslide16").manifest.read_text()


@pytest.mark.slow
@pytest.mark.usefixtures("no_recordings")
def test_the_published_files_are_fetched_in_full(real_recordings, monkeypatch):
    root = real_recordings("fabricslide16")
    server = Server(root)
    try:
        from vtbench.data import fabricslide16

        monkeypatch.setenv("NO_PROXY", "127.0.0.1")
        monkeypatch.setattr(fabricslide16, "SOURCE", replace(fabricslide16.SOURCE, base_url=server.url))
        brought = fetch("fabricslide16", progress=False)
    finally:
        server.close()
    assert Path(brought) == data_root("fabricslide16")
    assert len(fabricslide16.load_fabricslide16()) == 966
