#!/bin/bash
# hebra trace and the diagrams of hebra plot: files that the other verbs read, the same bytes again, refusals.
source "$(dirname "$0")/../support/cli.sh"
scene=scenes/trace/euler.yaml
# figure FILE EXPRESSION: does a Python expression on the report d hold?
figure() { python3 -c 'import json, math, sys
d = json.load(open(sys.argv[1]))
sys.exit(0 if eval(sys.argv[2]) else 1)' "$1" "$2"; }
small=(--set parameters.n=21 --set trace.step=0.1)

run "$HEBRA" trace "$scene" -o "$work/e" "${small[@]}"; wants 0 'bifurcation at P = 9.84' 'branches.csv'
check "nothing on standard output" test -z "$out"
check "the load of the chain of hinges" figure "$work/e/branches.json" \
  'abs(d["events"][0]["parameter"]/(1600*math.sin(math.pi/40)**2) - 1) < 1e-9'
check "three branches, none failed" figure "$work/e/branches.json" \
  'len(d["branches"]) == 3 and not any(b["failed"] for b in d["branches"]) and d["branches"][2]["side"] == -1'
check "a line per point" test "$(wc -l <"$work/e/branches.csv")" = \
  "$(($(python3 -c 'import json, sys; print(json.load(open(sys.argv[1]))["points"])' "$work/e/branches.json") + 1))"
run "$HEBRA" info "$work/e/branch-1.h5"; wants 0 "Euler's elastica"
run "$HEBRA" render "$work/e/branch-1.h5" -o "$work/e/loop.png" --size 200x150; wants 0 't = 60'
check "a picture" begins_with "$work/e/loop.png" '\x89PNG'
run "$HEBRA" export "$work/e/branch-1.h5" --format csv -o "$work/e/tables"; wants 0
if command -v ffmpeg >/dev/null; then # through the folds of a branch, one frame after the other
  run "$HEBRA" trace scenes/trace/twisted-rod.yaml -o "$work/l" -q --set parameters.n=31 --set trace.step=0.1; wants 0
  check "quiet is quiet" test -z "$err"
  run "$HEBRA" render "$work/l/branch-1.h5" -o "$work/l/film.mp4" --size 160x120 --fps 5 -q; wants 0
  check "a film" test -s "$work/l/film.mp4"
fi

# the same bytes again, and on standard output
run "$HEBRA" trace "$scene" -o "$work/again" -q --json "${small[@]}"; wants 0
check "the report on standard output" test "$out" = "$(<"$work/again/branches.json")"
check "the same table" same "$work/e/branches.csv" "$work/again/branches.csv"

# diagrams
if command -v gnuplot >/dev/null; then
  run "$HEBRA" plot "$work/e/branches.csv" --y end_x -o "$work/d.png"; wants 0 '6 shapes'
  check "a picture" begins_with "$work/d.png" '\x89PNG'
  run "$HEBRA" plot "$work/e/branches.csv" --x energy --shapes 0 -o "$work/d.svg" --size 400x300; wants 0 '0 shapes'
fi
run "$HEBRA" plot "$work/e/branches.csv" --y wallpaper; wants 2 'no column "wallpaper"' 'amplitude'
run "$HEBRA" plot "$work/e/branches.csv" --shapes 13; wants 2 '--shapes "13"'
run "$HEBRA" plot "$work/e/branches.csv" -o "$work/d.txt"; wants 2 '.png or .svg'
run "$HEBRA" plot "$work/none.csv"; wants 2 'none.csv'
printf 'branch,index,kind,unstable,parameter,amplitude\n0,0,start,0,1,x\n' >"$work/bad.csv"
run "$HEBRA" plot "$work/bad.csv" --shapes 0; wants 2 'bad.csv:2' 'a number is expected'
printf 'branch,index,kind,unstable,parameter,amplitude\n0,0,start,0,1,2\n' >"$work/lone.csv"
run "$HEBRA" plot "$work/lone.csv"; wants 2 'branch-0.h5'

# refusals leave nothing behind
run "$HEBRA" trace scenes/statics/cantilever.yaml -o "$work/r"; wants 2 'the section trace is missing'
run "$HEBRA" trace "$scene" -o "$work/r" --set trace.parameter=n --set trace.from=21 --set trace.to=31
wants 2 'a whole number from 3'
run "$HEBRA" trace "$scene" -o "$work/r" --set parameters.q=0.4 --set 'rods[0].rest.line.vertices=floor(20 + q)' \
  --set trace.parameter=q --set trace.from=0.4 --set trace.to=3
wants 2 'the parameter changes the number of vertices'
run "$HEBRA" trace scenes/statics/strut.yaml -o "$work/r" --set 'trace={parameter: P, from: 2, to: 3}' --set 'rods[0].start.tangent=free'
wants 2 'may turn'
run "$HEBRA" trace scenes/rings/michell.yaml -o "$work/r" --set 'trace={parameter: t, from: 0, to: 1}'
wants 2 'michell.yaml:' 'is closed'
run "$HEBRA" trace scenes/reed-in-wind.yaml -o "$work/r" --set 'trace={parameter: t, from: 0, to: 1}'; wants 2
check "nothing is written then" test ! -e "$work/r/branches.csv"
run "$HEBRA" trace "$scene" --time -1; wants 2 '--time "-1"'
run "$HEBRA" trace "$scene" "$scene"; wants 2 'only one scene'
run "$HEBRA" trace; wants 2 'scene file is missing'

# a branch that cannot go on: everything before is kept, status 1
run "$HEBRA" trace scenes/trace/spring.yaml -o "$work/s" --set parameters.n=61 --set trace.step=0.1 --set trace.to=0.4 \
  --set 'rods[0].end.material_turn=2*pi*floor((omega*stretch - tau)*wire/(2*pi) + 0.5)'
wants 1 'branch 0 ended early' 'beyond the parameter'
check "what there was is kept" test -s "$work/s/branches.csv" -a -s "$work/s/branch-0.h5"
check "and told" figure "$work/s/branches.json" 'd["branches"][0]["failed"]'
finish
