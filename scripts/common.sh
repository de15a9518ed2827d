# shellcheck shell=bash
# What the scripts share; to be sourced. Sets `root`, the project's folder.

root=$(dirname -- "$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")")

# run_logged LOG MESSAGE COMMAND…
#
# Says MESSAGE and where LOG is, and runs COMMAND quietly, with what it says
# going to LOG; on a terminal, shows how far a build is. If it fails, shows the
# end of LOG and returns its exit code.
run_logged() {
  local log=$1 message=$2 code=0 watcher=
  shift 2
  mkdir -p -- "$(dirname -- "$log")"
  printf '%s (log: %s)\n' "$message" "${log#"$root"/}" >&2
  if [[ -t 2 ]]; then
    : >"$log"
    show_targets "$log" &
    watcher=$!
  fi
  "$@" >"$log" 2>&1 || code=$?
  if [[ -n $watcher ]]; then
    kill "$watcher" 2>/dev/null || true
    wait "$watcher" 2>/dev/null || true
    printf '\r\e[K' >&2
  fi
  if ((code != 0)); then
    printf '… failed (exit code %d). The end of %s:\n' "$code" "$log" >&2
    tail -n 40 -- "$log" >&2
  fi
  return "$code"
}

# show_targets LOG: every second, in one line that is rewritten, how many targets
# Ninja has done of all; as long as the script runs.
show_targets() {
  local targets
  while sleep 1 && kill -0 $$ 2>/dev/null; do
    targets=$(tail -c 4096 -- "$1" | tr '\r' '\n' | grep -aoE '^\[[0-9]+/[0-9]+\]' | tail -n 1) || continue
    targets=${targets//[\[\]]/}
    printf '\r%s of %s targets\e[K' "${targets%/*}" "${targets#*/}" >&2
  done
}

# Fuzz targets that need the commands, or the correction as a whole: they double
# what is to be built.
large_fuzzers='campaign|correction|flag_values'

# The others, of readers and numerics.
library_fuzzers() {
  find "$root/tests/fuzz/corpus" -mindepth 1 -maxdepth 1 -type d -printf '%f\n' |
    grep -vxE "$large_fuzzers" | sort
}

# How many compilers at once: one for each processor, as far as the memory goes
# (the largest sources take about 1 GB each).
build_jobs() {
  local processors gigabytes
  processors=$(nproc)
  gigabytes=$(awk '/^MemAvailable:/ { print int($2 / 1e6) }' /proc/meminfo)
  echo $((gigabytes < 1 ? 1 : gigabytes < processors ? gigabytes : processors))
}

# build PRESET [TARGET…]: configures and builds, all or some targets, into
# build/PRESET.
build() {
  run_logged "$root/build/log/$1.log" \
    "Building in build/$1 (the first time takes some minutes) …" \
    configure_and_compile "$@"
}

configure_and_compile() {
  local preset=$1 targets=()
  if (($# > 1)); then targets=(--target "${@:2}"); fi
  cd -- "$root" || return
  # What an earlier run cached may no longer hold: the project moved, or the
  # system's packages changed. Then once more from nothing.
  cmake --preset "$preset" || cmake --fresh --preset "$preset" || return
  cmake --build --preset "$preset" --parallel "$(build_jobs)" "${targets[@]}"
}
