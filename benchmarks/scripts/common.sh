# shellcheck shell=bash
# What the benchmarks' scripts share; to be sourced.

. "$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")/../../scripts/common.sh"

# build_benchmarks TARGET…: builds into build/benchmarks.
build_benchmarks() {
  run_logged "$root/build/log/benchmarks.log" \
    "Building in build/benchmarks (the first time takes some minutes) …" \
    configure_benchmarks "$@"
}

configure_benchmarks() {
  local folder=$root/build/benchmarks
  cmake -S "$root" -B "$folder" -G Ninja -DCMAKE_BUILD_TYPE=Release \
    -DMLE_BUILD_BENCHMARKS=ON -DMLE_BUILD_APPS=OFF -DMLE_BUILD_TESTS=OFF ||
    return
  cmake --build "$folder" --parallel "$(build_jobs)" --target "$@"
}
