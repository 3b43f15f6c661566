"""The list of faults applies to the code as it is, and a campaign keeps and tells what it found."""

import json
import subprocess
from pathlib import Path

import pytest
from musclebench.mutants.campaign import Campaign, summary
from musclebench.mutants.faults import Fault, FaultListError, problems_of, read_faults, stale_keys
from musclebench.mutants.scratch_build import BuildFailed, ProgramRun, ScratchBuild, nearest_first

ROOT = Path(__file__).resolve().parent.parent.parent
SOURCE = "int three() { return 3; }\nint four() { return 4; }\n"


def fault(name="three", line="return 3;", replaced_by="return 2;", file="core/numbers.cpp", may_survive=""):
    return Fault(name, file, line, replaced_by, may_survive)


@pytest.fixture
def root(tmp_path):
    """A checkout with one source file."""
    folder = tmp_path / "checkout"
    (folder / "core").mkdir(parents=True)
    (folder / "core/numbers.cpp").write_text(SOURCE)
    subprocess.run(["git", "init", "-q", str(folder)], check=True)
    return folder


class FakeBuild:
    """Two programs; `near` sees a 2 for the 3, none sees anything about the 4, and a 5 does not compile."""

    def __init__(self, tree):
        self._file = tree / "core/numbers.cpp"
        self.log = []

    def configure(self):
        self.log.append("configure")

    def programs(self):
        return ["bench/far_tests", "core/near_tests"]

    def stale(self, programs):
        return programs

    def build(self, programs):
        if "return 5" in self._file.read_text():
            raise BuildFailed("error: no 5 today")

    def run(self, program, timeout_s):
        self.log.append(program)
        sees = program == "core/near_tests" and "return 2" in self._file.read_text()
        return ProgramRun(not sees, 0.1, "Numbers.Three" if sees else "")


def judged(root, tmp_path, faults, **options):
    folder = tmp_path / "scratch"
    build = FakeBuild(folder / "tree")
    campaign = Campaign(root, folder, build, **options)
    campaign.prepare(faults)
    build.log.clear()
    campaign.judge_all(faults)
    return campaign, build


def test_every_listed_fault_applies():
    done = subprocess.run([str(ROOT / "tools/mutants"), "--check"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_a_fault_that_does_not_apply_is_told(root):
    (root / "backends.cpp").write_text(SOURCE)
    problems = problems_of([fault(), fault("gone", "return 9;"), fault("twice", "return "), fault("same", "int", "int"),
                            fault("moved", file="core/no.cpp"), fault("elsewhere", file="backends.cpp")], root)
    assert [problem.split(":")[0] for problem in problems[:5]] == ["gone", "twice", "same", "moved", "elsewhere"]
    assert "needs 80" in problems[5]


def test_no_more_than_two_may_survive(root):
    excused = [fault(str(i), replaced_by=f"return {10 + i};", may_survive="can't be seen") for i in range(80)]
    assert problems_of(excused[:2] + [fault(str(i), replaced_by=f"return {10 + i};") for i in range(2, 80)], root) == []
    assert "80 faults may survive" in problems_of(excused, root)[0]


def test_the_same_fault_twice_is_told(root):
    """Also where the two name a line with more and with less around it."""
    problems = problems_of([fault(), fault("again"), fault("longer", "{ return 3; }", "{ return 2; }"),
                            fault("other", replaced_by="return 1;")], root)
    assert problems[:2] == ["again: is three once more; remove one", "longer: is three once more; remove one"]
    assert "needs 80" in problems[2] and len(problems) == 3


def test_a_seen_fault_that_is_not_listed_is_told(tmp_path):
    seen = tmp_path / "list_seen.json"
    assert stale_keys([fault()], seen) == []
    seen.write_text(json.dumps({fault().key: "near_tests", fault(line="return 9;").key: "near_tests"}))
    told = stale_keys([fault()], seen)
    assert len(told) == 1 and "return 9;" in told[0] and "no such fault" in told[0]
    listed = tmp_path / "list.toml"
    listed.write_text('[[fault]]\nname = "a"\nfile = "f"\nline = "l"\nfault = "x"\n')
    done = subprocess.run([str(ROOT / "tools/mutants"), "--check", "--faults", str(listed)], capture_output=True,
                          text=True, check=False)
    assert done.returncode == 1 and "return 9;" in done.stderr


@pytest.mark.parametrize("text, word", [
    ('[[fault]]\nname = "a"\nfile = "f"\nline = "l"\n', "given"),
    ('[[fault]]\nname = "a"\nfile = "f"\nline = "l"\nfault = "x"\nwhy = "y"\n', "why"),
    ('[[fault]]\nname = "a"\nfile = "f"\nline = "l"\nfault = 3\n', "text"),
    ('[[fault]]\nname = "a"\nfile = "f"\nline = "l"\nfault = "x"\n' * 2, "name of its own"),
    ("[[fault", "list.toml"),
])
def test_a_broken_list_is_told_in_one_line(tmp_path, text, word):
    path = tmp_path / "list.toml"
    path.write_text(text)
    with pytest.raises(FaultListError, match=word):
        read_faults(path)


CMAKE_LISTS = """
cmake_minimum_required(VERSION 3.25)
project(numbers LANGUAGES CXX)
add_library(numbers STATIC core/numbers.cpp)
add_executable(near_tests near.cpp)
target_link_libraries(near_tests PRIVATE numbers)
add_executable(far_tests far.cpp)
"""


@pytest.fixture
def real_build(root, tmp_path):
    """The checkout as a CMake project of two test programs, one of which links the source file."""
    (root / "CMakeLists.txt").write_text(CMAKE_LISTS)
    (root / "near.cpp").write_text("int three();\nint main() { return three() == 3 ? 0 : 1; }\n")
    (root / "far.cpp").write_text("int main() { return 0; }\n")
    return ScratchBuild(root, tmp_path / "build", jobs=2)


def test_a_real_build_tells_what_a_change_reaches_and_who_sees_it(root, tmp_path, real_build):
    campaign = Campaign(root, tmp_path / "scratch", ScratchBuild(tmp_path / "scratch/tree", tmp_path / "build", jobs=2))
    seen, missed = fault(), fault("four", "return 4;", "return 5;")
    campaign.prepare([seen, missed])
    campaign.judge_all([seen, missed])
    assert campaign.verdict(seen).outcome == "seen"
    assert campaign.verdict(seen).detail == "near_tests: exit code 1"
    assert (campaign.verdict(missed).outcome, campaign.verdict(missed).detail) == ("survived", "")


@pytest.fixture
def python_root(root):
    """A module that another one imports, and tests of both; one fails whatever the code."""
    files = {"tools/musclebench/__init__.py": "", "tools/musclebench/numbers/near.py": "def three():\n    return 3\n\n\ndef four():\n    return 4\n",
             "tools/musclebench/numbers/far.py": "from .near import three\n\n\ndef six():\n    return 2 * three()\n",
             "tools/command.py": "import musclebench.numbers.broken as broken\n", "tools/musclebench/numbers/broken.py": "one = 1\n",
             "tools/tests/conftest.py": "import sys\nsys.path.insert(0, 'tools')\n",
             "tools/tests/test_far.py": "from musclebench.numbers.far import six\n\n\ndef test_six():\n    assert six() == 6\n",
             "tools/tests/test_near.py": "from musclebench.numbers import near\n\n\ndef test_that_it_counts():\n    assert near.three() > 2\n",
             "tools/tests/test_broken.py": "import command\n\n\ndef test_never():\n    assert not command\n"}
    for name, text in files.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text)
    return root


@pytest.mark.long
def test_faults_in_python_are_seen_by_tests_that_import_the_module(python_root, tmp_path):
    near = "tools/musclebench/numbers/near.py"
    seen, by_another, missed = (fault("seen", "return 3", "return 1", near), fault("far", "return 3", "return 5", near),
                                fault("missed", "return 4", "return 5", near))
    campaign, build = judged(python_root, tmp_path, [seen, by_another, missed])
    assert build.log == []  # nothing was built
    assert campaign.verdict(seen).detail == "test_near.py: test_that_it_counts"
    assert campaign.verdict(by_another).detail == "test_far.py: test_six"
    assert campaign.verdict(missed).outcome == "survived" and campaign.verdict(missed).detail == ""
    alone = fault("alone", "sys.path", "sys.pith", "tools/tests/conftest.py")
    assert judged(python_root, tmp_path, [alone])[0].verdict(alone).detail == "no test imports the file"
    broken = fault("broken", "one = 1", "one = 2", "tools/musclebench/numbers/broken.py")
    with pytest.raises(BuildFailed, match="test_broken.py fails without a fault: test_never"):
        judged(python_root, tmp_path, [broken])


def test_a_build_that_configures_anew_each_time_is_no_judge(root, real_build):
    with (root / "CMakeLists.txt").open("a") as lists:
        lists.write('file(GLOB found CONFIGURE_DEPENDS "core/*.cpp")\n')
    real_build.configure()
    real_build.build(real_build.programs())
    with pytest.raises(BuildFailed, match="CONFIGURE_DEPENDS"):
        real_build.stale(real_build.programs())


def test_programs_near_the_file_come_first():
    programs = ["bench/cases/a_tests", "core/bvh/b_tests", "core/bvh/batch/c_tests", "core/pbd/d_tests"]
    order = nearest_first(programs, "core/bvh/triangle_bvh.cpp", {"core/bvh/batch/c_tests": 1.0})
    assert order == ["core/bvh/b_tests", "core/bvh/batch/c_tests", "core/pbd/d_tests", "bench/cases/a_tests"]


def test_a_fault_is_seen_by_the_nearest_program_and_taken_back(root, tmp_path):
    campaign, build = judged(root, tmp_path, [fault()])
    assert campaign.verdict(fault()).outcome == "seen"
    assert campaign.verdict(fault()).detail == "near_tests: Numbers.Three"
    assert build.log == ["core/near_tests"]
    assert (tmp_path / "scratch/tree/core/numbers.cpp").read_text() == SOURCE
    assert summary([fault()], campaign) == (["1 faults: 1 seen, 0 survived, 0 could not be built"], True)


def test_a_survivor_needs_a_reason(root, tmp_path):
    survivor = fault("four", "return 4;", "return 6;")
    lines, is_well = summary([survivor], judged(root, tmp_path, [survivor])[0])
    assert not is_well
    assert "a test is missing" in lines[1]
    excused = fault("four", "return 4;", "return 6;", may_survive="nobody asks for four")
    lines, is_well = summary([excused], judged(root, tmp_path, [excused])[0])
    assert is_well
    assert "nobody asks for four" in lines[1]


def test_a_fault_that_does_not_compile_is_an_error(root, tmp_path):
    broken = fault("five", "return 4;", "return 5;")
    lines, is_well = summary([broken], judged(root, tmp_path, [broken])[0])
    assert not is_well
    assert "no 5 today" in lines[1]


def test_a_campaign_goes_on_where_it_was(root, tmp_path):
    survivor = fault("four", "return 4;", "return 6;")
    judged(root, tmp_path, [fault()])
    assert judged(root, tmp_path, [fault(), survivor])[1].log == ["core/near_tests", "bench/far_tests"]
    assert judged(root, tmp_path, [fault(), survivor])[1].log == []
    (root / "core/numbers.cpp").write_text(SOURCE + "// changed\n")
    assert judged(root, tmp_path, [fault()])[1].log == ["core/near_tests"]


def test_what_was_seen_may_be_taken_as_seen_elsewhere(root, tmp_path):
    seen, survivor = tmp_path / "seen.json", fault("four", "return 4;", "return 6;")
    judged(root, tmp_path, [fault(), survivor], seen=seen)
    assert list(json.loads(seen.read_text()).values()) == ["near_tests: Numbers.Three"]
    (root / "core/numbers.cpp").write_text(SOURCE + "// changed\n")
    elsewhere = tmp_path / "elsewhere"
    campaign, build = judged(root, elsewhere, [fault(), survivor], seen=seen)
    assert build.log == ["core/near_tests", "bench/far_tests"]  # the survivor alone
    assert campaign.verdict(fault()).outcome == "seen"
    (root / "core/numbers.cpp").write_text(SOURCE + "// changed again\n")
    assert judged(root, elsewhere, [fault()])[1].log == ["core/near_tests"]


def test_what_some_programs_miss_is_judged_again(root, tmp_path):
    assert judged(root, tmp_path, [fault()], pattern="bench/*")[1].log == ["bench/far_tests"]
    assert judged(root, tmp_path, [fault()])[1].log == ["core/near_tests"]


def test_a_program_that_fails_without_a_fault_ends_the_campaign(root, tmp_path):
    (root / "core/numbers.cpp").write_text(SOURCE.replace("3", "2"))
    with pytest.raises(BuildFailed, match="core/near_tests fails without a fault"):
        judged(root, tmp_path, [fault()])
