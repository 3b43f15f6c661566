"""Help texts of the program and of all tools are in plain English: short sentences, every option explained, numbers with default
or unit."""

import argparse
import importlib
import importlib.machinery
import importlib.util
import json
import re
import subprocess
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from program import call, needs_program

TOOLS = Path(__file__).resolve().parent.parent
BY_ARGPARSE = sorted(path.stem for path in (TOOLS / "musclebench" / "options").glob("*.py") if path.stem not in ("shared", "__init__"))
BY_SHELL = ("build", "lines", "lint", "setup", "test")
SCRIPTS = ("import_lhdl.py",)
COMMANDS = ("", "advise", "check", "field", "hard", "list", "probe", "queries", "record", "replay", "run", "verify")
MOST_WORDS = 28
UNPLAIN = re.compile(r"\b(in place of|of (?:their|its|your) own|beside|told apart|asked about|all the same)\b")
NUMBER_EXPLAINED = re.compile(r"default|\b(?:mm|s|min|GB)\b")


@dataclass
class Option:
    name: str
    text: str
    is_number: bool = False


@dataclass
class Help:
    prose: str
    options: list[Option] = field(default_factory=list)


def sentences(text: str) -> list[str]:
    """Of wrapped lines; an indented line is an item of a list or an example. Defaults in brackets are no part of a sentence."""
    text = re.sub(r"\(default[^()]*\)", "", text)
    return [" ".join(part.split()) for part in re.split(r"(?<=[.!?:])\s+|\n\s*\n|\n(?=\s)", text) if part.strip()]


class Captured(Exception):
    """Holds the parser that a tool made."""


def captured(make, monkeypatch) -> Help:
    def capture(parser, *_):
        raise Captured(parser)

    monkeypatch.setattr(argparse.ArgumentParser, "parse_args", capture)
    with pytest.raises(Captured) as caught:
        make()
    parser = caught.value.args[0]
    actions = [action for action in parser._actions if not isinstance(action, argparse._HelpAction)]
    options = [Option("/".join(action.option_strings) or action.dest, action.help or "", action.type in (int, float)) for action in actions]
    return Help(f"{parser.description}\n\n{parser.epilog or ''}", options)


def help_of_script(name: str, monkeypatch) -> Help:
    loader = importlib.machinery.SourceFileLoader(f"script_{Path(name).stem}", str(TOOLS / name))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader(loader.name, loader))
    loader.exec_module(module)
    return captured(lambda: module.parse_arguments([]), monkeypatch)


def help_of_tool(name: str, monkeypatch) -> Help:
    if name in SCRIPTS:
        return help_of_script(name, monkeypatch)
    tool = importlib.import_module(f"musclebench.options.{name}").TOOL
    return captured(lambda: tool.parse([]), monkeypatch)


def help_of_command(name: str) -> Help:
    """As CLI11 prints it: sections end at an empty line, and an option's text begins in column 30, in its line or the next."""
    told = call(*([name] if name else []), "--help").stdout
    prose, options, in_section = [], [], False
    for line in told.splitlines():
        in_section = (in_section or line in ("Options:", "Positionals:", "Subcommands:")) and bool(line)
        if in_section and line.startswith(" " * 30):
            options[-1].text += f" {line.strip()}"
        elif in_section and line.startswith("  "):
            names, text = (line[:28], line[30:]) if line[28:30].isspace() else (line, "")
            options.append(Option(names.strip(), text, re.search(r" (?:INT|UINT|FLOAT)\b", names) is not None))
        elif not in_section and not line.startswith("Usage:"):
            prose.append(line)
    return Help("\n".join(prose), options)


def check(help_text: Help) -> None:
    for text in (help_text.prose, *(option.text for option in help_text.options)):
        assert [one for one in sentences(text) if len(one.split()) > MOST_WORDS] == []
        assert UNPLAIN.findall(text) == []
    assert [option.name for option in help_text.options if not option.text.strip()] == []
    unexplained = [option.name for option in help_text.options if option.is_number and not NUMBER_EXPLAINED.search(option.text)
                   and not re.search(r"=\S+$|REQUIRED", option.name)]
    assert [name for name in unexplained if name != "--simulate"] == []  # runs nothing unless it is given


def test_sentences_are_counted_over_lines_and_not_over_lists():
    assert sentences("One two\nthree. Four (default: 5, 6)\n\nseven\n  - eight\n  - nine") == \
        ["One two three.", "Four", "seven", "- eight", "- nine"]


def test_no_tool_is_left_out():
    there = {path.name for path in TOOLS.iterdir() if path.is_file() and not path.suffix and path.name != "launch"}
    assert there == {name.replace("_", "-") for name in BY_ARGPARSE} | set(BY_SHELL)


@pytest.mark.parametrize("name", (*BY_ARGPARSE, *SCRIPTS))
def test_a_tool_explains_itself_and_each_option(name, monkeypatch):
    found = help_of_tool(name, monkeypatch)
    assert found.options
    check(found)


@pytest.mark.parametrize("name", BY_SHELL)
def test_a_shell_tool_explains_itself(name):
    done = subprocess.run([str(TOOLS / name), "--help"], capture_output=True, text=True, timeout=60, check=True)
    assert f"tools/{name} [" in done.stdout
    check(Help(done.stdout))


@needs_program
@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_explains_itself_and_each_option(name):
    found = help_of_command(name)
    assert len(found.options) > 1 and found.prose.strip()
    check(found)


@needs_program
def test_no_command_is_left_out():
    named = {option.name for option in help_of_command("").options if not option.name.startswith("-")}
    assert named == set(COMMANDS) - {""}


@needs_program
def test_the_list_explains_each_name_and_each_parameter():
    told = json.loads(call("list", "--json").stdout)
    named = [*told["backends"], *told["effects"], *told["responses"]]
    parameters = [*told["loop"], *(one for entry in named for one in entry.get("parameters", []))]
    assert len(parameters) > 40
    check(Help("", [Option(one["name"], one["help"]) for one in (*named, *parameters)]))
