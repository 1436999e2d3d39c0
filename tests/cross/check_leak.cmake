# Compiles one small source as the objects of an instruction set are compiled and runs check_objects.cmake on it.
# EXPECT: a regular expression that the complaint must match; empty: there must be none.
#
# cmake -DCXX= -DNM= -DSOURCE= -DOBJECT= -DCHECK=<check_objects.cmake> -DEXPECT= -P check_leak.cmake
foreach(optimisation -O0 -O2)
  execute_process(COMMAND ${CXX} -std=c++17 -fPIC -fno-exceptions ${optimisation} -c ${SOURCE} -o ${OBJECT}
                  COMMAND_ERROR_IS_FATAL ANY)
  execute_process(COMMAND ${CMAKE_COMMAND} -DNM=${NM} -DOBJECTS=${OBJECT} -DISA=avx2 -P ${CHECK}
                  RESULT_VARIABLE result ERROR_VARIABLE complaint OUTPUT_VARIABLE complaint)
  if(EXPECT STREQUAL "" AND NOT result EQUAL 0)
    message(FATAL_ERROR "${SOURCE} at ${optimisation}: refused although nothing leaks:\n${complaint}")
  elseif(NOT EXPECT STREQUAL "" AND result EQUAL 0)
    message(FATAL_ERROR "${SOURCE} at ${optimisation}: the leak was not found")
  elseif(NOT complaint MATCHES "${EXPECT}")
    message(FATAL_ERROR "${SOURCE} at ${optimisation}: expected a complaint like '${EXPECT}', got:\n${complaint}")
  endif()
endforeach()
