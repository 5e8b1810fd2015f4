#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Tells Snakemake how a Slurm job fares: running, success or failed.
# A job that the controller has forgotten had ended; Snakemake then looks at its output.
state=$(scontrol show job "$1" 2>/dev/null | sed -n 's/.*JobState=\([A-Z_]*\).*/\1/p')
case "$state" in
    PENDING|CONFIGURING|RUNNING|SUSPENDED|COMPLETING|REQUEUED|RESIZING) echo running ;;
    COMPLETED|"") echo success ;;
    *) echo failed ;;
esac
