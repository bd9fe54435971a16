"""Data sets of somebody else: what their manifests and shards hold that it should not is told, and nothing of it is used."""

import hashlib
import io
import json
import sys
import tarfile
import types

import pytest

from camrig import CamrigError
from camrig.farm.batch import check, export, parquet
from camrig.farm.batch.shard_file import pack, samples
from camrig.farm.batch.store import Store

NAME, OTHER = "0123456789abcdef", "f" * 16
KEY = f"{NAME}_eye_000001"
CAMERA_FILES = ("camera_info.yaml", "opencv.yml", "seqinfo.ini")


@pytest.fixture
def store(tmp_path):
    """A set of one shard, of one frame."""
    eye = tmp_path / "recorded" / "eye"
    (eye / "image_2").mkdir(parents=True)
    (eye / "image_2" / "000001.png").write_bytes(b"picture")
    (eye / "truth.jsonl").write_text(json.dumps({"time_ns": 5, "monotonic_ns": 6}) + "\n")
    for name in CAMERA_FILES:
        (eye / name).write_text("name=eye\n")
    store = Store(tmp_path / "set")
    with store.held({}, {}, [NAME]):
        store.publish(NAME, lambda file: {**pack(NAME, eye.parent, ["eye"], ".png", file), "shard": NAME, "seed": 1, "pictures": {"yolo": False}})
        store.write_manifest([NAME])
    return store


def row_of(store):
    return json.loads((store.shards / f"{NAME}.json").read_text())


def checked(store, capsys):
    code = check.main([str(store.folder), "--json"])
    said = capsys.readouterr()
    found = json.loads(said.out)["problems"]
    assert said.err.splitlines()[: len(found)] == [f"camrig: {one}" for one in found]
    return code, found


def exported(store, tmp_path, *options):
    before = set(tmp_path.rglob("*"))
    with pytest.raises(CamrigError) as refused:
        export.main([str(store.folder), "--out", str(tmp_path / "out"), *options])
    assert all((tmp_path / "out") in (one, *one.parents) for one in set(tmp_path.rglob("*")) - before)
    return refused.value.message


def eye(**wrong):
    return {"cameras": [{"name": "eye", "frames": 1, "files": dict.fromkeys(CAMERA_FILES, ""), **wrong}]}


@pytest.mark.parametrize("change, said", [
    *(({key: None}, f"{key}: ") for key in ("shard", "bytes", "sha256", "seed", "picture_suffix", "pictures", "cameras")),
    *((key, f"{key}: is missing") for key in ("shard", "bytes", "sha256", "seed", "picture_suffix", "pictures", "cameras")),
    ({"shard": "../x"}, "shard: must be 16 hex digits"),
    ({"shard": "/etc/passwd"}, "shard: must be 16 hex digits"),
    ({"shard": ["a"]}, "shard: must be 16 hex digits"),
    ({"bytes": -1}, "bytes: must be a whole number, 0 to "),
    ({"seed": 10**400}, "a number is beyond 1.8e308"),
    ({"pictures": {}}, "pictures.yolo: is missing"),
    ({"picture_suffix": "/../../x.png"}, "picture_suffix: must be one of .png, .jpg"),
    ({"cameras": [1]}, "cameras[0]: must be an object"),
    ({"cameras": eye()["cameras"] * 2}, "cameras[1].name: is that of an earlier camera, too"),
    (eye(name="../x"), "cameras[0].name: must be 1 to 24 of a-z, 0-9 and _"),
    (eye(frames="1"), "cameras[0].frames: must be a whole number"),
    (eye(files={}), "cameras[0].files.camera_info.yaml: is missing"),
    (eye(files={"../\ny": ""}), "cameras[0].files.../?y: is unknown; known: camera_info.yaml"),
    (eye(files=dict.fromkeys(CAMERA_FILES, 1)), "cameras[0].files.camera_info.yaml: must be a string"),
    (eye(files=dict.fromkeys(CAMERA_FILES, "\ud800")), "a text has half of a surrogate pair"),
])
def test_a_row_of_the_manifest_that_is_none_is_told_with_its_place(store, tmp_path, capsys, change, said):
    row = {key: value for key, value in row_of(store).items() if key != change} if isinstance(change, str) else {**row_of(store), **change}
    (store.folder / "manifest.jsonl").write_text(json.dumps(row) + "\n")
    code, (found,) = checked(store, capsys)
    assert code == 1 and found.startswith(f"{store.folder}/manifest.jsonl: line 1: {said}")
    assert exported(store, tmp_path) == found


def test_a_check_tells_every_line_and_every_shard_that_is_wrong(store, tmp_path, capsys, monkeypatch):
    good = (store.folder / "manifest.jsonl").read_bytes()
    monkeypatch.setattr("camrig.farm.batch.manifest.MAX_LINE_BYTES", 20_000)
    lines = [b"no JSON", b"\xff", b"[" * 10_000, b"[1]", b"", b'{"x": "' + b"x" * 3_000_000 + b'"}', good.strip(), good.strip(), json.dumps({**row_of(store), "shard": OTHER}).encode()]
    (store.folder / "manifest.jsonl").write_bytes(b"\n".join(lines))
    code, found = checked(store, capsys)
    where = f"{store.folder}/manifest.jsonl: line "
    assert code == 1 and [one.removeprefix(where)[:10] for one in found[:4]] == ["1: is not ", "2: is not ", "3: is not ", "4: must be"]
    assert found[4].startswith(f"{where}5: is not JSON") and found[5] == f"{where}6: is longer than 20000 bytes"
    assert found[6:] == [f"{where}8: shard: is that of an earlier line, too", f"{OTHER}.tar: No such file or directory"]
    assert exported(store, tmp_path) == found[0]


LINK = bytearray()


def tar_of(*members):
    """A tar file of those members: a name with its bytes, or LINK."""
    made = io.BytesIO()
    with tarfile.open(fileobj=made, mode="w", format=tarfile.GNU_FORMAT) as tar:
        for name, data in members:
            entry = tarfile.TarInfo(name)
            entry.size = len(data)
            if data is LINK:
                entry.type, entry.linkname = tarfile.SYMTYPE, "/etc/passwd"
            tar.addfile(entry, io.BytesIO(data))
    return made.getvalue()


PICTURE, TRUTH = (f"{KEY}.png", b"picture"), (f"{KEY}.json", b'{"time_ns":5}')
LONG = tarfile.TarInfo("././@LongLink")
LONG.type, LONG.size = tarfile.GNUTYPE_LONGNAME, 1 << 32


@pytest.mark.parametrize("data, said", [
    (b"no tar file at all", "byte 0: must be a tar file's header: truncated header"),
    (b"x" * 1024, "byte 0: must be a tar file's header: invalid header"),
    (tar_of(PICTURE, (f"{KEY}.json", bytes(5000)))[:4096], f"{KEY}.json: is cut off: the file ends within its 5000 bytes"),
    (tar_of(PICTURE, TRUTH)[:1024], f"{KEY}.json: is missing"),
    (tar_of(), f"its end: stands where the manifest has {KEY}"),
    (tar_of(PICTURE), f"{KEY}.json: is missing"),
    (tar_of(TRUTH), f"{KEY}.png: is missing"),
    (tar_of(PICTURE, PICTURE, TRUTH), f"{KEY}.png: is there twice"),
    (tar_of(PICTURE, TRUTH, (f"{NAME}_eye_000002.png", b"")), f"{NAME}_eye_000002: is of no frame that the manifest has"),
    (tar_of((f"{NAME}_ear_000001.png", b"")), f"{NAME}_ear_000001: stands where the manifest has {KEY}"),
    (tar_of((f"{NAME}_eye_\u0661.png", b"")), f"{NAME}_eye_\u0661: stands where the manifest has {KEY}"),
    (tar_of(PICTURE, TRUTH, (f"{KEY}.a/../../b.png", b"")), f"{KEY}.a/../../b.png: is no file of a frame"),
    (tar_of(("../../b.png", b"")), "../../b.png: is no file of a frame"),
    (tar_of((f"../{KEY}\n.png", LINK)), f"../{KEY}?.png: is no file of a frame"),
    (tar_of((f"{KEY}.png", LINK)), f"{KEY}.png: is no file of a frame"),
    (LONG.tobuf(tarfile.GNU_FORMAT), "././@LongLink: is no file of a frame"),
    *((tar_of(PICTURE, (f"{KEY}.json", text)), f"{KEY}.json: {problem}") for text, problem in (
        (b"no JSON", "is not JSON"), (b"\xff", "is not JSON"), (b"[" * 10_000, "is not JSON"), (b"[]", "must be an object"), (b"{}", "time_ns: must be a whole number"),
        (b'{"time_ns":"5"}', "time_ns: must be a whole number"), (b'{"time_ns":5,"x":NaN}', "a number is beyond"), (b'{\n"time_ns":5}', "must be one line"))),
])
def test_a_shard_that_holds_something_else_is_told_with_the_member(store, tmp_path, capsys, monkeypatch, data, said):
    """Also where the manifest says that it holds just that."""
    monkeypatch.setitem(sys.modules, "pyarrow", arrow())
    store.shard_path(NAME).write_bytes(data)
    (store.folder / "manifest.jsonl").write_text(json.dumps({**row_of(store), "bytes": len(data), "sha256": hashlib.sha256(data).hexdigest()}) + "\n")
    code, (found,) = checked(store, capsys)
    assert code == 1 and found.startswith(f"{store.shard_path(NAME)}: {said}") and found.endswith("; camrig farm record draws a shard anew whose file is removed")
    assert exported(store, tmp_path) == found
    with pytest.raises(CamrigError, match="must be|is |stands "):
        parquet.write_parquet(store, tmp_path / "rows")


def arrow():
    """As much of pyarrow as an export of no whole shard needs."""
    class Writer:
        def __init__(self, *_, **__):
            pass

        def __enter__(self):
            return self

        def __exit__(self, *_):
            pass

        def write_table(self, table):
            pass

    types_ = {name: lambda *_: None for name in ("schema", "string", "int64", "binary")}
    return types.SimpleNamespace(**types_, Table=types.SimpleNamespace(from_pylist=lambda *_: None), parquet=types.SimpleNamespace(ParquetWriter=Writer))


def test_a_truth_that_says_it_is_long_is_not_read(store, capsys):
    entry = tarfile.TarInfo(f"{KEY}.json")
    entry.size = (64 << 20) + 1
    data = tar_of(PICTURE)[:1024] + entry.tobuf(tarfile.USTAR_FORMAT)
    store.shard_path(NAME).write_bytes(data)
    (store.folder / "manifest.jsonl").write_text(json.dumps({**row_of(store), "bytes": len(data), "sha256": hashlib.sha256(data).hexdigest()}) + "\n")
    assert f"{KEY}.json: says that it has {entry.size} bytes; at most {64 << 20}" in checked(store, capsys)[1][0]


def test_a_set_that_is_whole_has_no_problems(store, capsys):
    assert checked(store, capsys) == (0, [])
    (store.folder / "planned.json").write_text('{"shards": 1e999}')
    assert checked(store, capsys) == (0, [])
    (told,) = store.manifest()
    (sample,) = samples(store.shard_path(NAME), told)
    row = parquet._row(told, sample)
    assert (row["key"], row["camera"], row["frame"], row["time_ns"], row["image"], row["truth"]) == (KEY, "eye", 1, 5, b"picture", '{"time_ns":5}')
