// The options of the paper's method, for tests of its steps.
#pragma once

#include "handhold/options.h"

namespace handhold::test {

inline Options paper_options() {
  Options options;
  options.method = Method::kPaper;
  return options;
}

}  // namespace handhold::test
