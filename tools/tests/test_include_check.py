"""The check of includes against the graph of CMake targets sees what it is for."""

import subprocess
import sys
from pathlib import Path

CHECK = Path(__file__).resolve().parents[2] / "cmake" / "check_includes.py"
TREE = {
    "core/low/CMakeLists.txt": "musclebench_library(low SOURCES low.cpp)",
    "core/low/low.hpp": "#pragma once\n",
    "core/low/low.cpp": '#include "core/low/low.hpp"\n',
    "core/other/CMakeLists.txt": "musclebench_library(other SOURCES other.cpp)",
    "core/other/other.hpp": "#pragma once\n",
    "core/other/other.cpp": '#include "core/other/other.hpp"\n',
    "bench/high/CMakeLists.txt": "musclebench_library(high SOURCES high.cpp DEPENDS low PRIVATE other)\n"
                                 "musclebench_library(user SOURCES user.cpp DEPENDS high)",
    "bench/high/high.hpp": '#include "core/low/low.hpp"\n',
    "bench/high/high.cpp": '#include "bench/high/high.hpp"\n#include "core/other/other.hpp"\n',
    "bench/high/user.cpp": '#include "bench/high/high.hpp"\n#include "core/low/low.hpp"\n',
}


def check(folder: Path, changes: dict[str, str] | None = None) -> tuple[int, str]:
    for name, text in (TREE | (changes or {})).items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    done = subprocess.run([sys.executable, str(CHECK), str(folder)], capture_output=True, text=True)
    return done.returncode, done.stdout


def test_what_the_targets_depend_on_may_be_included(tmp_path):
    assert check(tmp_path) == (0, "includes: all allowed by the targets\n")


def test_a_room_may_not_reach_into_one_above_it(tmp_path):
    code, told = check(tmp_path, {"core/low/low.cpp": '#include "bench/high/high.hpp"\n'})
    assert code == 1 and told.startswith("core/low/low.cpp: includes bench/high/high.hpp of")


def test_a_private_dependency_stays_out_of_headers_that_others_include(tmp_path):
    code, told = check(tmp_path, {"bench/high/high.hpp": '#include "core/other/other.hpp"\n'})
    assert code == 1 and "bench/high/high.hpp: includes core/other/other.hpp" in told and "in its headers" in told


def test_a_header_that_is_not_there_is_told(tmp_path):
    code, told = check(tmp_path, {"core/low/low.cpp": '#include "core/low/gone.hpp"\n'})
    assert code == 1 and "includes core/low/gone.hpp, which does not exist" in told


def test_targets_may_not_depend_on_each_other_in_a_circle(tmp_path):
    code, told = check(tmp_path, {"core/low/CMakeLists.txt": "musclebench_library(low SOURCES low.cpp DEPENDS high)"})
    assert code == 1 and "low depends on itself" in told and "high depends on itself" in told
