#include "option_arguments.h"

#include "handhold/config.h"
#include "usage_error.h"

namespace handhold {

void add_preset_flags(CLI::App& app, OptionArguments& a, const std::string& group) {
  add_text_flag(app, "--config", a.config, "F.toml", "Options from a file; flags win over it, it wins over --hand",
                group);
  add_text_flag(app, "--hand", a.hand, "NAME", "Options of a known hand: baxter", group);
}

Options effective_options(const OptionArguments& a, const Options& defaults) {
  Options options = defaults;
  if (!a.hand.empty()) {
    if (a.hand != "baxter") throw UsageError("--hand: unknown hand '" + a.hand + "'; must be 'baxter'");
    options = Options::baxter();
  }
  ConfigLines lines;
  if (!a.config.empty()) lines = apply_toml_file(options, a.config);
  apply_option_texts(options, a.texts);
  try {
    options.validate();
  } catch (const OptionError& error) {
    // The message names the option first; say where it was set.
    const std::string message = error.what();
    const std::string name = message.substr(0, message.find_first_not_of("abcdefghijklmnopqrstuvwxyz_0123456789"));
    const auto text = a.texts.find(name);
    if (text != a.texts.end() && !text->second.empty()) throw UsageError(with_flag(name, message));
    if (lines.count(name)) throw UsageError(a.config + ", line " + std::to_string(lines.at(name)) + ": " + message);
    throw;
  }
  return options;
}

}  // namespace handhold
