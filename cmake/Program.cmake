# The program: one file per verb in cli/.
file(GLOB HEBRA_CLI_SOURCES CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/cli/*.c)
add_executable(hebra_program ${HEBRA_CLI_SOURCES})
if(HEBRA_FUZZ) # its targets feed the library, not the program
  set_target_properties(hebra_program PROPERTIES EXCLUDE_FROM_ALL ON)
endif()
set_target_properties(hebra_program PROPERTIES OUTPUT_NAME hebra)
target_include_directories(hebra_program PRIVATE ${PROJECT_SOURCE_DIR} ${PROJECT_SOURCE_DIR}/cli ${PROJECT_SOURCE_DIR}/src)
target_link_libraries(hebra_program PRIVATE hebra hebra_flags)
# Measuring what the machine can do takes the fused multiply-adds that results must not use.
set_source_files_properties(${PROJECT_SOURCE_DIR}/cli/bench_peak.c PROPERTIES COMPILE_OPTIONS -ffp-contract=fast)
