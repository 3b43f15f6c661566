"""A version is a number in four files, a commit and a tag with the notes; or nothing is changed."""

import shutil
import subprocess

import pytest
from copied_tools import PROJECT
from musclebench.program.cli import Problem
from musclebench.release.version import prepare

FILES = {
    "CMakeLists.txt": "cmake_minimum_required(VERSION 3.25)\nproject(musclebench VERSION 0.1.0 LANGUAGES CXX)\n",
    "tools/pyproject.toml": '[project]\nname = "musclebench-tools"\nversion = "0.1.0"\n',
    "CITATION.cff": "cff-version: 1.2.0\nversion: 0.1.0\nlicense: MIT\n",
    "CHANGELOG.md": "# Changes\n\n## Unreleased\n\n- **More**: a thing.\n- Less.\n\n## 0.1.0\n\n- The first.\n",
}


@pytest.fixture
def project(tmp_path):
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    return tmp_path


@pytest.fixture
def checkout(project):
    """With the tool, under git."""
    shutil.copytree(PROJECT / "tools/musclebench", project / "tools/musclebench", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(PROJECT / "tools/release.py", project / "tools")
    (project / ".gitignore").write_text("__pycache__\n")
    git(project, "init", "-q")
    git(project, "config", "user.name", "a")
    git(project, "config", "user.email", "a@b")
    git(project, "add", ".")
    git(project, "commit", "-qm", "First")
    return project


def git(folder, *words):
    return subprocess.run(["git", "-C", str(folder), *words], capture_output=True, text=True, check=True).stdout.strip()


def release(folder, *arguments):
    return subprocess.run([str(folder / "tools/release.py"), *arguments], capture_output=True, text=True, check=False)


def test_the_number_stands_in_every_file_and_the_changes_get_it(project):
    made = prepare(project, "0.2.0", "2026-11-28")
    assert made.last == "0.1.0" and made.notes == "- **More**: a thing.\n- Less."
    assert made.texts == {
        "CMakeLists.txt": FILES["CMakeLists.txt"].replace("0.1.0", "0.2.0"),
        "tools/pyproject.toml": FILES["tools/pyproject.toml"].replace("0.1.0", "0.2.0"),
        "CITATION.cff": "cff-version: 1.2.0\nversion: 0.2.0\ndate-released: 2026-11-28\nlicense: MIT\n",
        "CHANGELOG.md": FILES["CHANGELOG.md"].replace("## Unreleased\n", "## Unreleased\n\n## 0.2.0 (2026-11-28)\n"),
    }


def test_the_projects_own_files_have_one_version():
    assert prepare(PROJECT, "1000.0.0", "2026-11-28").notes


@pytest.mark.parametrize(("name", "old", "new", "words"), [
    ("CITATION.cff", "version: 0.1.0", "version: 0.1.1", "CITATION.cff: has not once the version 0.1.0"),
    ("CHANGELOG.md", "- **More**: a thing.\n- Less.\n", "", "nothing stands under '## Unreleased'"),
    ("CHANGELOG.md", "## Unreleased", "## Next", "nothing stands under '## Unreleased'"),
    ("CMakeLists.txt", "project(musclebench VERSION", "project(other VERSION", "CMakeLists.txt: has no project")])
def test_what_does_not_fit_is_named(project, name, old, new, words):
    (project / name).write_text(FILES[name].replace(old, new))
    with pytest.raises(Problem, match=words.replace("(", r"\(")):
        prepare(project, "0.2.0", "2026-11-28")


@pytest.mark.parametrize("version", ["0.1.0", "0.0.9"])
def test_a_version_grows(project, version):
    with pytest.raises(Problem, match="is not above 0.1.0"):
        prepare(project, version, "2026-11-28")


def test_commits_and_tags_with_the_notes(checkout):
    done = release(checkout, "0.10.0")
    assert done.returncode == 0 and "git push --follow-tags" in done.stdout, done.stderr
    assert git(checkout, "status", "--porcelain") == "" and git(checkout, "log", "-1", "--format=%s") == "Release 0.10.0"
    assert git(checkout, "tag", "--list", "-n9", "v0.10.0").split("\n")[-1].strip() == "- Less."
    assert "VERSION 0.10.0 " in (checkout / "CMakeLists.txt").read_text()
    assert release(checkout, "0.10.0").returncode == 2


def test_a_dry_run_changes_nothing(checkout):
    done = release(checkout, "0.2.0", "--dry-run")
    assert done.returncode == 0 and done.stdout.endswith("- **More**: a thing.\n- Less.\n")
    assert git(checkout, "status", "--porcelain") == "" and git(checkout, "tag") == ""


def test_refuses_what_is_not_committed(checkout):
    (checkout / "CITATION.cff").write_text("changed\n")
    done = release(checkout, "0.2.0")
    assert done.returncode == 2 and done.stderr.startswith("release: ") and git(checkout, "tag") == ""


def test_a_commit_that_is_refused_leaves_the_files_as_they_were(checkout):
    hook = checkout / ".git/hooks/pre-commit"
    hook.parent.mkdir(exist_ok=True)
    hook.write_text("#!/bin/sh\necho 'not today' >&2\nexit 1\n")
    hook.chmod(0o755)
    done = release(checkout, "0.2.0")
    assert done.returncode == 2 and "not today" in done.stderr
    assert git(checkout, "status", "--porcelain") == "" and git(checkout, "tag") == ""


@pytest.mark.parametrize("version", ["0.2", "v0.2.0", "0.2.0-rc1", "01.2.0"])
def test_refuses_what_is_no_version(checkout, version):
    done = release(checkout, version)
    assert done.returncode == 2 and "is not three whole numbers" in done.stderr
