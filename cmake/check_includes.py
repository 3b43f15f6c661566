#!/usr/bin/env python3
"""Fails on an #include that the graph of CMake targets does not allow.

A header-only include compiles and links whatever the targets say, so nothing else would notice a room that reaches into
one above it. A file belongs to the target that lists it as a source, or, as a header, to the target of its folder. A
source may include what its target DEPENDS on or uses PRIVATE, a header that other targets include only the former; both
with all that those show in their own headers. Headers of tests may be shared by tests.

    cmake/check_includes.py [ROOT]        prints a line a forbidden include; exit code 1 if there is one
"""

import re
import sys
from dataclasses import dataclass, field
from pathlib import Path

ROOMS = ("core", "backends", "bench", "datasets")
# Third-party headers and the packages (as CMake targets) that they come from, besides those in a folder of a target's name.
PACKAGES = {"Eigen/": "Eigen3::Eigen", "hwy/": "hwy::hwy", "assimp/": "assimp::assimp",
            "nlohmann/": "nlohmann_json::nlohmann_json", "CLI/": "CLI11::CLI11", "toml++/": "tomlplusplus::tomlplusplus",
            "zstd.h": "zstd::libzstd_shared", "openssl/": "OpenSSL::Crypto", "benchmark/": "benchmark::benchmark",
            "embree3/": "embree"}
EVERYWHERE = {"musclebench_settings"}
# Whose sources an effect's folder has.
OF_EFFECTS = {"SOURCES": "musclebench_effects", "CHECKS": "musclebench_scene_check", "TESTS": "musclebench_effects_tests"}
DECLARATION = re.compile(r"(musclebench_library|musclebench_effect|musclebench_backend|musclebench_test|add_executable)"
                         r"\(\s*(\w+)([^()]*(?:\([^()]*\)[^()]*)*)\)")
LINKING = re.compile(r"target_link_libraries\(\s*(\w+)\s+(PUBLIC|PRIVATE)([^()]*)\)")
INCLUDE = re.compile(r'^\s*#\s*include\s+["<]([^">]+)[">]', re.MULTILINE)


@dataclass
class Target:
    name: str
    folder: Path
    is_library: bool
    sources: list[str] = field(default_factory=list)
    shown: set[str] = field(default_factory=set)
    hidden: set[str] = field(default_factory=set)


def words(text: str) -> list[str]:
    text = re.sub(r"#.*", "", text)
    text = re.sub(r"\$<TARGET_NAME_IF_EXISTS:([^>]+)>", r"\1", text)
    return re.findall(r'[^\s"]+', text)


def read_targets(root: Path) -> dict[str, Target]:
    targets: dict[str, Target] = {}
    of_effects: list[tuple[Path, str]] = []
    lists = [path for room in ROOMS for path in sorted((root / room).rglob("CMakeLists.txt"))]
    for path in lists:
        for kind, name, body in DECLARATION.findall(path.read_text()):
            if kind == "musclebench_effect":
                of_effects += [(path.parent, body)]
                continue
            name = f"musclebench_backend_{name}" if kind == "musclebench_backend" else name
            target = Target(name, path.parent, kind in ("musclebench_library", "musclebench_backend"))
            key = "SOURCES"
            for word in words(body):
                if word in ("SOURCES", "DEPENDS", "PRIVATE"):
                    key = word
                elif key == "SOURCES":
                    target.sources.append(word)
                else:
                    (target.shown if key == "DEPENDS" else target.hidden).add(word)
            targets[name] = target
    for folder, body in of_effects:
        key = ""
        for word in words(body):
            if word in OF_EFFECTS:
                key = OF_EFFECTS[word]
            elif key in targets:
                targets[key].sources.append(str(folder / word))
    for path in lists:
        for name, visibility, body in LINKING.findall(path.read_text()):
            if name in targets:
                (targets[name].shown if visibility == "PUBLIC" else targets[name].hidden).update(words(body))
    return targets


def closure(names: set[str], targets: dict[str, Target]) -> set[str]:
    seen, ahead = set(), list(names)
    while ahead:
        name = ahead.pop()
        if name not in seen:
            seen.add(name)
            ahead += targets[name].shown if name in targets else []
    return seen


def owners(root: Path, targets: dict[str, Target]) -> dict[Path, set[str]]:
    """The targets that a file belongs to: those that list it, or those of its folder that are libraries."""
    found: dict[Path, set[str]] = {}
    for target in targets.values():
        for source in target.sources:
            found.setdefault(target.folder / source, set()).add(target.name)
    listed_folders: dict[Path, set[str]] = {}
    for path, names in found.items():
        # What the checker knows of an effect lies beside it, and owns no header there.
        if not path.name.endswith("_checks.cpp"):
            listed_folders.setdefault(path.parent, set()).update(names)
    for room in ROOMS:
        for header in sorted((root / room).rglob("*.hpp")):
            if header in found:
                continue
            twin = found.get(header.with_suffix(".cpp"))
            found[header] = twin or listed_folders.get(header.parent, set()) or {
                target.name for target in targets.values() if target.folder == header.parent and target.is_library}
    return found


def package_of(include: str, targets: dict[str, Target]) -> str | None:
    folder, in_folder, _ = include.partition("/")
    if in_folder and any(folder in target.shown | target.hidden for target in targets.values()):
        return folder
    return next((target for prefix, target in PACKAGES.items() if include.startswith(prefix)), None)


def forbidden(root: Path) -> list[str]:
    targets = read_targets(root)
    owned = owners(root, targets)
    public = public_headers(root, owned)
    problems = []
    for path in sorted(path for room in ROOMS for path in (root / room).rglob("*.?pp") if path in owned):
        problems += [f"{path.relative_to(root)}: {problem}" for problem in problems_of(path, root, targets, owned, path in public)]
    return problems


def public_headers(root: Path, owned: dict[Path, set[str]]) -> set[Path]:
    """Those that a file of another target includes, directly or through other headers."""
    included = {path: {root / include for include in INCLUDE.findall(path.read_text())} & owned.keys()
                for path in owned if path.exists()}
    public: set[Path] = set()
    ahead = [header for path, headers in included.items() for header in headers if not owned[path] & owned[header]]
    while ahead:
        header = ahead.pop()
        if header not in public:
            public.add(header)
            ahead += included.get(header, set())
    return public


def allowed_targets(target: Target, targets: dict[str, Target], is_public: bool) -> set[str]:
    direct = target.shown | (set() if is_public and target.is_library else target.hidden)
    return closure(direct | EVERYWHERE, targets) | {target.name}


def problems_of(path: Path, root: Path, targets: dict[str, Target], owned: dict[Path, set[str]],
                is_public: bool) -> list[str]:
    problems = []
    for include in INCLUDE.findall(path.read_text()):
        wanted = owned.get(root / include)
        package = package_of(include, targets)
        wanted = wanted if wanted is not None else {package} if package else None
        if wanted is None and include.startswith(tuple(f"{room}/" for room in ROOMS)) and not (root / include).exists():
            problems.append(f"includes {include}, which does not exist")
        if not wanted or (path.parent.name == "tests" and (root / include).parent.name == "tests"):
            continue
        # A header without a source of its own may be any of its folder's targets'.
        refusing = [name for name in sorted(owned[path]) if not wanted & allowed_targets(targets[name], targets, is_public)]
        if refusing and len(refusing) == len(owned[path]):
            problems.append(f"includes {include} of {', '.join(sorted(wanted))}, which {refusing[0]} does not depend on"
                            + (" in its headers" if is_public else ""))
    return problems


def circles(targets: dict[str, Target]) -> list[str]:
    return [f"{name} depends on itself" for name, target in targets.items()
            if name in closure(target.shown | target.hidden, {n: Target(n, t.folder, t.is_library, [], t.shown | t.hidden)
                                                              for n, t in targets.items()})]


def main() -> int:
    root = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parent.parent).resolve()
    problems = circles(read_targets(root)) + forbidden(root)
    print("\n".join(problems) if problems else "includes: all allowed by the targets")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
