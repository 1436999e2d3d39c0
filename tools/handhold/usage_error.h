// Wrong use of the command line, as against work that failed.
#pragma once

#include <stdexcept>

namespace handhold {

/// Ends the program with exit code 2. what() is one line: what, where, what would be right.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace handhold
