#!/bin/bash
# Every public header compiles alone, as C17 and (if there is a C++ compiler) as C++17, without a warning.
#   check_headers.sh C_COMPILER
set -uo pipefail
cd "$(dirname "$0")/.."
cc=$1
warn=(-Wall -Wextra -Wpedantic -Werror)
failed=0 checked=0

for header in include/hebra/*.h; do
  # Twice: the second time the guard has to hold.
  source="#include \"hebra/$(basename "$header")\"
#include \"hebra/$(basename "$header")\""
  "$cc" -std=c17 -x c "${warn[@]}" -Wstrict-prototypes -Iinclude -fsyntax-only - <<<"$source" || failed=$((failed + 1))
  if command -v c++ >/dev/null; then
    c++ -std=c++17 -x c++ "${warn[@]}" -Iinclude -fsyntax-only - <<<"$source" || failed=$((failed + 1))
  fi
  checked=$((checked + 1))
done
echo "$checked headers, $failed failures"
[ "$checked" -gt 0 ] && [ "$failed" = 0 ]
