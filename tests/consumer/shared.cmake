# Builds the library as a shared one. Of its C interface only the functions of handhold.h may be seen.
# cmake -DSOURCE= -DBUILD= -DGENERATOR= -DCXX= -DLAUNCHER= -DNM= -P shared.cmake
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)

# -O1 compiles in a quarter of the time.
run(${CMAKE_COMMAND} -G ${GENERATOR} -S ${SOURCE} -B ${BUILD} -DBUILD_SHARED_LIBS=ON -DHANDHOLD_TOOLS=OFF
    -DHANDHOLD_TESTS=OFF -DHANDHOLD_BENCH=OFF -DCMAKE_BUILD_TYPE=None -DCMAKE_CXX_FLAGS=-O1 -DCMAKE_CXX_COMPILER=${CXX}
    -DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER})
cmake_host_system_information(RESULT cores QUERY NUMBER_OF_LOGICAL_CORES)
run(${CMAKE_COMMAND} --build ${BUILD} --target handhold_c --parallel ${cores})

# Names of the symbols that a shared library defines for others.
function(exported library variable)
  execute_process(COMMAND ${NM} -D --defined-only ${library} OUTPUT_VARIABLE lines COMMAND_ERROR_IS_FATAL ANY)
  string(REGEX MATCHALL "[^ \n]+\n" names "${lines}")
  string(REPLACE "\n" "" names "${names}")
  list(SORT names)
  set(${variable} ${names} PARENT_SCOPE)
endfunction()

file(READ ${SOURCE}/engine/include/handhold/handhold.h header)
string(REGEX MATCHALL "HANDHOLD_API [^(]*\\(" declarations "${header}")
string(REGEX MATCHALL "handhold_[a-z_]+\\(" declared "${declarations}")
string(REPLACE "(" "" declared "${declared}")
list(SORT declared)
exported(${BUILD}/engine/c/libhandhold_c.so defined)
if(NOT declared OR NOT defined STREQUAL declared)
  message(FATAL_ERROR "handhold.h declares\n  ${declared}\nbut libhandhold_c.so has\n  ${defined}")
endif()

exported(${BUILD}/engine/libhandhold.so defined)
list(FILTER defined INCLUDE REGEX "^_ZNK?8handhold(7kernels|[0-9]+lane_)")
if(defined)
  message(FATAL_ERROR "the kernels must stay inside of libhandhold.so, but it has\n  ${defined}")
endif()
