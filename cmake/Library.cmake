# The library in two parts: hebra_core needs libc and libm only, hebra adds scenes, files and pictures.
find_package(PkgConfig REQUIRED)
pkg_check_modules(YAML REQUIRED IMPORTED_TARGET yaml-0.1)
pkg_check_modules(PNG REQUIRED IMPORTED_TARGET libpng)
# Debian keeps the serial and the MPI builds of HDF5 side by side; plain "hdf5" may be either.
pkg_search_module(HDF5 REQUIRED IMPORTED_TARGET hdf5-serial hdf5)

# Rooms from the lowest floor to the highest; tools/check_floors holds the same order.
set(HEBRA_CORE_ROOMS base math model state rod body force contact solve lane time statics sim)
set(HEBRA_SHELL_ROOMS scene output render)

# Makes a library from the rooms named after it.
function(hebra_library name)
  list(TRANSFORM ARGN REPLACE "(.+)" "${PROJECT_SOURCE_DIR}/src/\\1/*.c" OUTPUT_VARIABLE patterns)
  file(GLOB sources CONFIGURE_DEPENDS ${patterns})
  add_library(${name} ${sources})
  add_library(hebra::${name} ALIAS ${name})
  target_include_directories(${name} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}> PRIVATE ${PROJECT_SOURCE_DIR}/src)
  target_link_libraries(${name} PRIVATE $<BUILD_INTERFACE:hebra_flags>)
  set_target_properties(${name} PROPERTIES POSITION_INDEPENDENT_CODE ON VERSION ${PROJECT_VERSION}
    SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
endfunction()

hebra_library(hebra_core ${HEBRA_CORE_ROOMS})
target_link_libraries(hebra_core PUBLIC m)
if(HEBRA_THREADS)
  set(THREADS_PREFER_PTHREAD_FLAG ON)
  find_package(Threads REQUIRED)
  target_link_libraries(hebra_core PRIVATE Threads::Threads)
endif()
hebra_library(hebra ${HEBRA_SHELL_ROOMS})
target_link_libraries(hebra PUBLIC hebra_core PRIVATE PkgConfig::YAML PkgConfig::HDF5 PkgConfig::PNG)

# Kernels for wider instructions are chosen at run time; lanes wider than a register are split by the compiler.
set_source_files_properties(${PROJECT_SOURCE_DIR}/src/lane/double_portable.c ${PROJECT_SOURCE_DIR}/src/lane/single_portable.c
  PROPERTIES COMPILE_OPTIONS -Wno-psabi)
set(avx2_sources ${PROJECT_SOURCE_DIR}/src/lane/double_avx2.c ${PROJECT_SOURCE_DIR}/src/lane/single_avx2.c)
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  set_source_files_properties(${avx2_sources} PROPERTIES COMPILE_OPTIONS "-mavx2;-mfma;-Wno-psabi")
  target_compile_definitions(hebra_core PRIVATE HB_LANE_AVX2)
else()
  get_target_property(core_sources hebra_core SOURCES)
  list(REMOVE_ITEM core_sources ${avx2_sources})
  set_target_properties(hebra_core PROPERTIES SOURCES "${core_sources}")
endif()
if(HEBRA_FUZZ)
  # The readers that are fuzzed never step: sanitized kernels would take most of the time of that build.
  file(GLOB lane_sources ${PROJECT_SOURCE_DIR}/src/lane/*_*.c)
  set_property(SOURCE ${lane_sources} APPEND PROPERTY COMPILE_OPTIONS -O0 -fno-sanitize=all)
elseif(HEBRA_SANITIZERS AND CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  # The same source is sanitized with wider instructions; here it would take a third of the time of the build.
  set_property(SOURCE ${PROJECT_SOURCE_DIR}/src/lane/double_portable.c ${PROJECT_SOURCE_DIR}/src/lane/single_portable.c
    APPEND PROPERTY COMPILE_OPTIONS -fno-sanitize=all)
endif()
