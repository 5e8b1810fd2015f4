#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# again_after_crash.sh PROGRAM [ARGUMENTS]: runs it, and once more when a signal killed it. A test that fails is not run again.
# For lavapipe 22.3.6 with 512-bit vectors alone: its own code died by SIGSEGV in two of some sixty runs, both beside other tests, never twice and never under a debugger.
"$@"
status=$?
[ "$status" -gt 128 ] || exit "$status"
echo "[   NOTE   ] killed by signal $((status - 128)): once more"
exec "$@"
