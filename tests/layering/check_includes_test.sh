#!/usr/bin/env bash
# Every rule of check_includes.awk must be able to fail: each case is a tree of
# one file with one line, and what is to be said about it.
set -euo pipefail

here=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd)
scratch=$(mktemp -d)
trap 'rm -rf -- "$scratch"' EXIT
failures=0

# run FILE LINE: checks a tree that holds nothing but LINE in line 3 of FILE.
run() {
  rm -rf -- "${scratch:?}/tree"
  mkdir -p -- "$scratch/tree/$(dirname -- "$1")"
  printf '// A file.\n\n%s\n' "$2" >"$scratch/tree/$1"
  bash "$here/check_includes.sh" "$scratch/tree" >"$scratch/out" 2>&1
}

fail() {
  printf 'FAILED: %s\n' "$1"
  sed 's/^/    /' "$scratch/out"
  failures=$((failures + 1))
}

# forbidden FILE LINE RULE
forbidden() {
  if run "$1" "$2"; then
    fail "$2 in $1 was accepted"
  elif ! grep -qF -- "$1:3: " "$scratch/out" || ! grep -qF -- "$3" "$scratch/out"; then
    fail "$2 in $1: expected \"$1:3: … $3\""
  fi
}

# permitted FILE LINE
permitted() {
  if ! run "$1" "$2"; then fail "$2 in $1 was refused"; fi
}

layers=(base model data regression nonlinear correction)
for ((i = 0; i < ${#layers[@]}; ++i)); do
  for ((j = 0; j < ${#layers[@]}; ++j)); do
    file=mle/${layers[i]}/a.cc
    line="#include \"mle/${layers[j]}/b.h\""
    if ((j <= i)); then
      permitted "$file" "$line"
    else
      forbidden "$file" "$line" "mle/${layers[i]} may include only mle/base"
    fi
  done
  for folder in sim control apps python tests benchmarks; do
    forbidden "mle/${layers[i]}/a.h" "#include \"$folder/b.h\"" \
      "mle/${layers[i]} may include only mle/base"
  done
done

for folder in sim control; do
  for layer in base model data; do
    permitted "$folder/a.cc" "#include \"mle/$layer/b.h\""
  done
  for layer in regression nonlinear correction; do
    forbidden "$folder/a.cc" "#include \"mle/$layer/b.h\"" "$folder may include only"
  done
done
forbidden sim/a.h '#include "control/mpc.h"' 'sim may include only'
forbidden control/a.cc '#include "sim/plant.h"' 'control may include only'
forbidden control/a.cc '#include "apps/b.h"' 'control may include only'
permitted apps/report/a.cc '#include "mle/correction/b.h"'
permitted apps/a.cc '#include "sim/plant.h"'
permitted tests/sim/a.cc '#include "control/mpc.h"'
permitted python/src/a.cc '#include "apps/correct/b.h"'
forbidden apps/a.cc '#include "python/src/b.h"' 'apps may include only'
forbidden python/src/a.cc '#include "tests/b.h"' 'python may include only'

permitted apps/a.cc '#include <gflags/gflags.h>'
permitted apps/report/a.cc '#include "gflags/gflags.h"'
forbidden mle/model/a.cc '#include "gflags/gflags.h"' 'gflags is for apps/ alone'
forbidden benchmarks/a.cc '#include <gflags/gflags.h>' 'gflags is for apps/ alone'

permitted mle/nonlinear/a.cc '#include "ceres/ceres.h"'
forbidden mle/nonlinear/a.h '#include "ceres/ceres.h"' 'ceres is for the .cc files'
forbidden mle/correction/a.cc '#include <ceres/problem.h>' 'ceres is for the .cc files'
forbidden apps/a.cc '#include "ceres/ceres.h"' 'ceres is for the .cc files'

# Other ways to write the same.
forbidden mle/model/a.cc '#include <sim/plant.h>' 'mle/model may include only'
forbidden mle/model/a.cc '  #  include "sim/plant.h"  // why' 'mle/model may include only'
forbidden mle/model/a.cc '#include"sim/plant.h"' 'mle/model may include only'
forbidden mle/model/a.cc '/* here */ #include "sim/plant.h"' 'mle/model may include only'
forbidden mle/model/a.cpp '#include "sim/plant.h"' 'mle/model may include only'
forbidden mle/model/a.cc '#include "../../sim/plant.h"' 'the path from the root'
forbidden mle/model/a.cc '#include "b.h"' 'the path from the root'
forbidden mle/model/a.h '#include "mle/model/a.h"' 'headers have no cycles'
forbidden mle/model/a.cc '#include PLANT_HEADER' 'must name its file'
permitted mle/model/a.cc '// #include "sim/plant.h"'
permitted mle/model/a.cc '/* #include "sim/plant.h" */'
permitted mle/model/a.cc '#include <vector>'
permitted mle/model/a.cc '#include "Eigen/Core"'
if run mle/unheard_of/a.cc ''; then fail 'a new layer was accepted'; fi

# A check of nothing is no check.
mkdir -p -- "$scratch/empty"
if bash "$here/check_includes.sh" "$scratch/empty" >"$scratch/out" 2>&1; then
  fail 'an empty tree was accepted'
fi

if ((failures > 0)); then
  echo "$failures cases failed"
  exit 1
fi
echo 'all cases passed'
