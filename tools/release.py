#!/usr/bin/python3
"""Makes a version. Options: musclebench/options/release.py."""

import datetime
import subprocess
import sys
from argparse import Namespace

from musclebench.cases.study_command import PROJECT
from musclebench.options.release import check, parse_arguments
from musclebench.program.cli import Problem, run_command
from musclebench.release.version import prepare


def git(*words: str, text: str | None = None) -> str:
    done = subprocess.run(["git", "-C", str(PROJECT), *words], input=text, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise Problem(f"git {words[0]}: {(done.stderr.strip() or done.stdout.strip()).splitlines()[0]}")
    return done.stdout.strip()


def work(options: Namespace) -> int:
    check(options)
    tag = f"v{options.version}"
    date = datetime.datetime.now(datetime.timezone.utc).date().isoformat()
    release = prepare(PROJECT, options.version, date)
    if git("tag", "--list", tag):
        raise Problem(f"VERSION {options.version}: the tag {tag} is there already")
    if options.dry_run:
        print(f"Version {release.last} would become {options.version}, in a commit with the tag {tag}.\n"
              f"It would change {', '.join(release.texts)}.\n\nRelease notes:\n\n{release.notes}")
        return 0
    if git("status", "--porcelain"):
        raise Problem("the working tree has changes that are not committed; commit them first, or put them away (git stash)")
    for name, text in release.texts.items():
        (PROJECT / name).write_text(text)
    try:
        git("commit", "--quiet", "--message", f"Release {options.version}", "--", *release.texts)
    except Problem:
        git("checkout", "--quiet", "HEAD", "--", *release.texts)
        raise
    # A line of the notes that begins with # is a heading, no comment of git.
    git("tag", "--annotate", tag, "--cleanup=verbatim", "--file=-", text=f"musclebench {options.version}\n\n{release.notes}\n")
    print(f"Version {options.version} is committed and tagged. To publish it: git push --follow-tags")
    return 0


def main(arguments=None) -> int:
    return run_command("release", lambda: work(parse_arguments(arguments)), "git status and git tag show what is done")


if __name__ == "__main__":
    sys.exit(main())
