// Options by name, for C.
#include "handhold/options.h"

#include "handhold/option_text.h"
#include "object.h"

using handhold::Options;
using handhold::c::check;
using handhold::c::fail;
using handhold::c::guarded;

handhold_code handhold_options_create(handhold_options** options) {
  if (!options) return HANDHOLD_NULL_ARGUMENT;
  *options = nullptr;
  return guarded(nullptr, HANDHOLD_FAILED, [&] { *options = new handhold_options; });
}

void handhold_options_destroy(handhold_options* options) {
  handhold::c::destroy(options);
}

handhold_code handhold_options_reset(handhold_options* options, const char* hand) {
  if (const handhold_code code = check(options)) return code;
  return guarded(&options->message, HANDHOLD_FAILED, [&] {
    if (hand && std::string(hand) != "baxter") {
      throw handhold::OptionError("unknown hand '" + std::string(hand) + "'; must be 'baxter'");
    }
    options->options = hand ? Options::baxter() : Options();
  });
}

handhold_code handhold_set(handhold_options* options, const char* name, const char* text) {
  if (const handhold_code code = check(options)) return code;
  if (!name || !text) return fail(&options->message, HANDHOLD_NULL_ARGUMENT);
  return guarded(&options->message, HANDHOLD_FAILED, [&] { set_option(options->options, name, text); });
}

handhold_code handhold_get(handhold_options* options, const char* name, const char** text) {
  if (text) *text = nullptr;
  if (const handhold_code code = check(options)) return code;
  if (!name || !text) return fail(&options->message, HANDHOLD_NULL_ARGUMENT);
  return guarded(&options->message, HANDHOLD_FAILED, [&] {
    options->text = get_option(options->options, name);
    *text = options->text.c_str();
  });
}

const char* handhold_options_message(const handhold_options* options) {
  const handhold_code code = check(options);
  return code ? handhold_code_text(code) : options->message.text;
}
