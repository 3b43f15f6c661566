"""Every declaration of an installed header says what it is, and the examples for others include such headers only."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
HEADERS = [line for line in (ROOT / "cmake" / "public_headers.txt").read_text().splitlines() if line and line[0] != "#"]
INCLUDE = re.compile(r'#include "((?:core|backends)/[^"]+)"')
NAME = re.compile(r"(operator[^\w\s(]+|\w+)\s*\(")
# These say nothing that a docstring could add to.
SILENT = re.compile(r"(struct|class|enum class) \w+;|static_assert|namespace|extern|template <> ")


def declarations(text: str) -> list[tuple[int, str]]:
    """Those of namespace scope, each with the index of its first line. Braces of namespaces are no scope."""
    found, depth, statement, first = [], 0, "", 0
    for index, line in enumerate(text.splitlines()):
        code = re.sub(r"//.*", "", line).strip()
        if not code or (code.startswith("#") and depth == 0) or code.startswith("namespace "):
            continue
        if code == "}" and depth == 0:
            continue
        first = first if statement else index
        statement += " " + code
        depth += code.count("{") - code.count("}")
        if depth == 0 and (code.endswith(";") or code.endswith("}")):
            found.append((first, statement.strip()))
            statement = ""
    return found


def undocumented(text: str) -> list[str]:
    """Overloads may share the docstring of the first of them."""
    lines, missing, last_name = text.splitlines(), [], ""
    for index, statement in declarations(text):
        named = NAME.search(statement.split("{")[0])
        name = named.group(1) if named else ""
        above = lines[index - 1].strip()
        is_overload = name and name == last_name and above and not above.startswith("//")
        if not (above.startswith("///") or is_overload or SILENT.match(statement)):
            missing.append(statement[:60])
        last_name = name
    return missing


@pytest.mark.parametrize("header", HEADERS)
def test_each_declaration_has_a_docstring(header):
    assert undocumented((ROOT / header).read_text()) == []


def test_a_declaration_without_a_docstring_is_found():
    text = """#pragma once
namespace musclebench {

struct Ahead;

/// Documented.
struct Good {
  int a = 0;  ///< a member
};

struct Bare {
  void f() {}
};

/// Of two overloads.
void give(int a);
void give(double a,
          double b);
void other();

template <typename T>
void bare_template(T t);

}  // namespace musclebench
"""
    assert undocumented(text) == ["struct Bare { void f() {} };", "void other();", "template <typename T> void bare_template(T t);"]


def test_the_list_has_every_header_once_and_all_that_they_include():
    assert len(HEADERS) == len(set(HEADERS))
    included = {include for header in HEADERS for include in INCLUDE.findall((ROOT / header).read_text())}
    assert included - set(HEADERS) == set()


@pytest.mark.parametrize("folder", ["backends/tests/capsule", "cmake/tests/outside_project"])
def test_an_example_for_others_includes_installed_headers_only(folder):
    included = {include for source in (ROOT / folder).glob("*.cpp") for include in INCLUDE.findall(source.read_text())}
    assert included and included - set(HEADERS) == set()
