# cmake -DBUILD= -DPREFIX= -DVERSION= -DAPP=<app, app_c beside it> -DAPP_BUILD= -DCONFIG= -DGENERATOR= -DCC= -DCXX=
#       -DEXAMPLES= -DREADME= -DREADME_TEST=<tests/readme> -P install_and_consume.cmake
include(${CMAKE_CURRENT_LIST_DIR}/run.cmake)

# From scratch: a file that is no longer installed must not be found, and no setting of the last time may help.
file(REMOVE_RECURSE ${PREFIX} ${APP_BUILD})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${PREFIX} --config ${CONFIG})
run(${CMAKE_COMMAND} -DREADME=${README} -DPARTS=${README_TEST} -DOUTPUT=${APP_BUILD}/readme_snippet.cpp
    -P ${README_TEST}/extract_snippet.cmake)
set(common -G ${GENERATOR} -DCMAKE_BUILD_TYPE=${CONFIG} -DCMAKE_PREFIX_PATH=${PREFIX} -DEXAMPLES=${EXAMPLES})
run(${CMAKE_COMMAND} ${common} -S ${APP} -B ${APP_BUILD} -DCMAKE_CXX_COMPILER=${CXX} -DEXPECTED_PREFIX=${PREFIX}
    -DEXPECTED_VERSION=${VERSION} -DREADME_SNIPPET=${APP_BUILD}/readme_snippet.cpp)
run(${CMAKE_COMMAND} --build ${APP_BUILD} --config ${CONFIG})
run(${CMAKE_COMMAND} ${common} -S ${APP}_c -B ${APP_BUILD}/c -DCMAKE_C_COMPILER=${CC})
run(${CMAKE_COMMAND} --build ${APP_BUILD}/c --config ${CONFIG})
run(${APP_BUILD}/consumer)
run(${APP_BUILD}/readme)
run_examples(${APP_BUILD}/example_cpp ${APP_BUILD}/c/example_c)
