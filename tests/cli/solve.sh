#!/bin/bash
# hebra solve: results that the other verbs read, figures, starts, refusals.
source "$(dirname "$0")/../support/cli.sh"
scene=scenes/statics/cantilever.yaml
# figure FILE EXPRESSION: does a Python expression on the report d hold?
figure() { python3 -c 'import json, sys
d = json.load(open(sys.argv[1]))
sys.exit(0 if eval(sys.argv[2]) else 1)' "$1" "$2"; }

run "$HEBRA" solve "$scene" -o "$work/c"; wants 0 'stable equilibrium' 'trajectory.h5' 'report.json'
check "nothing on standard output" test -z "$out"
check "deflection of the elastica" figure "$work/c/report.json" 'abs(-d["rods"][0]["last_vertex"][2]/0.8106090248803 - 1) < 2e-4'
check "stable, few iterations" figure "$work/c/report.json" \
  'd["equilibrium"]["stable"] and d["equilibrium"]["unstable_modes"] == 0 and d["equilibrium"]["iterations"] < 12'
check "the supports carry the load" figure "$work/c/report.json" \
  'abs(sum(r["force"][2] for r in d["rods"][0]["reactions"]) - 10) < 1e-6'
run "$HEBRA" info "$work/c/trajectory.h5"; wants 0 'Cantilever under a tip load'
run "$HEBRA" render "$work/c/trajectory.h5" -o "$work/c/picture.png" --size 200x150; wants 0
check "a picture" test -s "$work/c/picture.png"
run "$HEBRA" export "$work/c/trajectory.h5" --format csv -o "$work/c/tables"; wants 0
run "$HEBRA" solve "$scene" -o "$work/j" --json --quiet --set parameters.P=1; wants 0
check "the report on standard output" test "$out" = "$(<"$work/j/report.json")"
check "quiet is quiet" test -z "$err"

# beside, not in, the results of a run of the same scene
(cd "$work" && "$HEBRA" solve "$HEBRA_SOURCE/$scene" --quiet)
check "a directory of its own" test -s "$work/out/cantilever-equilibrium/report.json" -a ! -e "$work/out/cantilever"

# an unstable equilibrium is left, or kept with --any
run "$HEBRA" solve scenes/statics/strut.yaml -o "$work/s"; wants 0 'stable equilibrium' '1 unstable equilibrium left'
run "$HEBRA" solve scenes/statics/strut.yaml -o "$work/u" --any; wants 0 'unstable equilibrium, 2 unstable modes'
check "and says so in the report" figure "$work/u/report.json" 'd["equilibrium"]["unstable_modes"] == 2'

# from a frame; times and load steps
run "$HEBRA" solve "$scene" -o "$work/f" --from "$work/c/trajectory.h5"; wants 0 ': 0 iterations'
run "$HEBRA" solve "$scene" -o "$work/f" --from "$work/c/trajectory.h5:-1"; wants 0 ': 0 iterations'
run "$HEBRA" solve "$scene" -o "$work/f" --from "$work/c/trajectory.h5:1"; wants 2 'there is no such frame'
run "$HEBRA" solve scenes/statics/strut.yaml -o "$work/f" --from "$work/none.h5"; wants 2 'none.h5'
run "$HEBRA" solve scenes/statics/strut.yaml -o "$work/f" --from "$work/c/trajectory.h5"; wants 2 'of another scene'
run "$HEBRA" solve scenes/telephone-cord.yaml -o "$work/t" --time 1 --load-steps 4; wants 0 'at t = 1'
check "time in the report" figure "$work/t/report.json" 'd["time"] == 1'
run "$HEBRA" render "$work/t/trajectory.h5" -o "$work/t/picture.png" --size 200x150; wants 0

# refusals
run "$HEBRA" solve scenes/reed-in-wind.yaml -o "$work/r"; wants 2 'reed-in-wind.yaml:' 'wind has no potential'
run "$HEBRA" solve scenes/rope-thrown.yaml -o "$work/r"; wants 2 'no support holds a vertex'
run "$HEBRA" solve "$scene" -o "$work/r" --max-iterations 2; wants 1 'no equilibrium in 2 iterations'
check "nothing is written then" test ! -e "$work/r"
run "$HEBRA" solve "$scene" --time -1; wants 2 '--time "-1"'
run "$HEBRA" solve "$scene" --load-steps 0; wants 2 '--load-steps "0"'
run "$HEBRA" solve "$scene" --tolerance x; wants 2 '--tolerance "x"'
run "$HEBRA" solve "$scene" "$scene"; wants 2 'only one scene'
finish
