#!/bin/bash
# hebra modes: figures, tables, films that other verbs read, pictures, matrices, refusals.
source "$(dirname "$0")/../support/cli.sh"
scene=scenes/modes/cantilever.yaml
# figure FILE EXPRESSION: does a Python expression on the report d hold?
figure() { python3 -c 'import json, sys
d = json.load(open(sys.argv[1]))
sys.exit(0 if eval(sys.argv[2]) else 1)' "$1" "$2"; }

run "$HEBRA" modes "$scene" -n 4 -o "$work/c" --matrices --films --pictures
wants 0 'the 4 lowest of 78 modes, none missed' 'vibration' '8.89399251'
check "frequencies of the discrete beam" figure "$work/c/modes.json" \
  'abs(d["modes"][0]["omega"]/8.893992514855368 - 1) < 1e-9 and abs(d["modes"][3]["omega"]/55.74334434249 - 1) < 2e-3'
check "period and frequency agree" figure "$work/c/modes.json" \
  'abs(d["modes"][2]["period"]*d["modes"][2]["frequency"] - 1) < 1e-14'
check "a row for every mode" test "$(wc -l <"$work/c/modes.csv")" = 5
check "a row for every mode and vertex" test "$(wc -l <"$work/c/shapes.csv")" = $((4 * 41 + 1))
check "a picture" begins_with "$work/c/modes.png" '\x89PNG'
check "sizes of the matrices" test "$(sed -n 3p "$work/c/K.mtx" | cut -d' ' -f1,2)/$(sed -n 3p "$work/c/G.mtx" | cut -d' ' -f1,2)" = '117 117/39 117'
check "they say what they are" begins_with "$work/c/K.mtx" '%%%%MatrixMarket matrix coordinate real symmetric'
check "and what their rows are" test "$(sed -n 118p "$work/c/unknowns.csv")" = '117,beam,40,z'
# the energy and the mass of a shape, by the files alone
check "energy over mass is omega squared" python3 - "$work/c" <<'PY'
import csv, json, sys
where = sys.argv[1]
def matrix(name):
    rows = [line.split() for line in open(f'{where}/{name}.mtx') if not line.startswith('%')][1:]
    return [(int(i) - 1, int(j) - 1, float(v)) for i, j, v in rows]
def form(entries, a):
    return sum(v*a[i]*a[j]*(1 if i == j else 2) for i, j, v in entries)
unknowns = list(csv.DictReader(open(f'{where}/unknowns.csv')))
shapes = [r for r in csv.DictReader(open(f'{where}/shapes.csv')) if r['mode'] == '3']
keys = {'x': 'shape_x [mass^-1/2]', 'y': 'shape_y [mass^-1/2]', 'z': 'shape_z [mass^-1/2]', 'turn': 'turn [mass^-1/2 length^-1]'}
a = [float(shapes[int(u['vertex_or_edge'])][keys[u['component']]]) for u in unknowns]
square = json.load(open(f'{where}/modes.json'))['modes'][2]['omega_squared']
assert abs(form(matrix('M'), a) - 1) < 1e-9
assert abs(form(matrix('K'), a)/square - 1) < 1e-6
rows = {}
for i, j, v in matrix('G'): rows[i] = rows.get(i, 0) + v*a[j]
assert max(map(abs, rows.values())) < 1e-6*max(map(abs, a))
PY
run "$HEBRA" info "$work/c/mode-3.h5"; wants 0 'frames     49'
run "$HEBRA" render "$work/c/mode-3.h5" -o "$work/c/mode.png" --frame 12 --size 200x150; wants 0
run "$HEBRA" render "$work/c/equilibrium.h5" -o "$work/c/rest.png" --size 200x150; wants 0
run "$HEBRA" modes "$scene" -n 2 -o "$work/j" --json --quiet; wants 0
check "the report on standard output" test "$out" = "$(<"$work/j/modes.json")"
check "quiet is quiet" test -z "$err"

# pushed beyond its critical load, with and without --any
push=(scenes/modes/string.yaml --set parameters.tension=-0.3)
run "$HEBRA" modes "${push[@]}" --any -n 3 -o "$work/p"; wants 0 'grows like exp' '2 modes leave the equilibrium'
check "and the report says so" figure "$work/p/modes.json" \
  'd["unstable"] == 2 and d["modes"][0]["kind"] == "unstable" and d["modes"][2]["kind"] == "vibration"'
# it bends away, and turns about its axis for nothing
run "$HEBRA" modes "${push[@]}" -n 3 -o "$work/b"; wants 0 'unstable equilibrium left' 'rigid'
check "one rigid mode" figure "$work/b/modes.json" 'd["unstable"] == 0 and d["rigid"] == 1'

# refusals
run "$HEBRA" modes "$scene" -n 0; wants 2 '--count "0" is not a whole number from 1 to 100000'
run "$HEBRA" modes "$scene" --amplitude 2; wants 2 '--amplitude "2"'
run "$HEBRA" modes "$scene" --pictures --amplitude 1 -n 6 -o "$work/r"; wants 2 'a smaller amplitude is needed'
check "nothing is written then" test ! -e "$work/r"
run "$HEBRA" modes "$scene" --time -1; wants 2 '--time "-1"'
run "$HEBRA" modes scenes/reed-in-wind.yaml -o "$work/r"; wants 2 'wind has no potential'
run "$HEBRA" modes scenes/rope-thrown.yaml -o "$work/r"; wants 2 'no support holds a vertex'
finish
