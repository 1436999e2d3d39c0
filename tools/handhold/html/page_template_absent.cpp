// Built without three.js.
#include "page_template.h"

namespace handhold {

std::string_view page_template() {
  return {};
}

}  // namespace handhold
