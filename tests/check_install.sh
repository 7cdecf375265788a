#!/bin/bash
# What is installed is enough to use the library: through pkg-config, through find_package, and as a Debian package.
#   check_install.sh CMAKE C_COMPILER GENERATOR
set -euo pipefail
cmake=$1 cc=$2 generator=$3
scratch=${HEBRA_SCRATCH:?} prefix=${HEBRA_SCRATCH:?}/prefix
rm -rf "$scratch" && mkdir -p "$scratch"
"$cmake" --install "${HEBRA_BUILD:?}" --prefix "$prefix" >"$scratch/install.log"

# A program that pulls in every part of the library.
cat >"$scratch/main.c" <<'C'
#include <hebra/hebra.h>
#include <stdio.h>
#include <string.h>
int main(void) {
  hb_error err;
  hb_scene_def scene;
  hb_reader *reader;
  hb_image image;
  if (strcmp(hb_version(), HB_VERSION) != 0) return 1;
  if (hb_scene_read("nothing.yaml", NULL, 0, &scene, &err) == HB_OK) return 2;
  if (hb_reader_open("nothing.h5", &reader, &err) == HB_OK) return 3;
  if (hb_image_create(4, 4, &image, &err) != HB_OK) return 4;
  if (hb_image_write_png(&image, "image.png", &err) != HB_OK) return 5;
  hb_image_free(&image);
  puts(hb_version());
  return 0;
}
C
cat >"$scratch/CMakeLists.txt" <<'CMAKE'
cmake_minimum_required(VERSION 3.22)
project(user C)
find_package(hebra 0.1 REQUIRED)
add_executable(user main.c)
target_link_libraries(user hebra::hebra)
CMAKE

cd "$scratch"
pc=$(dirname "$(find "$prefix" -name hebra.pc)")
flags=$(PKG_CONFIG_PATH=$pc pkg-config --cflags --libs hebra)
"$cc" -o by_pkg_config main.c $flags
./by_pkg_config

"$cmake" -G "$generator" -S . -B by_cmake -DCMAKE_PREFIX_PATH="$prefix" -DCMAKE_C_COMPILER="$cc" >cmake.log
"$cmake" --build by_cmake >>cmake.log
./by_cmake/user

"$prefix/bin/hebra" --version
test -f "$prefix/share/hebra/scenes/thesis-2-catenary.yaml"

command -v dpkg-deb >/dev/null || { echo "no dpkg-deb: the package is not checked"; exit 0; }
"${cmake%/cmake}/cpack" --config "$HEBRA_BUILD/CPackConfig.cmake" -B "$scratch/package" >cpack.log
package=$(find "$scratch/package" -name '*.deb' | head -n 1)
dpkg-deb --contents "$package" >contents.txt
grep -q 'usr/bin/hebra$' contents.txt
dpkg-deb --field "$package" Package Version Recommends
