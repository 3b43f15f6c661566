#!/usr/bin/env python3
"""The image of a Dockerfile without docker: its steps, one by one, in folders made by debootstrap. Wants root.
.ci/image_in_chroot.py [DOCKERFILE]"""

import json
import os
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

PROJECT = Path(__file__).resolve().parent.parent
RELEASES = {"debian:12": "bookworm"}
MOUNTED = ("proc", "dev")
# As in a container: nothing of this shell but the way to the network.
PROXIES = [f"{name}={value}" for name, value in os.environ.items() if name.lower() in ("http_proxy", "https_proxy", "no_proxy")]
ENVIRONMENT = ["PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin", "HOME=/root", *PROXIES]


def steps(dockerfile: Path) -> list[tuple[str, str]]:
    text = dockerfile.read_text().replace("\\\n", " ")
    lines = [line.strip() for line in text.splitlines() if line.strip() and not line.startswith("#")]
    return [(line.split(" ", 1)[0], line.split(" ", 1)[1].strip()) for line in lines]


def call(*command: str | Path) -> None:
    subprocess.run([str(word) for word in command], check=True)


class Stage:
    """A root folder that the steps fill."""

    def __init__(self, base: Path, root: Path) -> None:
        call("cp", "-a", base, root)
        shutil.copy("/etc/resolv.conf", root / "etc/resolv.conf")
        for name in MOUNTED:
            call("mount", "--bind", f"/{name}", root / name)
        self.root, self.folder = root, Path("/")

    def inside(self, path: str) -> Path:
        return self.root / (self.folder / path).relative_to("/")

    def copy(self, sources: list[Path], target: str) -> None:
        """Of a folder what is in it, as docker does."""
        into = self.inside(target)
        is_folder = target.endswith("/") or target == "." or any(source.is_dir() for source in sources)
        (into if is_folder else into.parent).mkdir(parents=True, exist_ok=True)
        for source in sources:
            call("cp", "-a", f"{source}/." if source.is_dir() else source, into)

    def run(self, command: str) -> None:
        call("env", "-i", *ENVIRONMENT, "chroot", self.root, "/bin/sh", "-c", f"cd {shlex.quote(str(self.folder))} && {command}")


def build(dockerfile: Path, folder: Path) -> None:
    call("git", "clone", "-q", PROJECT, folder / "sent")  # what docker would be sent of a clean clone
    stages: dict[str, Stage] = {}
    for step, words in steps(dockerfile):
        print(f"image: {step} {words}", flush=True)
        if step == "FROM":
            image, stage = words.split()[0], words.split()[-1]
            base = folder / image.replace(":", "-")
            if not base.exists():
                call("debootstrap", "--variant=minbase", RELEASES[image], base)
            now = stages[stage] = Stage(base, folder / f"stage-{len(stages)}")
        elif step == "WORKDIR":
            now.folder = Path(words)
            now.inside(".").mkdir(parents=True, exist_ok=True)
        elif step == "COPY" and words.startswith("--from="):
            origin, source, target = words.removeprefix("--from=").split()
            now.copy([stages[origin].inside(source)], target)
        elif step == "COPY":
            *sources, target = words.split()
            now.copy([folder / "sent" / source for source in sources], target)
        elif step == "RUN":
            now.run(words)
        elif step == "ENTRYPOINT":
            now.run(f"{shlex.join(json.loads(words))} list")
        else:
            raise ValueError(f"{step} is not known here")


def main(arguments: list[str]) -> int:
    if arguments[:1] == ["--in"]:
        try:
            build(Path(arguments[1]), Path(arguments[2]))
        except (subprocess.CalledProcessError, ValueError) as problem:
            print(f"image: {problem}", file=sys.stderr)
            return 1
        return 0
    dockerfile = Path(arguments[0]) if arguments else PROJECT / "Dockerfile"
    # What is mounted is so in a name space of the child's own, and gone with it, however it ends: whoever then removes the
    # folder finds none of this machine's devices in it.
    with tempfile.TemporaryDirectory() as folder:
        own = ["unshare", "--mount", "--propagation", "private", sys.executable, __file__, "--in", dockerfile, folder]
        return subprocess.run(own, check=False).returncode


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
