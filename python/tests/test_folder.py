"""Folders of sweeps: their manifests are those of the command."""

import json
import os
from concurrent.futures import ThreadPoolExecutor

import pytest

import ballistic_gel as bg
from ballistic_gel.folder import FolderContents, SweepFolder, write_whole

HEAD = b'{"results_of":"sweep"}\n'


def test_a_journal_is_replayed_up_to_its_last_whole_line():
    lines = b'{"state":"claimed"}\n{"file":"a"}\n{"file":"rows/b"}\n{"removed":"a"}\n{"state":"running"}\n{"file":"c'
    contents = FolderContents.read(HEAD + lines)
    assert (contents.command, contents.state, contents.files) == ("sweep", "running", {"rows/b"})


def test_a_file_that_cannot_be_written_leaves_nothing_behind(tmp_path):
    (tmp_path / "rows").mkdir()
    with pytest.raises(OSError):
        write_whole(tmp_path / "rows", b"row")
    assert os.listdir(tmp_path) == ["rows"]


def test_a_manifest_is_cut_under_its_lock_alone(tmp_path, monkeypatch):
    folder = SweepFolder(tmp_path)
    folder.claim()
    half = b'{"file":"of another sh'
    for is_locked in (False, True):
        manifest = tmp_path / "gelfmu.jsonl"
        manifest.write_bytes(manifest.read_bytes() + half)
        monkeypatch.setattr(folder, "_lock", lambda file, is_locked=is_locked: is_locked)
        folder.claim()
        assert manifest.read_bytes().endswith(half) != is_locked


@pytest.mark.parametrize(
    "text, line",
    [(b'{"mine":1}\n', 1), (HEAD + b"hello\n", 2), (HEAD + b'{"file":"../a"}\n', 2), (HEAD + b'{"file":"/a"}\n', 2)]
    + [(HEAD + b'{"file":""}\n', 2), (HEAD + b"[]\n", 2), (HEAD + b"\xff\n", 2)],
)
def test_a_file_of_this_name_that_is_no_manifest_is_refused_with_its_line(tmp_path, text, line):
    (tmp_path / "gelfmu.jsonl").write_bytes(text)
    with pytest.raises(bg.GelfmuError, match=f"found a gelfmu.jsonl whose line {line} is none of a manifest"):
        SweepFolder(tmp_path).claim()
    assert (tmp_path / "gelfmu.jsonl").read_bytes() == text


def test_the_remains_of_a_killed_claim_are_taken_over(tmp_path):
    for rest in (b"", b'{"results_of":"swe'):
        (tmp_path / "gelfmu.jsonl").write_bytes(rest)
        SweepFolder(tmp_path).claim(["results.csv"])
        first, *others = (tmp_path / "gelfmu.jsonl").read_text().splitlines()
        assert json.loads(first)["results_of"] == "sweep" and others == ['{"state":"claimed"}']


def test_shares_that_list_files_at_the_same_time_lose_none(tmp_path):
    names = [[f"rows/{share}-{number}.json" for number in range(4)] for share in range(8)]

    def share(listed):
        folder = SweepFolder(tmp_path / "rows of all")
        folder.claim(listed)
        for name in listed:
            folder.list_files([name])
            folder.write(name, b"{}")

    with ThreadPoolExecutor(8) as executor:
        list(executor.map(share, names))
    text = (tmp_path / "rows of all" / "gelfmu.jsonl").read_bytes()
    assert FolderContents.read(text).files == {name for listed in names for name in listed}
    assert text.count(b"results_of") == 1


@pytest.mark.skipif(os.name == "nt", reason="links need rights there")
def test_links_are_not_followed(tmp_path):
    folder = SweepFolder(tmp_path / "own")
    folder.claim()
    (tmp_path / "other").mkdir()
    (folder.path / "rows").symlink_to(tmp_path / "other")
    with pytest.raises(bg.GelfmuError, match="rows, which no sweep has made"):
        folder.claim(["rows/a.json"])
    (tmp_path / "linked").mkdir()
    (tmp_path / "linked" / "gelfmu.jsonl").symlink_to(folder.path / "gelfmu.jsonl")
    with pytest.raises(bg.GelfmuError, match="found a manifest that is a link"):
        SweepFolder(tmp_path / "linked").claim()


def test_a_folder_that_cannot_be_is_told(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(bg.GelfmuError, match="^out .*file: found .*, expected a folder that can be written"):
        SweepFolder(tmp_path / "file").claim()
