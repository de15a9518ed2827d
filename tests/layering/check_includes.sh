#!/usr/bin/env bash
# check_includes.sh ROOT: checks the includes of every source below ROOT.
#
# Exit codes: 0 all as it should be; 1 a rule is broken; 2 nothing to check.
set -euo pipefail

here=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd)
cd -- "${1:?the root of the project is missing}"

folders=()
for folder in mle sim control apps benchmarks examples python tests; do
  if [[ -d $folder ]]; then folders+=("$folder"); fi
done
sources=()
if ((${#folders[@]} > 0)); then
  mapfile -d '' -t sources < <(
    find "${folders[@]}" -type f -regex '.*\.\(h\|hh\|hpp\|inc\|c\|cc\|cpp\|cxx\)' \
      -print0 | sort -z)
fi
if ((${#sources[@]} == 0)); then
  echo "no sources below $PWD" >&2
  exit 2
fi

awk -f "$here/check_includes.awk" "${sources[@]}"
echo "${#sources[@]} files, every include as docs/architecture.md has it"
