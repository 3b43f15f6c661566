#!/usr/bin/python3
"""Reads a tool's options, answers what can be answered at once, installs and builds what they need, and starts the tool.

So a typo is told in a second, and neither --help nor --dry-run builds anything. Imports nothing but Python's own library,
which is all that a machine has before tools/setup."""

import importlib
import importlib.util
import os
import subprocess
import sys
from pathlib import Path

from musclebench.options.shared import BuiltProgram, Needs, Tool
from musclebench.program.cli import Problem, check_program, run_command

TOOLS = Path(__file__).resolve().parent
REQUIRED = ("numpy", "pandas", "scipy", "jinja2")  # without the others there are no pictures


def missing_packages() -> list[str]:
    return [name for name in REQUIRED if importlib.util.find_spec(name) is None]


def commands_of(needs: Needs) -> list[list[str]]:
    """What brings it about. Tools that only read results ask for nothing where it is there."""
    if needs.preset or needs.compiler:
        setup = [[str(TOOLS / "setup"), *needs.packages]]
    elif missing_packages() or needs.packages:
        setup = [[str(TOOLS / "setup"), "--python", *needs.packages]]
    else:
        setup = []
    build = [[str(TOOLS / "build"), needs.preset]] if needs.preset else []
    return setup + build


def is_ready(needs: Needs, program: Path | None) -> bool:
    return not missing_packages() and (not needs.preset or os.access(program, os.X_OK))


def print_commands(name: str, commands: list[list[str]]) -> None:
    """A dry run where nothing is built yet: cases are listed by the program."""
    print("The program is not built yet. Without --dry-run the tool runs these commands, and then its cases:")
    for words in commands:
        print(f"  tools/{Path(words[0]).name} {' '.join(words[1:])}".rstrip())
    print(f"After them tools/{name} --dry-run lists the cases with their times.")


def prepare(name: str, tool: Tool, arguments: list[str]) -> int | None:
    """The exit code where there is nothing to start."""
    options = tool.parse(arguments)
    tool.check(options)
    needs, program = tool.needs(options), getattr(options, "musclebench", None)
    if program and not isinstance(program, BuiltProgram):
        check_program(program, "tools/build")
    commands = commands_of(needs)
    if getattr(options, "dry_run", False):
        if not is_ready(needs, program):
            print_commands(name, commands)
            return 0
        commands = []
    for words in commands:
        code = subprocess.run(words, stdout=sys.stderr, check=False).returncode  # a tool's output is what it found
        if code != 0 and not needs.can_go_without:
            return code
    if missing := missing_packages():
        raise Problem(f"Python lacks {', '.join(missing)} ({sys.executable}); install them; on Debian run tools/setup --python")
    return None


def launch(name: str, arguments: list[str]) -> int:
    module = name.replace("-", "_")
    tool = importlib.import_module(f"musclebench.options.{module}").TOOL
    code = prepare(name, tool, arguments)
    if code is None:
        os.execv(sys.executable, [sys.executable, str(TOOLS / f"{module}.py"), *arguments])
    return code


if __name__ == "__main__":
    sys.exit(run_command(sys.argv[1], lambda: launch(sys.argv[1], sys.argv[2:]), "nothing was begun"))
