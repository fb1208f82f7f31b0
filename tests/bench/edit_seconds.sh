#!/usr/bin/env bash
# Measures how long a step takes after an edit of one line: it edits a file, runs the step, prints the seconds, and takes the edit back.
# The first, unmeasured run of each step builds what is missing. Run it on a quiet machine. Usage: tests/bench/edit_seconds.sh [--help]
set -euo pipefail
cd "$(dirname "$0")/../.."
. tests/steps.sh
help_if_asked "$@"
[ -z "$(git status --porcelain)" ] || fail "the work tree has changes, and this script edits files: commit or stash them first"
trap 'git checkout --quiet -- twin web' EXIT

edits=0
# edit FILE: adds one item that the compiler has not seen yet.
edit() {
  edits=$((edits + 1))
  case $1 in
  *.ts) printf 'export const edited%s = %s;\n' "$$_$edits" "$edits" >>"$1" ;;
  *) sed -i "0,/^use /s//#[doc(hidden)]\npub const EDITED_$$_$edits: u32 = $edits;\nuse /" "$1" ;;
  esac
}

# seconds NAME FILE STEP…: edits FILE, runs STEP and prints how long it took.
seconds() {
  local name=$1 file=$2 from
  shift 2
  edit "$file"
  from=$(date +%s%N)
  "$@" >target/edit_seconds.log 2>&1 || fail "$* fails: see target/edit_seconds.log"
  printf '%-10s %-24s %6.1f s\n' "$name" "$*" "$((($(date +%s%N) - from) / 100000000))e-1"
}

mkdir -p target
for warm in "cargo build --release" tests/check tests/fast; do
  $warm >target/edit_seconds.log 2>&1 || fail "$warm fails: see target/edit_seconds.log"
done
for step in "cargo build --release" tests/check tests/fast; do
  seconds control twin/core/src/control/compensation.rs $step
done
seconds residual twin/core/src/residual/lra.rs cargo build --release
seconds server twin/console/src/server/rate.rs cargo build --release
for step in "cargo build --release" tests/check; do
  seconds web web/src/panels/ranges.ts $step
done
