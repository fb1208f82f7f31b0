# The steps that tests/check, tests/fast and tests/run are made of. They are sourced, not run; each works from the repository's root.
# Every step uses the release profile and all crates, so that nothing is built twice.
# A script that also tests the training sets features=(--features train): with burn, packages below every crate have more features, so
# cargo builds them all again wherever the feature is switched on or off.
features=()
started=$(date +%s)

step() { printf '\n== %s (%s s) ==\n' "$1" "$(($(date +%s) - started))"; }

# Prints the comment at the head of the script that runs, which is its help, and ends it if the user asks for that.
help_if_asked() {
  case "${1:-}" in
  "") ;;
  -h | --help)
    sed -n '2,/^[^#]/s/^# \{0,1\}//p' "$0"
    exit 0
    ;;
  *) fail "unknown argument $1; the script takes none but --help" ;;
  esac
}

fail() {
  printf '%s: %s\n' "tests/$(basename "$0")" "$1" >&2
  exit 1
}

# need COMMAND REMEDY: ends the script if the command is missing.
need() { command -v "$1" >/dev/null || fail "$1 is missing: $2"; }

check_format() {
  step "format"
  cargo fmt --all --check || fail "some files are not formatted: run cargo fmt --all"
}

check_clippy() {
  step "clippy"
  cargo clippy --release --workspace --all-targets "${features[@]}" --quiet -- -D warnings || fail "clippy warns: mend what it names above"
}

# The documentation and the program as a user builds them, without the training.
check_docs() {
  step "documentation"
  RUSTDOCFLAGS="-D warnings" cargo doc --release --workspace --no-deps --quiet || fail "rustdoc warns: mend what it names above"
  cargo check --release --quiet || fail "the program does not compile without the feature train: mend what cargo names above"
}

check_web_types() {
  step "web: types"
  (cd web && npm run --silent typecheck) || fail "the types of web/ do not hold: mend what tsc names above"
}

# test_units [FLAGS…]: the unit tests of every crate.
test_units() {
  step "unit tests${*:+ $*}"
  cargo test --release --workspace --lib --quiet "$@" || fail "a unit test fails: run cargo test --release --workspace --lib NAME to see it alone"
}

# A page can fly the loop, the plant, and the flying part of scenario.
check_wasm() {
  step "wasm32"
  if ! rustup target add wasm32-unknown-unknown >/dev/null 2>&1; then
    printf 'skipped: rustup cannot add the target wasm32-unknown-unknown\n'
    return
  fi
  cargo check --release --target wasm32-unknown-unknown -p twin-core -p twin-plant -p twin-scenario --quiet ||
    fail "a crate that a page needs does not compile for wasm32-unknown-unknown: keep files, C code and threads behind a feature"
}

build_binary() {
  step "binary"
  cargo build --release --quiet
}

# fly_as_tests SCENARIO… [--FLAGS…]: flies scenarios and judges them.
fly_as_tests() {
  step "scenarios as tests"
  target/release/twin test "$@" 2>target/flights.log ||
    fail "a flight fails: fly it alone with target/release/twin fly SCENARIO; the log of all is target/flights.log"
}
