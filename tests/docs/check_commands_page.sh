#!/usr/bin/env bash
# check_commands_page.sh SOURCE COMMAND…: docs/commands.md is what the commands
# say of themselves.
set -euo pipefail

source=$1
shift
if ! "$source/scripts/commands_page" "$@" | diff -u "$source/docs/commands.md" -; then
  echo "docs/commands.md is stale: scripts/commands_page build/test/apps/mle_* >docs/commands.md"
  exit 1
fi
