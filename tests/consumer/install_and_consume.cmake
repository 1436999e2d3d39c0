# cmake -DBUILD= -DPREFIX= -DVERSION= -DAPP= -DAPP_BUILD= -DCONFIG= -DGENERATOR= -DCC= -DCXX= -DEXAMPLES=
#       -DREADME= -DREADME_TEST=<tests/readme> -P install_and_consume.cmake
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)

# From scratch: a file that is no longer installed must not be found, and no setting of the last time may help.
file(REMOVE_RECURSE ${PREFIX} ${APP_BUILD})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${PREFIX} --config ${CONFIG})
run(${CMAKE_COMMAND} -DREADME=${README} -DPARTS=${README_TEST} -DOUTPUT=${APP_BUILD}/readme_snippet.cpp
    -P ${README_TEST}/extract_snippet.cmake)
run(${CMAKE_COMMAND} -G ${GENERATOR} -S ${APP} -B ${APP_BUILD} -DCMAKE_BUILD_TYPE=${CONFIG} -DCMAKE_C_COMPILER=${CC}
    -DCMAKE_CXX_COMPILER=${CXX} -DCMAKE_PREFIX_PATH=${PREFIX} -DEXPECTED_PREFIX=${PREFIX} -DEXPECTED_VERSION=${VERSION}
    -DREADME_SNIPPET=${APP_BUILD}/readme_snippet.cpp -DEXAMPLES=${EXAMPLES})
run(${CMAKE_COMMAND} --build ${APP_BUILD} --config ${CONFIG})
run(${APP_BUILD}/consumer)
run(${APP_BUILD}/readme)
run_examples(${APP_BUILD}/example_cpp ${APP_BUILD}/example_c)
