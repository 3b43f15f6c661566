#!/usr/bin/python3
"""Makes the LHDL data folder (meshes/*.ply, lhdl.json, README.md) from checkouts of two upstream repositories."""

import argparse
import json
import os
import shutil
import sys
import tempfile
from pathlib import Path

from musclebench.lhdl import data_folder, upstream
from musclebench.lhdl.write_ply import COMMENTS, write_ply
from musclebench.program.cli import Problem
from musclebench.program.talker import Talker

EPILOG = f"""UPSTREAM_DIR holds two checkouts:
  git clone {upstream.SOURCES[0]['repository']}  (commit {upstream.SOURCES[0]['commit'][:12]})
  git clone {upstream.SOURCES[1]['repository']}  (commit {upstream.SOURCES[1]['commit'][:12]})
Example: tools/import_lhdl.py upstream lhdl, then tools/paper --data lhdl
The licence of the data is {data_folder.LICENCE}. Do not use the data commercially. Derived files carry the same licence.
The adductor brevis of 502 vertices is not published. This tool decimates the published muscle of 8564 vertices. The attachment
points are not published either. The tool takes them from the places where the muscle touches the bones. Other copies of this
data set can differ by some millimetres on the femur, because they used a finer femur."""


def parse_arguments(arguments):
    parser = argparse.ArgumentParser(
        description=__doc__, epilog=EPILOG, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("upstream_dir", type=Path, help="folder with the checkouts 3d-muscles and muscle-deformation-PBD")
    parser.add_argument("out_dir", type=Path, help="data folder to make; it must not exist without --force")
    parser.add_argument("--force", action="store_true", help="replace OUT_DIR if it exists")
    return parser.parse_args(arguments)


def readme_text() -> str:
    citations = "\n".join(f"- {c}" for c in data_folder.CITATIONS)
    sources = "\n".join(f"- {s['repository']}, commit {s['commit']}" for s in upstream.SOURCES)
    return (
        f"# LHDL right hip\n\nLicence: {data_folder.LICENCE}\n\n{data_folder.NOTICE}\n\nFrom:\n\n{sources}\n\n"
        f"Cite:\n\n{citations}\n\nLengths are metres; x towards the subject's left, y backwards, z up. "
        "`lhdl.json` describes every file.\n"
    )


def write_folder(folder: Path, upstream_dir: Path, say) -> None:
    say("checking digests")
    upstream.verify(upstream_dir)
    surfaces = data_folder.load_surfaces(upstream_dir, say)
    description = data_folder.describe(upstream_dir, surfaces, say)
    (folder / "meshes").mkdir()
    for name, surface in surfaces.items():
        say(f"writing {name}.ply")
        comments = () if surface.entry["set"] == "resampled" else COMMENTS
        write_ply(folder / surface.entry["file"], surface.vertices_m, surface.triangles, comments)
    (folder / "lhdl.json").write_text(json.dumps(description, indent=1) + "\n")
    (folder / "README.md").write_text(readme_text())


def import_lhdl(upstream_dir: Path, out_dir: Path, force: bool, say) -> None:
    if out_dir.exists() and not force:
        raise upstream.ImportProblem(f"{out_dir}: exists already; name another folder or add --force")
    out_dir.parent.mkdir(parents=True, exist_ok=True)
    temporary = Path(tempfile.mkdtemp(prefix=f".{out_dir.name}.", dir=out_dir.parent))
    try:
        write_folder(temporary, upstream_dir, say)
        temporary.chmod(0o755)
        if out_dir.exists():
            shutil.rmtree(out_dir)
        os.replace(temporary, out_dir)
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


def main(arguments=None) -> int:
    options = parse_arguments(arguments)
    try:
        import_lhdl(options.upstream_dir, options.out_dir.absolute(), options.force, Talker("import_lhdl"))
    except (upstream.ImportProblem, Problem, OSError) as problem:
        print(f"import_lhdl: {problem}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("import_lhdl: interrupted, nothing written", file=sys.stderr)
        return 130
    print(f"{options.out_dir}: 8 meshes and lhdl.json written")
    print(f"Licence: {data_folder.LICENCE}. Not for commercial use; derived files carry the same licence.")
    print("Cite:", *(f"  {citation}" for citation in data_folder.CITATIONS), sep="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
