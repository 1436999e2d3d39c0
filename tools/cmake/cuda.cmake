# CUDA sources without CMake's CUDA language: nvcc makes ordinary objects, and what links them stays a C++ program that
# an ordinary C++ compiler links.
set(HANDHOLD_HAVE_CUDA OFF)
if(HANDHOLD_CUDA)
  find_package(CUDAToolkit QUIET)
  if(CUDAToolkit_FOUND AND CUDAToolkit_NVCC_EXECUTABLE AND TARGET CUDA::cudart_static AND NOT CMAKE_CROSSCOMPILING)
    if(CUDAToolkit_VERSION VERSION_LESS 12.0)
      set(handhold_no_cuda "CUDA ${CUDAToolkit_VERSION} is too old; 12.0 or later is needed")
    else()
      set(HANDHOLD_HAVE_CUDA ON)
    endif()
  else()
    set(handhold_no_cuda "there is no nvcc (CUDA Toolkit 12.0 or later)")
  endif()
  if(HANDHOLD_HAVE_CUDA)
    message(STATUS "The CUDA backend is built with CUDA ${CUDAToolkit_VERSION} for ${HANDHOLD_CUDA_ARCHITECTURES}")
  elseif(HANDHOLD_CUDA STREQUAL "ON")
    message(FATAL_ERROR "HANDHOLD_CUDA is ON, but ${handhold_no_cuda}")
  else()
    message(STATUS "The CUDA backend is left out: ${handhold_no_cuda}")
  endif()
endif()

set(handhold_nvcc_flags "")
if(HANDHOLD_HAVE_CUDA)
  list(GET HANDHOLD_CUDA_ARCHITECTURES -1 latest)
  foreach(architecture IN LISTS HANDHOLD_CUDA_ARCHITECTURES)
    if(NOT architecture MATCHES "^[0-9]+$" OR architecture LESS 80)
      message(FATAL_ERROR "HANDHOLD_CUDA_ARCHITECTURES = ${HANDHOLD_CUDA_ARCHITECTURES}: must be numbers of 80 (compute capability 8.0) or more")
    endif()
    list(APPEND handhold_nvcc_flags "-gencode=arch=compute_${architecture},code=sm_${architecture}")
  endforeach()
  list(APPEND handhold_nvcc_flags "-gencode=arch=compute_${latest},code=compute_${latest}")
endif()

# Adds .cu files to a target. -fmad=false: the kernels say where they fuse, and their bits are to be the CPU's. A kernel
# whose registers do not hold what it works on is an error.
function(handhold_cuda_sources target)
  foreach(source IN LISTS ARGN)
    get_filename_component(name ${source} NAME_WE)
    set(object ${CMAKE_CURRENT_BINARY_DIR}/${name}.cu.o)
    add_custom_command(
      OUTPUT ${object}
      COMMAND ${CMAKE_CXX_COMPILER_LAUNCHER} ${CUDAToolkit_NVCC_EXECUTABLE} -ccbin ${CMAKE_CXX_COMPILER} -std=c++17 -O3 -DNDEBUG
              -fmad=false --expt-relaxed-constexpr --threads 2 -Xcompiler=-fPIC,-ffp-contract=off,-Wall,-Wextra
              -Xptxas=--warn-on-spills,--warning-as-error ${handhold_nvcc_flags} -I${PROJECT_SOURCE_DIR}/engine/include
              -I${PROJECT_SOURCE_DIR}/engine/src -I${PROJECT_SOURCE_DIR}/engine/cuda -I${PROJECT_SOURCE_DIR}/kernels
              -MD -MT ${object} -MF ${object}.d -c ${CMAKE_CURRENT_SOURCE_DIR}/${source} -o ${object}
      DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${source}
      DEPFILE ${object}.d
      COMMENT "Building CUDA object ${object}"
      COMMAND_EXPAND_LISTS VERBATIM)
    target_sources(${target} PRIVATE ${object})
  endforeach()
  target_link_libraries(${target} PRIVATE CUDA::cudart_static)
endfunction()
