# Enforces who may include whom. Usage:
#
#   awk -f check_includes.awk FILE…
#
# with paths from the root of the project. Prints FILE:LINE and the rule broken
# for every forbidden include, cycles of headers, and if mle/mle.h includes too
# much; exits with 1 if there is one.
#
# The table is that of docs/architecture.md.

BEGIN {
  base = "mle/base"
  model = base " mle/model"
  data = model " mle/data"
  database = data " mle/database"
  regression = data " mle/regression"
  nonlinear = regression " mle/nonlinear"
  exchange = nonlinear " mle/exchange"
  correction = exchange " mle/correction"
  explain = nonlinear " mle/explain"
  filter = nonlinear " mle/filter"
  plan = filter " mle/plan"
  all_of_mle = correction " mle/database mle/explain mle/filter mle/plan mle/maintain"

  allowed["mle/base"] = base
  allowed["mle/model"] = model
  allowed["mle/data"] = data
  allowed["mle/database"] = database
  allowed["mle/regression"] = regression
  allowed["mle/nonlinear"] = nonlinear
  allowed["mle/exchange"] = exchange
  allowed["mle/correction"] = correction
  allowed["mle/explain"] = explain
  allowed["mle/filter"] = filter
  allowed["mle/plan"] = plan
  allowed["mle/maintain"] = all_of_mle
  all_of_mle = all_of_mle " mle/monitor"
  allowed["mle/monitor"] = all_of_mle
  allowed["mle/trial"] = all_of_mle " mle/trial"
  all_of_mle = all_of_mle " mle/trial"
  # The front door.
  allowed["mle/mle.h"] = all_of_mle
  all_of_mle = all_of_mle " mle/mle.h"
  allowed["sim"] = data " sim"
  allowed["control"] = data " control"
  allowed["benchmarks"] = all_of_mle " sim control benchmarks"
  allowed["examples"] = all_of_mle " sim control"
  allowed["apps"] = all_of_mle " sim control apps"
  allowed["python"] = allowed["apps"] " python"
  allowed["tests"] = allowed["apps"] " tests"
}

# "mle/data" for mle/data/record.h, "apps" for apps/report/page.h.
function layer_of(path,    part) {
  split(path, part, "/")
  return part[1] == "mle" ? part[1] "/" part[2] : part[1]
}

function is_in(word, list) {
  return index(" " list " ", " " word " ") > 0
}

# "mle/base, sim" for the list "mle/base sim".
function spelled(list) {
  gsub(/ /, ", ", list)
  return list
}

function report(rule) {
  printf "%s:%d: %s: %s\n", FILENAME, FNR, directive, rule
  ++errors
}

function check_project_include(target,    from, to) {
  from = layer_of(FILENAME)
  to = layer_of(target)
  if (!is_in(to, allowed[from]))
    report(from " may include only " spelled(allowed[from]))
}

function check_gflags() {
  if (FILENAME !~ /^(apps|tests\/apps)\//)
    report("gflags is for apps/ alone")
}

function check_ceres() {
  if (FILENAME ~ /^(tests|benchmarks)\//) return
  if (FILENAME !~ /^mle\/nonlinear\/.*\.cc$/)
    report("ceres is for the .cc files of mle/nonlinear alone")
}

function check_soci() {
  if (FILENAME !~ /^mle\/database\/.*\.cc$/)
    report("soci is for the .cc files of mle/database alone")
}

function check(target, quoted) {
  if (target ~ /(^|\/)\.\.?\//) {
    report("include by the path from the root of the project")
  } else if (layer_of(target) in allowed) {
    check_project_include(target)
    included[FILENAME] = included[FILENAME] " " target
    line_of[FILENAME, target] = FNR
  } else if (target ~ /^gflags\//) {
    check_gflags()
  } else if (target ~ /^ceres\//) {
    check_ceres()
  } else if (target ~ /^soci\//) {
    check_soci()
  } else if (quoted && target !~ /\//) {
    report("include by the path from the root of the project")
  }
}

# How many headers stand behind `file`, `path` (with blanks around) leading to
# it. A header on that path that is included again closes a cycle.
function walk(file, path,    target, targets, i, n, count) {
  if (file in walked) return 0
  walked[file] = 1
  n = split(included[file], targets, " ")
  for (i = 1; i <= n; ++i) {
    target = targets[i]
    if (is_in(target, path file)) {
      printf "%s:%d: %s: headers have no cycles\n", file, line_of[file, target],
             target
      ++errors
    }
    if (!(target in walked)) count += 1 + walk(target, path file " ")
  }
  return count
}

FNR == 1 {
  in_comment = 0
  if (!(layer_of(FILENAME) in allowed)) {
    directive = "new layer " layer_of(FILENAME)
    report("the table of layers does not know it")
    allowed[layer_of(FILENAME)] = ""
  }
}

# Block comments that open or close a line.
in_comment {
  if (!sub(/^.*\*\//, "")) next
  in_comment = 0
}
{
  while (sub(/^[ \t]*\/\*([^*]|\*+[^*\/])*\*+\//, "")) {}
}
/^[ \t]*\/\*/ { in_comment = 1; next }

/^[ \t]*#[ \t]*(include|include_next|import)([^A-Za-z0-9_]|$)/ {
  directive = $0
  sub(/^[ \t]*/, "", directive)
  sub(/[ \t\r]*$/, "", directive)
  if (match($0, /"[^"]*"/)) {
    check(substr($0, RSTART + 1, RLENGTH - 2), 1)
  } else if (match($0, /<[^>]*>/)) {
    check(substr($0, RSTART + 1, RLENGTH - 2), 0)
  } else {
    report("an include must name its file, to be checked")
  }
}

END {
  behind = walk("mle/mle.h", "")
  if (behind > 30) {
    printf "mle/mle.h: %d headers stand behind it, at most 30 are to\n", behind
    ++errors
  }
  for (file in included) walk(file, "")
  exit errors > 0
}
