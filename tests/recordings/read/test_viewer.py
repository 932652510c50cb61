"""rerun's web viewer is taken from the installed wheel: no network is needed, and none is used."""

import gzip
from pathlib import Path

import pytest

from controller.errors import RecordingError
from recordings.read import viewer


@pytest.mark.process
def test_the_viewer_is_extracted_once_and_whole_without_a_network(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("http_proxy", "https_proxy", "HTTP_PROXY", "HTTPS_PROXY"):
        monkeypatch.setenv(name, "http://192.0.2.1:9")
    folder = viewer.viewer_files(tmp_path)
    assert {path.name for path in folder.iterdir()} == {*viewer.FILES, *(f"{name}.gz" for name in viewer.GZIPPED)}
    wasm = (folder / "re_viewer_bg.wasm").read_bytes()
    assert wasm.startswith(b"\0asm")
    assert gzip.decompress((folder / "re_viewer_bg.wasm.gz").read_bytes()) == wasm
    assert "re_viewer.js" in (folder / "index.html").read_text()

    monkeypatch.setattr(viewer.tool, "command", _never)
    assert viewer.viewer_files(tmp_path) == folder
    assert [path.name for path in tmp_path.iterdir()] == [folder.name]


@pytest.mark.process
def test_a_rerun_that_does_not_serve_gives_an_error_with_its_last_words(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(viewer.tool, "command", lambda *_: ["sh", "-c", "echo no such option; exit 2"])
    with pytest.raises(RecordingError, match="no such option"):
        viewer.viewer_files(tmp_path)
    assert not list(tmp_path.iterdir())


@pytest.mark.process
def test_a_rerun_that_says_nothing_is_given_up(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(viewer, "START_TIMEOUT", 0.2)
    monkeypatch.setattr(viewer.tool, "command", lambda *_: ["sleep", "100"])
    with pytest.raises(RecordingError, match=r"within 0\.2 s"):
        viewer.viewer_files(tmp_path)
    assert not list(tmp_path.iterdir())


def _never(*_: str) -> list[str]:
    raise AssertionError("it is there already")
