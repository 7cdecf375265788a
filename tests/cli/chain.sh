#!/bin/bash
# The verbs one after the other with real files: check, run, info, export, render, plot.
source "$(dirname "$0")/../support/cli.sh"
scene=tests/support/small.yaml
dir=$work/run
before=$(find . -maxdepth 1 | sort)
# json FILE EXPRESSION: true if the Python expression of d, the parsed file, is.
json() { python3 -c 'import json, math, sys
with open(sys.argv[1]) as f: d = json.load(f)
sys.exit(0 if eval(sys.argv[2]) else 1)' "$1" "$2"; }
# png FILE WIDTH_AT_LEAST: a PNG file at least so wide, with more than one colour in it (it does not compress to nothing).
png() { python3 -c 'import struct, sys, zlib
b = open(sys.argv[1], "rb").read()
assert b[:8] == b"\x89PNG\r\n\x1a\n" and b[-8:-4] == b"IEND"
w, h = struct.unpack(">II", b[16:24])
at, data = 8, b""
while at < len(b):
    n, kind = struct.unpack(">I4s", b[at:at + 8])
    if kind == b"IDAT": data += b[at + 8:at + 8 + n]
    at += n + 12
raw = zlib.decompress(data)
assert w >= int(sys.argv[2]) and h >= 100 and len(set(raw)) > 16, (w, h, len(set(raw)))' "$1" "$2"; }

# ---- check ----
run "$HEBRA" check $scene; wants 0 wound ribbon
run "$HEBRA" check $scene --json; wants 0
printf '%s' "$out" >"$work/check.json"
check "check --json is JSON" json "$work/check.json" 'len(d) > 3'
check "check writes nothing" test "$before" = "$(find . -maxdepth 1 | sort)"

# ---- run ----
run "$HEBRA" run $scene -o "$dir"; wants 0 trajectory.h5
check "nothing on standard output without --json" test -z "$out"
check "plain lines where there is no terminal" test "$(tr -d '\r\033' <"$work/.err" | wc -c)" = "$(wc -c <"$work/.err")"
for file in trajectory.h5 checkpoint.hbc report.json; do check "$file is written" test -s "$dir/$file"; done
check "no other file is left" test "$(ls "$dir" | wc -l)" = 3
check "report.json is JSON" json "$dir/report.json" 'len(d) > 5'
run "$HEBRA" run $scene -o "$work/second" --quiet --json; wants 0
check "--quiet says nothing" test -z "$err"
printf '%s' "$out" >"$work/report.json"
check "--json prints the report" json "$work/report.json" 'len(d) > 5'
check "two runs have the same bits" same "$dir/checkpoint.hbc" "$work/second/checkpoint.hbc"

# ---- info ----
run "$HEBRA" info "$dir/trajectory.h5"; wants 0 'Two short rods' wound ribbon
run "$HEBRA" info "$dir/trajectory.h5" --json; wants 0
printf '%s' "$out" >"$work/info.json"
check "info --json: 41 frames, 20 vertices, two rods" json "$work/info.json" \
  'd["frames"] == 41 and d["vertices"] == 20 and [r["name"] for r in d["rods"]] == ["wound", "ribbon"]'
check "info --json: the run's time and steps" json "$work/info.json" \
  'math.isclose(d["last_frame"]["time"], 0.2, rel_tol=1e-12) and d["last_frame"]["step"] == 200'
check "info --json: lengths are held" json "$work/info.json" 'd["last_frame"]["worst_length_error"] <= 1e-10'

# ---- export ----
run "$HEBRA" export "$dir/trajectory.h5" --format csv,vtp -o "$work/export"; wants 0
check "a row per frame and a header" test "$(wc -l <"$work/export/scalars.csv")" = 42
check "a table per rod" test "$(ls "$work/export"/*.csv | wc -l)" = 3
check "a file per frame for ParaView" test "$(find "$work/export" -name '*.vtp' | wc -l)" = 41
check "the list of times names every file" python3 -c '
import os, sys, xml.etree.ElementTree as tree
top = sys.argv[1]
sets = tree.parse(top + "/trajectory.pvd").getroot().findall(".//DataSet")
assert len(sets) == 41 and abs(float(sets[-1].get("timestep")) - 0.2) < 1e-12
for s in sets:
    text = open(os.path.join(top, s.get("file")), "rb").read()
    assert b"<VTKFile type=\"PolyData\"" in text[:200] and b"</VTKFile>" in text[-20:]' "$work/export"
run "$HEBRA" export "$dir/trajectory.h5" --format csv --frames 0:-1:10 -o "$work/some"; wants 0
check "every tenth frame" test "$(wc -l <"$work/some/scalars.csv")" = 6
run "$HEBRA" export "$dir/trajectory.h5" --format stl -o "$work/x"; wants 2 stl csv
run "$HEBRA" export "$dir/trajectory.h5" --format csv --frames 50 -o "$work/x"; wants 2
check "no files after a wrong argument" test ! -e "$work/x"

# ---- render and plot ----
run "$HEBRA" render "$dir/trajectory.h5" -o "$work/picture.png"; wants 0
check "a picture" png "$work/picture.png" 300
run "$HEBRA" plot "$dir/trajectory.h5" -o "$work/plot.png"; wants 0
check "a plot" png "$work/plot.png" 300
run "$HEBRA" render "$dir/trajectory.h5" --view camera --from 1,1,1 --size 400x300 --frame 0 -o "$work/view.png"; wants 0
check "one view" png "$work/view.png" 400
run "$HEBRA" plot "$dir/trajectory.h5" --what energies,length -o "$work/plot.svg"; wants 0
check "a plot in SVG" grep -q '<svg' "$work/plot.svg"
run "$HEBRA" render "$dir/trajectory.h5" --size 320x240 --fps 10 --speed 0.1 -o "$work/film.mp4"; wants 0
check "a film" test "$(stat -c %s "$work/film.mp4")" -gt 1000
check "a film is an MP4 file" bash -c 'head -c 12 "$1" | tail -c 8 | grep -q ftyp' - "$work/film.mp4"

# Programs that are not there: a sentence with the name of the package, status 1, no file.
mkdir "$work/empty"
run env PATH="$work/empty" "$HEBRA" render "$dir/trajectory.h5" -o "$work/none.mp4"; wants 1 ffmpeg
check "no film without ffmpeg" test ! -e "$work/none.mp4"
run env PATH="$work/empty" "$HEBRA" plot "$dir/trajectory.h5" -o "$work/none.png"; wants 1 gnuplot-nox
check "no plot without gnuplot" test ! -e "$work/none.png"

# Files that are no trajectories, and places that cannot be written.
printf 'no trajectory' >"$work/text.h5"
run "$HEBRA" render "$dir/trajectory.h5" --frame 41 -o "$work/y.png"; wants 2 41
run "$HEBRA" render "$dir/trajectory.h5" -o "$work/y.xyz"; wants 2 xyz
run "$HEBRA" plot "$dir/trajectory.h5" --what energy -o "$work/y.png"; wants 2 energies
for verb in info export render plot; do
  arguments=()
  [ $verb = info ] || arguments=(-o "$work/y.png")
  [ $verb != export ] || arguments+=(--format csv)
  run "$HEBRA" $verb "$work/text.h5" "${arguments[@]}"; wants 2 text.h5
  run "$HEBRA" $verb "$dir/report.json" "${arguments[@]}"; wants 2 report.json
done
check "no picture after a mistake" test ! -e "$work/y.png" -a ! -e "$work/y.xyz"
run "$HEBRA" render "$dir/trajectory.h5" -o "$work/no/such/place.png"; wants 1 no/such/place.png
run "$HEBRA" run $scene -o /proc/no-such-place; wants 1 /proc/no-such-place
finish
