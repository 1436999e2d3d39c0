// The page's program and looks: page.html with its style, its scripts and three.js, put together by embed.cmake.
#pragma once

#include <string_view>

namespace handhold {

/// Empty in a build without three.js.
std::string_view page_template();

}  // namespace handhold
