#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Holds that errors of platforms and their programs are values: C++ there neither throws nor catches. Exit 1 names each line that does.

std::bad_alloc may be caught by whoever can say so to the user. ALLOWED names other lines, each with its reason.
"""
import pathlib
import re
import sys

ROOMS = ("platform", "apps/viewer", "apps/xr")
SUFFIXES = (".h", ".hpp", ".cpp", ".c", ".mm")
NOT_CODE = re.compile(r'"(?:\\.|[^"\\\n])*"|//[^\n]*|/\*.*?\*/', re.S)
THROWS = re.compile(r"\bthrow\b|\bcatch\s*\((?!\s*const std::bad_alloc&\s*\))|\b(?:std::(?:\w+_error\b(?!_code)|exception)|rethrow_exception)\b")
ALLOWED = {
    ("apps/viewer/options.cpp", "catch (const CLI::ParseError"): "CLI11 tells so of a wrong argument",
    ("apps/xr/main.cpp", "catch (const CLI::ParseError"): "CLI11 tells so of a wrong argument",
    ("platform/desktop/gui.cpp", "throw ImGuiStopped"): "Dear ImGui goes on after a failed call, with handles that are not there",
    ("platform/desktop/gui.cpp", "catch (const ImGuiStopped"): "takes what the line above throws, in the same file",
}


def problems(files):
    """files: {path: text}. Also names entries of ALLOWED that nothing needs."""
    used = set()
    for path, text in files.items():
        code = NOT_CODE.sub(lambda found: re.sub(r"[^\n]", " ", found.group()), text)
        for number, line in enumerate(code.splitlines(), 1):
            if not THROWS.search(line):
                continue
            reason = [key for key in ALLOWED if key[0] == path and key[1] in line]
            used.update(reason)
            if not reason:
                yield f"{path}:{number}: {line.strip()}. Return a Result or a Status (platform/common/errors.h)"
    yield from (f"ALLOWED names {path}, which has no '{text}'" for path, text in sorted(ALLOWED.keys() - used))


def check_itself():
    bad = ("throw Error();", "} catch (...) {", "} catch (const std::exception& e) {", "struct A : std::runtime_error {", "    throw;")
    good = ("} catch (const std::bad_alloc&) {", "// never throw", 'note("throw");', "throwDoppel(env);", "std::error_code e;", "env->Throw(x);")
    for wanted, lines in ((1, bad), (0, good)):
        for line in lines:
            found = [problem for problem in problems({"platform/a.cpp": line}) if problem.startswith("platform/a.cpp:1:")]
            assert len(found) == wanted, (line, found)


def main():
    check_itself()
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".").resolve()
    paths = [path for room in ROOMS for path in sorted((root / room).rglob("*")) if path.suffix in SUFFIXES]
    files = {path.relative_to(root).as_posix(): path.read_text(errors="replace") for path in paths}
    found = list(problems(files))
    for problem in found:
        print(problem)
    print(f"{len(files)} files checked, {len(found)} wrong")
    return 1 if found or len(files) < 50 else 0


if __name__ == "__main__":
    sys.exit(main())
