#!/bin/bash
# The same jobs on this machine, {{{at_once}}} tasks at a time.
set -euo pipefail
cd "$(dirname "$0")"
mkdir -p logs
array() {  # script, number of tasks
  local log=logs/$(basename "$1" .sh)
  seq 1 "$2" | xargs -P {{{at_once}}} -I{} bash -c \
    "SLURM_ARRAY_TASK_ID={} bash $1 >>${log}_{}.log 2>&1" || true  # the next job does what is left
}
submit() {
  bash "$1" >>"logs/$(basename "$1" .sh).log" 2>&1
}
{{{jobs}}}
