# shellcheck shell=bash
# What the benchmarks' scripts share; to be sourced.

. "$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")/../../scripts/common.sh"

# build_benchmarks FOLDER NATIVE TARGET…: builds for this machine (NATIVE ON)
# or for any (OFF) into build/FOLDER.
build_benchmarks() {
  run_logged "$root/build/log/$1.log" \
    "Building in build/$1 (the first time takes some minutes) …" \
    configure_benchmarks "$@"
}

configure_benchmarks() {
  local folder=$root/build/$1 native=$2
  shift 2
  cmake -S "$root" -B "$folder" -G Ninja -DCMAKE_BUILD_TYPE=Release \
    -DMLE_NATIVE="$native" -DMLE_BUILD_BENCHMARKS=ON -DMLE_BUILD_APPS=OFF \
    -DMLE_BUILD_TESTS=OFF || return
  cmake --build "$folder" --parallel "$(build_jobs)" --target "$@"
}
