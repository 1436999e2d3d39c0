// Versions, and what codes, statuses and options are called.
#include <string_view>

#include "handhold/handhold.h"
#include "handhold/localizer.h"
#include "handhold/options.h"
#include "statuses.h"

static_assert(std::string_view(HANDHOLD_VERSION_STRING) == HANDHOLD_PROJECT_VERSION,
              "engine/include/handhold/version.h and project() in CMakeLists.txt name different versions");
static_assert(HANDHOLD_ABI == HANDHOLD_C_SOVERSION,
              "engine/c/CMakeLists.txt and engine/include/handhold/handhold.h name different ABIs");

const char* handhold_version(void) {
  return HANDHOLD_VERSION_STRING;
}
uint32_t handhold_abi(void) {
  return HANDHOLD_ABI;
}
const char* handhold_isa(void) {
  return handhold::Localizer::isa();
}

const char* handhold_code_text(handhold_code code) {
  switch (code) {
    case HANDHOLD_OK:
      return "success";
    case HANDHOLD_NULL_ARGUMENT:
      return "a pointer that is needed is NULL";
    case HANDHOLD_BAD_OBJECT:
      return "a pointer to something else than the object that the function takes";
    case HANDHOLD_BAD_SIZE:
      return "the size of a struct must be its sizeof, and fields that this version does not know must be zero";
    case HANDHOLD_BAD_INDEX:
      return "index beyond the last one";
    case HANDHOLD_BAD_OPTION:
      return "unknown option or value out of range";
    case HANDHOLD_BAD_CLOUD:
      return "the cloud contradicts itself";
    case HANDHOLD_NO_FRAME:
      return "there is no result: handhold_localize must succeed first";
    case HANDHOLD_BUSY:
      return "another thread makes or reads this localizer's result";
    case HANDHOLD_NO_MEMORY:
      return "out of memory";
    case HANDHOLD_FAILED:
      return "failed for an unknown reason";
  }
  return "unknown code";
}

const char* handhold_status_text(handhold_status number) {
  handhold::Status status;
  return handhold::c::status_from(number, status) ? to_string(status).data() : "unknown";  // a literal ends with a zero
}

namespace {

/// The index-th option; all NULL beyond the last.
handhold::OptionInfo option(size_t index) {
  handhold::OptionInfo found{};
  size_t i = 0;
  const handhold::Options defaults;
  visit_options(defaults, [&](const auto&, const handhold::OptionInfo& info) {
    if (i++ == index) found = info;
  });
  return found;
}

}  // namespace

size_t handhold_option_count(void) {
  size_t count = 0;
  const handhold::Options defaults;
  visit_options(defaults, [&](const auto&, const handhold::OptionInfo&) { ++count; });
  return count;
}
const char* handhold_option_name(size_t index) {
  return option(index).name;
}
const char* handhold_option_unit(size_t index) {
  return option(index).unit;
}
const char* handhold_option_help(size_t index) {
  return option(index).help;
}
