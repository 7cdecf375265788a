# Compiler flags of everything in the project: target hebra_flags, linked privately by every target.

# Optimisation is chosen here and not left to CMake's defaults, which add -DNDEBUG and so change what is tested.
set(CMAKE_C_FLAGS_RELEASE "-O3")
set(CMAKE_C_FLAGS_RELWITHDEBINFO "-O2 -g")
set(CMAKE_C_FLAGS_DEBUG "-O1 -g")

add_library(hebra_flags INTERFACE)
target_compile_definitions(hebra_flags INTERFACE _POSIX_C_SOURCE=200809L)
# The same bits at every optimisation level and from every compiler: no fused multiply-add unless it is written.
# errno is never read after a mathematical function, so they may become instructions.
target_compile_options(hebra_flags INTERFACE -ffp-contract=off -fno-math-errno)
# Position-independent code may inline its own functions: nobody replaces them at load time.
target_compile_options(hebra_flags INTERFACE -fno-semantic-interposition)
target_compile_options(hebra_flags INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -Wstrict-prototypes -Wmissing-prototypes
  -Wold-style-definition -Wdouble-promotion -Wvla -Wundef -Wwrite-strings -Wpointer-arith -Wformat=2
  -Wimplicit-fallthrough)
if(HEBRA_WERROR)
  target_compile_options(hebra_flags INTERFACE -Werror)
endif()
if(HEBRA_NATIVE)
  # Not for targets whose instructions are counted (Bench.cmake).
  target_compile_options(hebra_flags INTERFACE $<$<NOT:$<BOOL:$<TARGET_PROPERTY:HEBRA_ANY_MACHINE>>>:-march=native>)
endif()

if(NOT HEBRA_THREADS)
  target_compile_definitions(hebra_flags INTERFACE HB_NO_THREADS)
endif()

set(HEBRA_SANITIZERS "")
if(HEBRA_TSAN)
  set(HEBRA_SANITIZERS -fsanitize=thread -fno-omit-frame-pointer)
elseif(HEBRA_SANITIZE OR HEBRA_FUZZ)
  set(HEBRA_SANITIZERS -fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer)
endif()
target_compile_options(hebra_flags INTERFACE ${HEBRA_SANITIZERS})
if(HEBRA_TSAN AND CMAKE_C_COMPILER_ID STREQUAL GNU)
  # The calls of the sanitizer hide from gcc which paths are taken: it then sees uninitialised values where none are.
  target_compile_options(hebra_flags INTERFACE -Wno-maybe-uninitialized)
endif()
target_link_options(hebra_flags INTERFACE ${HEBRA_SANITIZERS})
if(HEBRA_FUZZ)
  if(NOT CMAKE_C_COMPILER_ID MATCHES Clang)
    message(FATAL_ERROR "HEBRA_FUZZ needs clang: libFuzzer belongs to it. Use the preset fuzz.")
  endif()
  target_compile_options(hebra_flags INTERFACE -fsanitize=fuzzer-no-link)
  target_link_options(hebra_flags INTERFACE -fsanitize=fuzzer-no-link)
endif()
