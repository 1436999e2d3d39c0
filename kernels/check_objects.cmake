# Fails when an object of one instruction set defines something that other code could pick up.
#
# A weak symbol (an inline function, a template, a vague constant) exists once in the program: the linker keeps whichever
# copy it meets first, perhaps one with instructions that this machine does not have. So an object of instruction set
# <isa> may define
#   - global symbols only in namespace handhold::lane_<isa>, and the accessor handhold::kernels::table_<isa>,
#   - no weak and no unique symbols, not even there,
#   - no data that can change: kernels run on many threads at once.
#
# cmake -DNM=<nm> "-DOBJECTS=<a.o>;<b.o>" -DISA=<isa> -P check_objects.cmake
cmake_minimum_required(VERSION 3.25)
foreach(name NM OBJECTS ISA)
  if("${${name}}" STREQUAL "")
    message(FATAL_ERROR "check_objects.cmake: -D${name}= is missing")
  endif()
endforeach()

# Mangled names hold the length of each part: N 8handhold 9lane_avx2 ...
string(LENGTH "lane_${ISA}" lane_length)
string(LENGTH "table_${ISA}" table_length)
set(own "N[KVRO]*8handhold${lane_length}lane_${ISA}|^_ZN8handhold7kernels${table_length}table_${ISA}E")

set(leaks "")
foreach(object IN LISTS OBJECTS)
  # The sysv format is the one that names sections: constants with addresses in them (tables of functions) count as data
  # of position-independent code, but stand in .data.rel.ro, which is read-only once the program runs.
  execute_process(COMMAND ${NM} --format=sysv --defined-only ${object} OUTPUT_VARIABLE listing ERROR_VARIABLE error
                  RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "check_objects.cmake: ${NM} cannot read ${object}: ${error}")
  endif()
  string(REGEX MATCHALL "[^\n]+\\|[^\n]+" lines "${listing}")
  set(functions 0)
  foreach(line IN LISTS lines)
    if(NOT line MATCHES "^([^| ]+) *\\|[^|]*\\| *([A-Za-z?]) *\\|[^|]*\\|[^|]*\\|[^|]*\\| *([^ ]*)")
      continue()  # the heading
    endif()
    set(symbol ${CMAKE_MATCH_1})
    set(type ${CMAKE_MATCH_2})
    set(section ${CMAKE_MATCH_3})
    if(symbol MATCHES "^(__odr_asan|_*asan|_*tsan|_*ubsan|\\.L)")
      continue()  # a sanitizer's own records
    endif()
    if(type MATCHES "^[Tt]$")
      math(EXPR functions "${functions} + 1")
    endif()
    if(type MATCHES "^[WwVvui]$")
      list(APPEND leaks "${symbol}: weak, unique or indirect (${type}), make the function force-inline or static")
    elseif(type MATCHES "^[BbDdCcGgSs]$" AND NOT section MATCHES "^\\.data\\.rel\\.ro")
      list(APPEND leaks "${symbol}: data that can change (${type} in ${section}), make it const")
    elseif(type MATCHES "^[A-Z]$" AND NOT symbol MATCHES "${own}")
      list(APPEND leaks "${symbol}: global (${type}) outside namespace handhold::lane_${ISA}")
    endif()
  endforeach()
  if(functions EQUAL 0)
    list(APPEND leaks "no function found: an object for link-time optimisation cannot be checked")
  endif()
  if(leaks)
    list(JOIN leaks "\n  " text)
    message(FATAL_ERROR "${object} leaks out of instruction set ${ISA}:\n  ${text}")
  endif()
endforeach()
