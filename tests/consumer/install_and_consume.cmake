# cmake -DBUILD= -DPREFIX= -DVERSION= -DAPP= -DAPP_BUILD= -DCONFIG= -DGENERATOR= -DCXX=
#       -DREADME= -DREADME_TEST=<tests/readme> -P install_and_consume.cmake
function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
endfunction()

# From scratch: a file that is no longer installed must not be found, and no setting of the last time may help.
file(REMOVE_RECURSE ${PREFIX} ${APP_BUILD})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${PREFIX} --config ${CONFIG})
run(${CMAKE_COMMAND} -DREADME=${README} -DPARTS=${README_TEST} -DOUTPUT=${APP_BUILD}/readme_snippet.cpp
    -P ${README_TEST}/extract_snippet.cmake)
run(${CMAKE_COMMAND} -G ${GENERATOR} -S ${APP} -B ${APP_BUILD} -DCMAKE_BUILD_TYPE=${CONFIG} -DCMAKE_CXX_COMPILER=${CXX}
    -DCMAKE_PREFIX_PATH=${PREFIX} -DEXPECTED_PREFIX=${PREFIX} -DEXPECTED_VERSION=${VERSION}
    -DREADME_SNIPPET=${APP_BUILD}/readme_snippet.cpp)
run(${CMAKE_COMMAND} --build ${APP_BUILD} --config ${CONFIG})
run(${APP_BUILD}/consumer)
run(${APP_BUILD}/readme)
