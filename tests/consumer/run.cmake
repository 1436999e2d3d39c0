function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
endfunction()

# The example in C++ and the one in C find the rod, and say the same.
function(run_examples cpp c)
  foreach(language cpp c)
    execute_process(COMMAND ${${language}} OUTPUT_VARIABLE output_${language} COMMAND_ERROR_IS_FATAL ANY)
    message("${output_${language}}")
  endforeach()
  if(NOT output_c MATCHES "^status ok\nhandle at .* radius 0\\.02[45] m" OR NOT output_c STREQUAL output_cpp)
    message(FATAL_ERROR "the examples must find the rod of radius 0.025 m, and agree")
  endif()
endfunction()
