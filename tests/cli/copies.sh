#!/bin/bash
# Many rods from one entry, through the whole chain: what check says of many rods in short, names in the output, a
# restart, pictures whose colours vary, exports.
source "$(dirname "$0")/../support/cli.sh"
scene=scenes/hair.yaml
few=(--set parameters.count=30 --set method.duration=0.01 --set output.every=50)

run "$HEBRA" check $scene; wants 0 'rods       10000 in all, up to hair-9999: 640000 vertices' '0 isotropic and straight at rest, 10000 general' \
  'support  30000 prescribed' 'rod hair-0 to hair-9999'
check "check tells of many rods in short" test "$(wc -l <<<"$out")" -lt 40
run "$HEBRA" check $scene "${few[@]}" --json; wants 0
check "JSON lists every rod" python3 -c 'import json, sys; d = json.loads(sys.argv[1]); assert [r["name"] for r in d["rods"]] == ["hair-%d" % k for k in range(30)]' "$out"
run "$HEBRA" check $scene --set rods.hair.copies=3; wants 0 'rod        hair-2: 64 vertices'
run "$HEBRA" check $scene --set rods.hair.copies=0; wants 2 '"0" is not allowed; a whole number from 1 to 3333333 is expected'

run "$HEBRA" run $scene -o "$work/out" --quiet "${few[@]}"; wants 0
run "$HEBRA" info "$work/out/trajectory.h5"; wants 0 'rods       30 with 1920 vertices in all' 'hair-19' 'and 10 more'
cp -r "$work/out" "$work/longer"
run "$HEBRA" run --restart "$work/longer/checkpoint.hbc" --set method.duration=0.02 --quiet; wants 0
run "$HEBRA" run $scene -o "$work/whole" --quiet "${few[@]}" --set method.duration=0.02; wants 0
"$HEBRA" export "$work/longer/trajectory.h5" --format csv --frames -1 -o "$work/a"
"$HEBRA" export "$work/whole/trajectory.h5" --format csv --frames -1 -o "$work/b"
check "a restart gives the same bits" diff -r "$work/a" "$work/b"
run "$HEBRA" export "$work/out/trajectory.h5" --format csv -o "$work/csv"; wants 0
check "one table per rod" test -s "$work/csv/hair-29.csv" -o -n "$(ls "$work/csv" | grep hair-29)"

for color in 0.5,0.3,0.2 0,0,0 1,1,1; do
  run "$HEBRA" render "$work/out/trajectory.h5" --view camera --size 200x150 --color $color -o "$work/$color.png"; wants 0
done
check "--color changes the picture" bash -c '! cmp -s "$1" "$2"' - "$work/0,0,0.png" "$work/1,1,1.png"
for color in 1,2,0 0.5,0.5 red -0.1,0,0 nan,0,0; do
  run "$HEBRA" render "$work/out/trajectory.h5" --color=$color -o "$work/no.png"
  wants 2 "--color needs R,G,B, each from 0 to 1, found '$color'"
done
check "no picture after a wrong colour" test ! -e "$work/no.png"
finish
