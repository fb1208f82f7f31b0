# The steps that tests/check, tests/fast and tests/run are made of. They are sourced, not run; each works from the repository's root.
# Every step uses the release profile and all crates, so that nothing is built twice.
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
  cargo clippy --release --workspace --all-targets --quiet -- -D warnings || fail "clippy warns: mend what it names above"
}

check_docs() {
  step "documentation"
  RUSTDOCFLAGS="-D warnings" cargo doc --release --workspace --no-deps --quiet || fail "rustdoc warns: mend what it names above"
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

# The examples in the documentation; twin-core is the only crate whose examples run.
test_examples() {
  step "examples in the documentation"
  cargo test --release --doc -p twin-core --quiet || fail "an example fails: run cargo test --release --doc -p twin-core NAME to see it alone"
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
