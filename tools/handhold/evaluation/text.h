// Formatted text as a string.
#pragma once

#include <string>

namespace handhold::evaluation {

/// printf into a string.
__attribute__((format(printf, 1, 2))) std::string format(const char* pattern, ...);

}  // namespace handhold::evaluation
