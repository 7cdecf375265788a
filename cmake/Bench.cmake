# What the counting tools in bench/ run: the core and the rods of `hebra bench`, compiled for one instruction set and
# one level of optimisation whoever compiles, so that counts of one compiler are the same everywhere.
if(HEBRA_SANITIZE OR HEBRA_FUZZ)
  return()
endif()
include(CheckCCompilerFlag)
# Line tables change no instruction; by them bench/count knows the source file of a function. Version 4 is what valgrind
# reads from any compiler.
set(HEBRA_COUNTED_FLAGS -O3 -g1 -gdwarf-4)
if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|AMD64)$")
  check_c_compiler_flag(-march=x86-64-v3 HEBRA_HAS_X86_64_V3)
  if(HEBRA_HAS_X86_64_V3)
    list(APPEND HEBRA_COUNTED_FLAGS -march=x86-64-v3)
  endif()
  if(CMAKE_C_COMPILER_ID STREQUAL "GNU")
    list(APPEND HEBRA_COUNTED_FLAGS -B${PROJECT_SOURCE_DIR}/bench/assembler/)
  endif()
endif()
get_target_property(sources hebra_core SOURCES)
get_target_property(definitions hebra_core COMPILE_DEFINITIONS)
get_target_property(libraries hebra_core LINK_LIBRARIES)
add_library(hebra_counted STATIC ${sources})
target_link_libraries(hebra_counted PUBLIC ${libraries})
if(definitions)
  target_compile_definitions(hebra_counted PRIVATE ${definitions})
endif()
add_executable(count_steps ${PROJECT_SOURCE_DIR}/bench/count_steps.c ${PROJECT_SOURCE_DIR}/cli/bench_cases.c
  ${PROJECT_SOURCE_DIR}/cli/common.c)
target_link_libraries(count_steps PRIVATE hebra_counted)
foreach(target hebra_counted count_steps)
  set_target_properties(${target} PROPERTIES HEBRA_ANY_MACHINE ON POSITION_INDEPENDENT_CODE ON)
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR}/include ${PROJECT_SOURCE_DIR}/src
    ${PROJECT_SOURCE_DIR})
  target_link_libraries(${target} PRIVATE hebra_flags)
  target_compile_options(${target} PRIVATE ${HEBRA_COUNTED_FLAGS})
endforeach()
set_target_properties(count_steps PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bench)

# Counts of another compiler would only be printed.
if(CMAKE_C_COMPILER_ID STREQUAL "GNU" AND CMAKE_BUILD_TYPE STREQUAL "Release")
  hebra_test(bench.gate 120 ${PROJECT_SOURCE_DIR}/bench/gate)
  hebra_test(bench.count 120 ${PROJECT_SOURCE_DIR}/bench/count --check)
  hebra_test(bench.gate_fails 120 ${BASH_PROGRAM} ${PROJECT_SOURCE_DIR}/tests/bench_gate.sh)
endif()
