#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Holds how tests wait: for events, not for time, so that a busy machine only makes them slower.

Refused in tests/: sleeping, reading a clock, limits below ten minutes on programs that a test starts, and TIMEOUT below that of all tests
(tests/CMakeLists.txt). ALLOWED names the files that may do one of the first two, each with its reason. Exit 1 names each line.
"""
import pathlib
import re
import sys

LEAST_LIMIT_S = 600  # of a wait or a program: only what hangs takes so long

CPP, PYTHON, SHELL, JAVA, SWIFT = {".cpp", ".h", ".c", ".mm"}, {".py"}, {".sh", ""}, {".java", ".kt"}, {".swift"}
SLEEPS = [(CPP, r"\bsleep_(for|until)\b|\b(u|nano)sleep\("), (PYTHON, r"\btime\.sleep\("), (SHELL, r"(^|[;&|({]|\bdo|\bthen|\belse)\s*sleep\s"),
          (JAVA, r"\bThread\.sleep\("), (SWIFT, r"\b(Thread|Task)\.sleep\(|\basyncAfter\(")]
CLOCKS = [(CPP, r"\b(steady|system|high_resolution)_clock\b|\bCLOCK_(MONOTONIC|REALTIME)\b"),
          (PYTHON, r"\btime\.(time|monotonic|perf_counter)\("), (SHELL, r"\$\{?(SECONDS|EPOCH)|\bdate \+%s"),
          (JAVA, r"\bSystem\.(nanoTime|currentTimeMillis)\("), (SWIFT, r"\bDate\(\)|\bDispatchTime\.now\(")]
LIMITS = [(PYTHON, r"\btimeout=([\d.]+)"), (SHELL, r"\btimeout ([\d.]+)")]

ALLOWED = {
    "platform/apple/Tests/DoppelTests/ViewTests.swift": "gives a slot back while another call may be waiting for it; the call gets it either way",
    "tests/android/java/Checks.java": "waitUntil, with which the tests of Java and Kotlin look for a state that no event tells of",
    "tests/android/java/WindowTest.java": "looks for 0.2 s that a load makes no progress; a slow machine can only make that true",
    "tests/android/kotlin/ApiTest.kt": "paces frames, so that a load gets on while a view draws; no result depends on it",
    "tests/fuzz/fuzz_driver.cpp": "--seconds, for long runs by hand; CTest gives --runs",
    "tests/metal/host_bench.cpp": "a benchmark: prints times and judges none",
    "tests/metal/software/software_device.cpp": "the timestamps of a device; nothing compares them with a limit",
    "tests/pipeline/independence.sh": "looks again for a file or the end of a run",
    "tests/unit/core/jobs_test.cpp": "lets threads fall asleep between loops; the loops must finish whether or not they did",
    "tests/unit/interop/interop_load_test.cpp": "looks for some milliseconds that a load waits; a slow machine can only make that true",
    "tests/unit/interop/ways_bench.cpp": "a benchmark: prints times and judges none",
    "tests/unit/wait_until.h": "waitUntil, with which the tests of C++ look for a state that no event tells of",
    "tests/web/referee.cpp": "--time, for docs/benchmarks/web.md: prints times and judges none",
    "tests/viewer/panels_test.py": "presses until a button shows it; prints how long the clicks took and judges none",
    "tests/viewer/viewer_test.py": "takes pictures of a window until one shows what must come",
}


def matches(patterns, suffix, line):
    return next((found for suffixes, pattern in patterns if suffix in suffixes and (found := re.search(pattern, line))), None)


def timeouts(path, text, least_s):
    """Lines of a CMake file that give a test less time than all tests have."""
    for number, line in enumerate(text.splitlines(), 1):
        for value in re.findall(r"\bTIMEOUT (\d+)", line):
            if int(value) < least_s:
                yield f"{path}:{number}: TIMEOUT {value} is below the {least_s} s of all tests (tests/CMakeLists.txt)"


def problems(files, least_s):
    """files: {path: text}. Also names entries of ALLOWED that nothing needs."""
    used = set()
    for path, text in files.items():
        suffix = pathlib.PurePosixPath(path).suffix
        if path.endswith(("CMakeLists.txt", ".cmake")):
            yield from timeouts(path, text, least_s)
        if suffix == "" and not text.startswith("#!"):
            continue
        for number, line in enumerate(text.splitlines(), 1):
            if (limit := matches(LIMITS, suffix, line)) and float(limit[1]) < LEAST_LIMIT_S:
                yield f"{path}:{number}: {limit[1]} s may be too short on a busy machine; {LEAST_LIMIT_S} s end what hangs as well"
            what = "sleeps" if matches(SLEEPS, suffix, line) else "reads a clock" if matches(CLOCKS, suffix, line) else None
            if what and path in ALLOWED:
                used.add(path)
            elif what:
                yield (f"{path}:{number}: {what}. Wait for an event (tests/unit/wait_until.h), or count instead of timing; "
                       "if neither can be, give the reason in ALLOWED of check_waits.py")
    yield from (f"ALLOWED names {path}, which neither sleeps nor reads a clock" for path in sorted(ALLOWED.keys() - used))


def check_itself():
    bad = {"tests/a.cpp": "std::this_thread::sleep_for(kPause);", "tests/b.py": "    time.sleep(1)", "tests/c.sh": "sleep 1",
           "tests/d.cpp": "const auto start = std::chrono::steady_clock::now();", "tests/e.py": "run(command, timeout=30)",
           "tests/f.sh": "timeout 60 \"$1\"", "tests/g/CMakeLists.txt": "set_tests_properties(a PROPERTIES TIMEOUT 60)",
           "tests/h.java": "Thread.sleep(1);", "tests/i.sh": "until [ -e a ]; do sleep 0.1; done", "tests/j": "#!/bin/sh\nsleep 1"}
    for path, text in bad.items():
        found = [problem for problem in problems({path: text}, 3600) if problem.startswith(path)]
        assert len(found) == 1, (path, found)
    good = {"tests/a.cpp": 'runProgram({"sleep", "60"}); future.wait();', "tests/b.py": "run(command, timeout=600)",
            "tests/c.sh": "wait $pid  # no sleep 1", "tests/g/CMakeLists.txt": "set_tests_properties(a PROPERTIES TIMEOUT 7200)"}
    assert not [problem for problem in problems(good, 3600) if problem.startswith("tests/")]


def main():
    check_itself()
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".").resolve()
    least_s = re.search(r"set\(test_timeout_s (\d+)\)", (root / "tests/CMakeLists.txt").read_text())
    if not least_s:
        sys.exit("tests/CMakeLists.txt does not set test_timeout_s")
    wanted = CPP | PYTHON | SHELL | JAVA | SWIFT | {".txt", ".cmake"}
    here = pathlib.Path(__file__).resolve()
    paths = [*sorted((root / "tests").rglob("*")), *sorted((root / "platform").glob("*/Tests/**/*")), *sorted((root / "tools/cmake").glob("*"))]
    files = {p.relative_to(root).as_posix(): p.read_text(errors="replace") for p in paths if p.is_file() and p.suffix in wanted and p != here}
    found = list(problems(files, int(least_s[1])))
    for problem in found:
        print(problem)
    print(f"{len(files)} files checked, {len(found)} wrong")
    return 1 if found or len(files) < 100 else 0


if __name__ == "__main__":
    sys.exit(main())
