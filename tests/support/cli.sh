# Support for tests/cli/*.sh, which run the program with real files. To be sourced; gives
#   $HEBRA            the program
#   $work             an empty directory of this test
#   run COMMAND...    runs a command; leaves $status, $out (standard output) and $err (standard error)
#   wants STATUS [WORDS...]  the last command ended so, and each of the WORDS stands in its output
#   check "WHAT" COMMAND...  a condition that has to hold
#   finish            ends the test
# A failure is printed and counted; the test goes on, and ends with status 1.
set -uo pipefail
: "${HEBRA:?the program to test}" "${HEBRA_SCRATCH:?a directory to work in}"
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
work=$HEBRA_SCRATCH
rm -rf "$work" && mkdir -p "$work"
failures=0 checks=0 command=() status=0 out= err=

# Prints and counts a failure.
fail() {
  failures=$((failures + 1))
  printf 'FAILED: %s\n' "$1"
  printf '  command: %s\n  status: %s\n' "${command[*]}" "$status"
  printf '%s\n' "$out" | head -n 12 | sed 's/^/  out: /'
  printf '%s\n' "$err" | head -n 12 | sed 's/^/  err: /'
}
# Runs a command and keeps all it says.
run() {
  command=("$@")
  "$@" >"$work/.out" 2>"$work/.err" </dev/null
  status=$?
  out=$(<"$work/.out") err=$(<"$work/.err")
}
# Judges the last command.
wants() {
  local expected=$1 words
  shift
  checks=$((checks + 1))
  if [ "$status" != "$expected" ]; then
    fail "status $expected expected"
    return 1
  fi
  for words in "$@"; do
    if [[ $out != *"$words"* && $err != *"$words"* ]]; then
      fail "'$words' expected"
      return 1
    fi
  done
}
# Judges a condition.
check() {
  local what=$1
  shift
  checks=$((checks + 1))
  "$@" >/dev/null 2>&1 || fail "$what"
}
# True if a file begins with these bytes (as printf writes them).
begins_with() { cmp -s <(head -c "$(printf "$2" | wc -c)" "$1") <(printf "$2"); }
# True if two files have the same bytes.
same() { cmp -s "$1" "$2"; }
# The verdict.
finish() {
  echo "$checks checks, $failures failures"
  [ "$checks" -gt 0 ] && [ "$failures" = 0 ]
  exit
}
