#!/usr/bin/env bash
# check_help.sh COMMAND…: the first screen of each command's --help fits into 40
# lines of 82 characters; its manual page is read without complaint, and its
# completion offers flags, values and files.
set -euo pipefail

faults=0
fault() {
  echo "$*"
  faults=$((faults + 1))
}

# What Tab offers behind the words given, the last of which is unfinished.
offered() {
  COMP_WORDS=("$@")
  COMP_CWORD=$(($# - 1))
  COMPREPLY=()
  "_${1##*/}"
  printf '%s\n' "${COMPREPLY[@]-}"
}

for command; do
  name=${command##*/}
  lines=$("$command" --help | wc -l)
  ((lines <= 40)) || fault "$name --help has $lines lines"
  long=$("$command" --help | LC_ALL=C.UTF-8 awk 'length($0) > 88' | head -1)
  [[ -z $long ]] || fault "$name --help has a long line: $long"
  manual=$("$command" --help=man)
  [[ $manual == *$'\n.SH OPTIONS\n'* ]] || fault "$name --help=man has no options"
  if command -v groff >/dev/null; then
    complaints=$(groff -man -Tutf8 -Kutf8 -ww 2>&1 >/dev/null <<<"$manual" | head -3)
    [[ -z $complaints ]] || fault "$name --help=man: $complaints"
  fi
  # shellcheck disable=SC1090
  . <("$command" --help=bash)
  # Not through a pipe: a reader that ends early would be a fault of the writer.
  [[ $'\n'$(offered "$name" --ou)$'\n' == *$'\n--out=\n'* ]] || fault "$name: --ou is not completed"
  [[ $(offered "$name" --help = a) == all ]] || fault "$name: --help=a is not completed"
done
exit $((faults > 0))
