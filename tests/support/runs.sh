# Support for the tests of runs that end early; sourced after cli.sh.

# Milliseconds since some moment.
now() { date +%s%3N; }
# Sleeps so many milliseconds.
pause() { sleep "$(printf '%d.%03d' $(($1 / 1000)) $(($1 % 1000)))"; }
# tables DIR: writes every frame of DIR/trajectory.h5 with all digits to DIR/tables.
tables() {
  rm -rf "$1/tables"
  run "$HEBRA" export "$1/trajectory.h5" --format csv -o "$1/tables"
  wants 0
}
# wait_for SECONDS COMMAND...: until the command succeeds; false if it does not in time.
wait_for() {
  local end=$(($(now) + 1000 * $1))
  shift
  until "$@"; do
    [ "$(now)" -lt $end ] || return 1
    pause 20
  done
}
