#!/bin/bash
# --set overrides any key: numbers, formulas, rods by index, by name and all at once; mistakes get status 2.
source "$(dirname "$0")/../support/cli.sh"
scene=tests/support/small.yaml
# value KEY: a number of the last frame.
value() { "$HEBRA" info "$work/out/trajectory.h5" --json | python3 -c 'import json, sys; print(float(json.load(sys.stdin)["last_frame"][sys.argv[1]]))' "$1"; }
# set_and WHAT EXPECTED KEY SETTING...: runs with the settings; the last frame has this value.
set_and() {
  local what=$1 expected=$2 key=$3 settings=()
  shift 3
  for setting in "$@"; do settings+=(--set "$setting"); done
  run "$HEBRA" run $scene -o "$work/out" --quiet "${settings[@]}"; wants 0 || return
  check "$what" test "$(value "$key")" = "$expected.0"
}
set_and "a parameter" 40 step parameters.steps=40
set_and "a formula" 50 step 'method.duration=0.1/2'
set_and "two settings" 80 step method.time_step=5e-4 method.duration=0.04
set_and "the last of two counts" 30 step parameters.steps=10 parameters.steps=30
# No stiffness, no energy.
set_and "rods by index" 0 bending parameters.steps=10 'rods[0].bending=0' 'rods[1].bending=0'
set_and "rods by name" 0 bending parameters.steps=10 rods.wound.bending=0 rods.ribbon.bending=0
set_and "all rods" 0 bending parameters.steps=10 'rods.*.bending=0'

# A list that is not there yet.
sed '/^forces:/,/rod: ribbon/d' $scene >"$work/calm.yaml"
run "$HEBRA" check "$work/calm.yaml" --set 'forces[0]={point: [0, 0, 1], rod: ribbon, vertex: -1}'
wants 0 'force      force [0, 0, 1] on vertex -1 of rod ribbon'
# A byte order mark in front is no part of the scene.
{ printf '\357\273\277'; cat $scene; } >"$work/marked.yaml"
run "$HEBRA" check "$work/marked.yaml"; wants 0 ribbon

run "$HEBRA" run $scene -o "$work/none" --set method.tme_step=1; wants 2 tme_step time_step
run "$HEBRA" run $scene -o "$work/none" --set 'method.time_step=-1'; wants 2 '-1'
run "$HEBRA" run $scene -o "$work/none" --set; wants 2 --set
run "$HEBRA" run $scene -o "$work/none" --set nonsense; wants 2 nonsense
check "nothing is left by wrong settings" test ! -e "$work/none"
finish
