"""An archive is read as it was written or not at all, and says which of its files was altered."""

import io
import json
import zipfile

import pytest

from retrodict.storage.archive import MANIFEST, NotArchived, archive_bytes, read_archive

FILES = {"about.json": b"{}", "scene.toml": b"title = 1\n" * 50, "posterior.nc": bytes(range(256))}


def written(path, entries, **options):
    """A zip file that need not be an archive."""
    with zipfile.ZipFile(path, "w", **options) as archive:
        for name, content in entries:
            archive.writestr(name, content)
    return path


def entries_of(path):
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "one.zip"
    path.write_bytes(archive_bytes(FILES))
    return path


def test_what_is_read_is_what_was_written(path):
    found = read_archive(path)
    assert found.files == FILES
    assert list(found.files) == list(FILES)
    assert found.link == json.loads(entries_of(path)[MANIFEST])["entries"][-1]["link"]
    assert archive_bytes(FILES) == path.read_bytes()


def test_the_chain_is_the_one_that_its_manifest_describes(path):
    from hashlib import sha256

    manifest = json.loads(entries_of(path)[MANIFEST])
    link = manifest["first"]
    for name, entry in zip(FILES, manifest["entries"], strict=True):
        own = sha256(FILES[name]).hexdigest()
        link = sha256(f"{link} {own} {name}".encode()).hexdigest()
        assert entry == {"name": name, "size": len(FILES[name]), "sha256": own, "link": link}


def test_the_last_link_changes_with_content_name_and_order(tmp_path):
    def link_of(files):
        path = tmp_path / "any.zip"
        path.write_bytes(archive_bytes(files))
        return read_archive(path).link

    turned = dict(reversed(FILES.items()))
    named = {name.replace("about", "above"): content for name, content in FILES.items()}
    other = FILES | {"about.json": b"{ }"}
    assert len({link_of(each) for each in (FILES, turned, named, other)}) == 4


@pytest.mark.parametrize("name", FILES)
def test_a_file_that_was_altered_is_named(path, name):
    entries = entries_of(path)
    entries[name] = b"x" + entries[name][1:]
    with pytest.raises(NotArchived, match=f"{name} was altered") as refusal:
        read_archive(written(path, entries.items()))
    assert sum(other in str(refusal.value) for other in FILES) == 1


@pytest.mark.parametrize("name", FILES)
def test_a_byte_that_was_altered_in_place_is_named(path, name):
    content = path.read_bytes()
    at = content.index(FILES[name]) + 1
    path.write_bytes(content[:at] + bytes([content[at] ^ 1]) + content[at + 1 :])
    with pytest.raises(NotArchived, match=f"{name} was altered"):
        read_archive(path)


def test_no_byte_of_an_archive_can_change_what_is_read(tmp_path):
    content = archive_bytes({"a": b"one", "b": b"two"})
    path = tmp_path / "one.zip"
    for at in range(len(content)):
        path.write_bytes(content[:at] + bytes([content[at] ^ 0x10]) + content[at + 1 :])
        try:
            assert read_archive(path).files == {"a": b"one", "b": b"two"}
        except NotArchived:
            continue


def test_files_that_are_missing_or_were_added_are_named(path):
    entries = entries_of(path)
    moved = [("scene2.toml" if n == "scene.toml" else n, c) for n, c in entries.items()]
    with pytest.raises(NotArchived, match=r"scene\.toml is missing; scene2\.toml is not listed"):
        read_archive(written(path, moved))


def test_an_altered_manifest_breaks_its_chain(path):
    entries = entries_of(path)
    manifest = json.loads(entries[MANIFEST])
    manifest["entries"] = manifest["entries"][::-1]
    entries[MANIFEST] = json.dumps(manifest).encode()
    with pytest.raises(NotArchived, match=r"manifest\.json was altered: its chain breaks"):
        read_archive(written(path, entries.items()))
    for broken in (b"{", b"[]", b'{"schema": 1}', b"\xff", b"[" * 100_000):
        with pytest.raises(NotArchived, match=r"manifest\.json was altered"):
            read_archive(written(path, (entries | {MANIFEST: broken}).items()))


@pytest.mark.parametrize(
    "name", ["../up", "/etc/passwd", "C:\\x", "a/b", "a\\b", ".hidden", "a\x1b[2J", "ü", "x" * 200]
)
def test_an_unsafe_name_is_refused(path, name):
    with pytest.raises(NotArchived, match="no archive has such a name") as refusal:
        read_archive(written(path, [*entries_of(path).items(), (name, b"")]))
    assert str(refusal.value).isprintable()
    with pytest.raises(ValueError, match="no name of an entry"):
        archive_bytes({name: b""})


def test_a_bomb_is_refused_before_it_is_unpacked(path):
    bomb = [*entries_of(path).items(), ("bomb", bytes(10_000_000))]
    with pytest.raises(NotArchived, match="compressed"):
        read_archive(written(path, bomb, compression=zipfile.ZIP_DEFLATED))
    many = [(f"n{i}", b"") for i in range(200)]
    with pytest.raises(NotArchived, match="more than 100 entries"):
        read_archive(written(path, many))


def test_entries_that_share_their_bytes_are_refused(path):
    once = io.BytesIO()
    with zipfile.ZipFile(once, "w") as archive:
        archive.writestr("a", bytes(1000))
        for name in "bc":  # listed again at the same place
            info = zipfile.ZipInfo(name)
            info.file_size = info.compress_size = 1000
            info.CRC, info.header_offset = archive.infolist()[0].CRC, 0
            archive.filelist.append(info)
            archive.NameToInfo[name] = info
    path.write_bytes(once.getvalue())
    with pytest.raises(NotArchived, match="claim more than it holds"):
        read_archive(path)


@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_a_name_that_is_there_twice_is_refused(path):
    with pytest.raises(NotArchived, match="there twice"):
        read_archive(written(path, [("a", b"1"), ("a", b"2")]))


def test_a_file_that_is_no_archive_is_refused_in_a_line(path):
    for content in (b"", b"PK\x03\x04", b"hello" * 100, archive_bytes(FILES)[:-30]):
        path.write_bytes(content)
        with pytest.raises(NotArchived) as refusal:
            read_archive(path)
        assert "\n" not in str(refusal.value)
    with pytest.raises(NotArchived, match=r"holds no manifest\.json"):
        read_archive(written(path, [("a", b"1")]))
