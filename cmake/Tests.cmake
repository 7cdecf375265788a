# Tests: one cmocka executable per tests/{unit,contract,physics}/test_*.c, one entry per tests/cli/*.sh, the checks of
# the house, and the fuzz targets. Names: unit.NAME, contract.NAME, physics.NAME, cli.NAME, check.NAME, fuzz.NAME.
include(CheckCSourceRuns)
find_program(BASH_PROGRAM bash REQUIRED)
set(HEBRA_SCRATCH ${PROJECT_BINARY_DIR}/scratch)
set(tests_dir ${PROJECT_SOURCE_DIR}/tests)

# Registers a test: name, seconds it may take, command. It runs in the source tree with an own scratch directory. Tests
# of the program and of physics take longest: they start first, so that none is left running alone at the end.
function(hebra_test name seconds)
  set(full ${HEBRA_TEST_PREFIX}${name})
  add_test(NAME ${full} COMMAND ${ARGN} WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
  file(MAKE_DIRECTORY ${HEBRA_SCRATCH}/${name})
  set(cost 1)
  if(name MATCHES "^(cli|physics|fuzz)")
    set(cost 10)
  endif()
  set_tests_properties(${full} PROPERTIES TIMEOUT ${seconds} COST ${cost} SKIP_RETURN_CODE 77 ENVIRONMENT
    "HEBRA=$<TARGET_FILE:hebra_program>;HEBRA_SCRATCH=${HEBRA_SCRATCH}/${name};HEBRA_SOURCE=${PROJECT_SOURCE_DIR};HEBRA_BUILD=${PROJECT_BINARY_DIR};ASAN_OPTIONS=detect_leaks=1:allocator_may_return_null=1;UBSAN_OPTIONS=print_stacktrace=1")
endfunction()

# An executable of a test, with the insides of the library in reach.
function(hebra_test_program target)
  add_executable(${target} ${ARGN})
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR}/src ${tests_dir} ${PROJECT_SOURCE_DIR})
  target_compile_definitions(${target} PRIVATE HEBRA_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  target_link_libraries(${target} PRIVATE hebra hebra_flags PkgConfig::YAML PkgConfig::HDF5 PkgConfig::PNG)
  set_target_properties(${target} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/tests)
endfunction()

# ---- cmocka ----
if(NOT HEBRA_FUZZ)
  pkg_check_modules(CMOCKA REQUIRED IMPORTED_TARGET cmocka)
  # What several tests share. The two others there are linked only where they belong.
  file(GLOB sources CONFIGURE_DEPENDS ${tests_dir}/support/*.c)
  list(FILTER sources EXCLUDE REGEX "/(failing_alloc|fuzz_replay)\\.c$")
  add_library(hebra_test_support STATIC ${sources})
  target_include_directories(hebra_test_support PUBLIC ${PROJECT_SOURCE_DIR}/src ${tests_dir})
  target_link_libraries(hebra_test_support PRIVATE hebra hebra_flags PkgConfig::CMOCKA)
  foreach(kind unit contract physics)
    file(GLOB sources CONFIGURE_DEPENDS ${tests_dir}/${kind}/test_*.c)
    foreach(source ${sources})
      get_filename_component(stem ${source} NAME_WE)
      string(REGEX REPLACE "^test_" "" name ${stem})
      set(target test_${kind}_${name})
      hebra_test_program(${target} ${source})
      target_link_libraries(${target} PRIVATE hebra_test_support PkgConfig::CMOCKA)
      if(name MATCHES "_alloc$")
        # Wrapping works on references that the linker resolves here, so on the static library only.
        target_sources(${target} PRIVATE ${tests_dir}/support/failing_alloc.c)
        target_link_options(${target} PRIVATE -Wl,--wrap=malloc,--wrap=calloc,--wrap=realloc,--wrap=free
          -Wl,--wrap=pthread_create,--wrap=pthread_join)
      endif()
      if(NOT name MATCHES "_alloc$" OR NOT BUILD_SHARED_LIBS)
        hebra_test(${kind}.${name} 600 $<TARGET_FILE:${target}>)
      endif()
    endforeach()
  endforeach()

  # ---- threads: pool and queue under ThreadSanitizer, whatever the rest is built with ----
  set(CMAKE_REQUIRED_FLAGS -fsanitize=thread)
  check_c_source_runs("int main(void) { return 0; }" HEBRA_HAS_TSAN)
  unset(CMAKE_REQUIRED_FLAGS)
  if(HEBRA_HAS_TSAN AND HEBRA_THREADS)
    file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/base/*.c)
    add_executable(test_tsan_threads ${tests_dir}/unit/test_threads.c ${sources})
    target_include_directories(test_tsan_threads PRIVATE ${PROJECT_SOURCE_DIR}/include ${PROJECT_SOURCE_DIR}/src
      ${tests_dir})
    target_compile_definitions(test_tsan_threads PRIVATE _POSIX_C_SOURCE=200809L)
    target_compile_options(test_tsan_threads PRIVATE -g -O1 -fsanitize=thread)
    target_link_options(test_tsan_threads PRIVATE -fsanitize=thread)
    target_link_libraries(test_tsan_threads PRIVATE Threads::Threads PkgConfig::CMOCKA m)
    set_target_properties(test_tsan_threads PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/tests)
    hebra_test(tsan.threads 300 $<TARGET_FILE:test_tsan_threads>)
  endif()

  # ---- the program ----
  # Two are long and of one build only: killing runs proves the order of writes to the disk, and the bench's figures
  # mean nothing but in the build that is timed.
  set(skipped "")
  if(HEBRA_SANITIZERS OR NOT CMAKE_C_COMPILER_ID STREQUAL GNU)
    set(skipped bench kill)
  endif()
  file(GLOB scripts CONFIGURE_DEPENDS ${tests_dir}/cli/*.sh)
  foreach(script ${scripts})
    get_filename_component(name ${script} NAME_WE)
    if(name IN_LIST skipped)
      continue()
    endif()
    hebra_test(cli.${name} 600 ${BASH_PROGRAM} ${script})
  endforeach()

  # ---- rules of the house, which do not depend on the compiler: once ----
  if(CMAKE_C_COMPILER_ID STREQUAL GNU AND NOT HEBRA_SANITIZERS)
    hebra_test(check.floors 60 ${PROJECT_SOURCE_DIR}/tools/check_floors)
    hebra_test(check.sizes 60 ${PROJECT_SOURCE_DIR}/tools/check_sizes)
    hebra_test(check.format 120 ${PROJECT_SOURCE_DIR}/tools/format check)
    hebra_test(check.docs 180 ${PROJECT_SOURCE_DIR}/tests/check_follow_step.py)
    hebra_test(check.errata 120 ${PROJECT_SOURCE_DIR}/tests/check_errata.py
      $<TARGET_FILE:test_physics_errata_formulas> $<TARGET_FILE:test_physics_errata_program>)
    hebra_test(check.checks 60 ${BASH_PROGRAM} ${tests_dir}/check_checks.sh)
  endif()
  hebra_test(check.headers 120 ${BASH_PROGRAM} ${tests_dir}/check_headers.sh ${CMAKE_C_COMPILER})
  if(NOT HEBRA_SANITIZERS AND NOT BUILD_SHARED_LIBS)
    hebra_test(check.symbols 60 ${PROJECT_SOURCE_DIR}/tools/check_symbols $<TARGET_FILE:hebra_core>
      $<TARGET_FILE:hebra>)
    hebra_test(check.install 120 ${BASH_PROGRAM} ${tests_dir}/check_install.sh ${CMAKE_COMMAND} ${CMAKE_C_COMPILER}
      ${CMAKE_GENERATOR})
  endif()
endif()

# ---- fuzzing: the kept corpus everywhere, new inputs for a few seconds with libFuzzer ----
set(HEBRA_FUZZ_SECONDS 6 CACHE STRING "Seconds that a fuzz test looks for new inputs")
file(GLOB sources CONFIGURE_DEPENDS ${tests_dir}/fuzz/fuzz_*.c)
foreach(source ${sources})
  get_filename_component(target ${source} NAME_WE)
  string(REGEX REPLACE "^fuzz_" "" name ${target})
  set(corpus ${tests_dir}/fuzz/corpus/${name})
  hebra_test_program(${target} ${source})
  if(HEBRA_FUZZ)
    target_link_options(${target} PRIVATE -fsanitize=fuzzer)
    hebra_test(fuzz.${name} 300 ${BASH_PROGRAM} ${tests_dir}/fuzz/run.sh $<TARGET_FILE:${target}> ${corpus}
      ${HEBRA_FUZZ_SECONDS})
  else()
    target_sources(${target} PRIVATE ${tests_dir}/support/fuzz_replay.c)
    hebra_test(corpus.${name} 300 $<TARGET_FILE:${target}> ${corpus})
  endif()
endforeach()
