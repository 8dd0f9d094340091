"""The workflow without a home directory."""


def test_nothing_is_written_to_the_home_directory(clean, monkeypatch):
    monkeypatch.setenv("HOME", "/dev/null")
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    clean.feed("--cores", 1, needs=(100, 1), command="touch {output}")
    assert (clean.folder / "one.fed").exists()
