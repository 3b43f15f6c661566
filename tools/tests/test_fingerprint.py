"""What a finished case depends on: when any of it changes, the case is run again."""

from musclebench.program import fingerprint


def test_the_digest_of_the_data_is_that_of_the_list_and_of_every_mesh(tmp_path):
    (tmp_path / "meshes").mkdir()
    files = [tmp_path / "lhdl.json", tmp_path / "meshes" / "femur.ply", tmp_path / "meshes" / "iliacus.ply"]
    for path in files:
        path.write_text("as it was")
    first = fingerprint.data_digest(tmp_path)
    assert first == fingerprint.data_digest(tmp_path) and fingerprint.data_digest(None) == ""
    digests = {first}
    for path in files:
        path.write_text("changed")
        digests.add(fingerprint.data_digest(tmp_path))
    files[-1].unlink()
    assert len(digests | {fingerprint.data_digest(tmp_path)}) == 5


def test_what_was_sealed_counts_only_for_the_same_case(tmp_path):
    sealed = fingerprint.fingerprint(["run", "scene"], "program", "data", field="digest")
    fingerprint.seal(tmp_path, sealed)
    (tmp_path / "run.json").write_text('{"status": "ok"}')
    assert fingerprint.status_when_sealed(tmp_path, sealed) == "ok"
    for key in sealed:
        assert fingerprint.status_when_sealed(tmp_path, sealed | {key: "another"}) is None, key
