# shellcheck shell=bash
# Helpers of tools/setup, tools/demo and tools/test: progress on the terminal, everything else in build/*.log.
# To be sourced by a script that has `set -euo pipefail`. Leaves the caller in the root of the repository.

cd "$(dirname "${BASH_SOURCE[0]}")/.." || exit 1
mkdir -p build
exec </dev/null  # nothing here asks questions; a program that tries must fail instead of waiting

# Child scripts keep counting from the start of the first one.
: "${HANDHOLD_STARTED:=$(date +%s)}"
export HANDHOLD_STARTED

say() { printf '[%4d s] %s\n' "$(($(date +%s) - HANDHOLD_STARTED))" "$*"; }
fail() {
  printf '%s: %s\n' "${0##*/}" "$*" >&2
  exit 1
}

# step TITLE LOG COMMAND...: runs the command with its output in build/LOG; shows the end of the log when it fails.
step() {
  local title=$1 log=build/$2
  shift 2
  say "$title"
  if ! "$@" >"$log" 2>&1; then
    # Compilers print the reason well before the end; without such a line the end of the log has to do.
    grep -m 10 -nE -A3 '(^|[^_[:alnum:]])(error|Error|ERROR)[: ]|CMake Error' "$log" >&2 || tail -n 40 "$log" >&2
    fail "failed: $title; the full log is $log"
  fi
}

# Parallel jobs: one per core, but a job needs up to 2 GiB where PCL's headers are compiled. HANDHOLD_JOBS overrides.
parallel_jobs() {
  local cores gib
  cores=$(nproc)
  gib=$(awk '/^MemAvailable:/ { print int($2 / 2097152) }' /proc/meminfo)
  ((gib >= 1)) || gib=1
  echo "${HANDHOLD_JOBS:-$((cores < gib ? cores : gib))}"
}
