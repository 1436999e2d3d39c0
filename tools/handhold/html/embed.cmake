# cmake -DTHREE=<three.min.js> -DSOURCES=<tools/handhold/html> -DSCRIPTS=<names, '+' between> -DOUTPUT=<file.cpp> -P embed.cmake
# Puts the page together and writes it as C++: an installed program needs no file beside it.
set(delimiter handhold_page)

function(read_script path variable)
  file(READ ${path} text)
  # Inside a script element these two are all that HTML still looks for.
  if(text MATCHES "</[Ss][Cc][Rr][Ii][Pp][Tt]|<!--")
    message(FATAL_ERROR "${path}: '</script' or '<!--' would end the page's script; write them in two pieces")
  endif()
  set(${variable} "${text}" PARENT_SCOPE)
endfunction()

file(READ ${SOURCES}/page.html page)
file(READ ${SOURCES}/page.css style)
file(READ ${SOURCES}/three_license.txt license)
read_script(${THREE} three)
read_script(${SOURCES}/failure.js failure)
string(REPLACE "+" ";" SCRIPTS "${SCRIPTS}")
set(program "")
foreach(name IN LISTS SCRIPTS)
  read_script(${SOURCES}/${name} script)
  string(APPEND program "${script}\n")
endforeach()
foreach(mark style license three failure program)
  string(TOUPPER "@${mark}@" place)
  string(REPLACE "${place}" "${${mark}}" page "${page}")
endforeach()
string(FIND "${page}" ")${delimiter}\"" found)
if(NOT found EQUAL -1)
  message(FATAL_ERROR "the page's text has the delimiter of the C++ literal in it")
endif()
file(WRITE ${OUTPUT}.part "// Made by embed.cmake.
#include \"page_template.h\"

namespace handhold {

std::string_view page_template() {
  static constexpr char kPage[] = R\"${delimiter}(${page})${delimiter}\";
  return {kPage, sizeof kPage - 1};
}

}  // namespace handhold
")
file(RENAME ${OUTPUT}.part ${OUTPUT})
