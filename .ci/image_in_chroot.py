#!/usr/bin/env python3
"""The image of the Dockerfile without docker: its steps, one by one, in folders made by debootstrap. Wants root."""

import json
import shlex
import shutil
import subprocess
import sys
import tempfile
from contextlib import ExitStack
from pathlib import Path

PROJECT = Path(__file__).resolve().parent.parent
RELEASES = {"debian:12": "bookworm"}
MOUNTED = ("proc", "dev")


def steps() -> list[tuple[str, str]]:
    text = (PROJECT / "Dockerfile").read_text().replace("\\\n", " ")
    lines = [line.strip() for line in text.splitlines() if line.strip() and not line.startswith("#")]
    return [(line.split(" ", 1)[0], line.split(" ", 1)[1].strip()) for line in lines]


def call(*command: str | Path) -> None:
    subprocess.run([str(word) for word in command], check=True)


class Stage:
    """A root folder that the steps fill."""

    def __init__(self, base: Path, root: Path, open_mounts: ExitStack) -> None:
        call("cp", "-a", base, root)
        shutil.copy("/etc/resolv.conf", root / "etc/resolv.conf")
        for name in MOUNTED:
            call("mount", "--bind", f"/{name}", root / name)
            open_mounts.callback(call, "umount", "--lazy", root / name)
        self.root, self.folder = root, Path("/")

    def inside(self, path: str) -> Path:
        return self.root / (self.folder / path).relative_to("/")

    def copy(self, sources: list[Path], target: str) -> None:
        into = self.inside(target)
        is_folder = target.endswith("/") or target == "."
        (into if is_folder else into.parent).mkdir(parents=True, exist_ok=True)
        for source in sources:
            call("cp", "-a", source, into)

    def run(self, command: str) -> None:
        call("chroot", self.root, "/bin/sh", "-c", f"cd {shlex.quote(str(self.folder))} && {command}")


def committed(into: Path) -> Path:
    """What docker would be sent of a clean clone."""
    call("git", "clone", "-q", PROJECT, into)
    return into


def main() -> int:
    with tempfile.TemporaryDirectory() as name, ExitStack() as open_mounts:
        folder, stages, now = Path(name), {}, None
        sent = committed(folder / "sent")
        for step, words in steps():
            print(f"image: {step} {words}", flush=True)
            if step == "FROM":
                image, *_ = words.split()
                base = folder / image.replace(":", "-")
                if not base.exists():
                    call("debootstrap", "--variant=minbase", RELEASES[image], base)
                stage = words.split()[-1]
                now = stages[stage] = Stage(base, folder / f"stage-{len(stages)}", open_mounts)
            elif step == "WORKDIR":
                now.folder = Path(words)
                now.inside(".").mkdir(parents=True, exist_ok=True)
            elif step == "COPY" and words.startswith("--from="):
                origin, source, target = words.removeprefix("--from=").split()
                now.copy([stages[origin].inside(source)], target)
            elif step == "COPY":
                *sources, target = words.split()
                now.copy([entry for source in sources for entry in ([*sent.iterdir()] if source == "." else [sent / source])], target)
            elif step == "RUN":
                now.run(words)
            elif step == "ENTRYPOINT":
                now.run(f"{shlex.join(json.loads(words))} list")
            else:
                print(f"image: {step} is not known here", file=sys.stderr)
                return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
