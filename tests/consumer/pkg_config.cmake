# Builds the examples by what pkg-config says about an installation that was moved.
# cmake -DPREFIX= -DLIBDIR=<below the prefix> -DWORK= -DVERSION= -DCC= -DCXX= -DPKG_CONFIG= -DEXAMPLES=
#       -P pkg_config.cmake
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)

file(REMOVE_RECURSE ${WORK})
file(COPY ${PREFIX}/ DESTINATION ${WORK}/moved)
set(ENV{PKG_CONFIG_PATH} ${WORK}/moved/${LIBDIR}/pkgconfig)
set(ENV{LD_LIBRARY_PATH} ${WORK}/moved/${LIBDIR})

foreach(package handhold handhold_c)
  run(${PKG_CONFIG} --exact-version=${VERSION} ${package})
  execute_process(COMMAND ${PKG_CONFIG} --cflags --libs ${package} OUTPUT_VARIABLE flags COMMAND_ERROR_IS_FATAL ANY
                  OUTPUT_STRIP_TRAILING_WHITESPACE)
  message("${package}: ${flags}")
  string(FIND "${flags}" "${WORK}/moved/" moved)
  string(FIND "${flags}" "${PREFIX}/" unmoved)
  if(moved LESS 0 OR unmoved GREATER_EQUAL 0)
    message(FATAL_ERROR "the flags must point below ${WORK}/moved and nowhere else")
  endif()
  separate_arguments(${package}_flags UNIX_COMMAND "${flags}")
endforeach()

# The linker a program in C takes is the one of C: what is written in C++ must come by the flags.
run(${CC} -std=c99 -Wall -Wextra -pedantic -Werror ${EXAMPLES}/localize.c ${handhold_c_flags} -lm -o ${WORK}/example_c)
run(${CXX} -std=c++17 -Wall -Wextra -Werror ${EXAMPLES}/localize.cpp ${handhold_flags} -o ${WORK}/example_cpp)
run_examples(${WORK}/example_cpp ${WORK}/example_c)
