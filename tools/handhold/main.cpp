// The handhold command line. Exit codes: 0 done (also with no handles), 1 failed, 2 wrong use. An error is one line.
#include <cstdio>
#include <exception>
#include <iostream>
#include <new>
#include <string>
#include <vector>

#include "atomic_file.h"
#include "backend.h"
#include "command_line.h"
#include "handhold/config.h"
#include "subcommand.h"
#include "usage_error.h"

namespace handhold {
namespace {

int run(int argc, char** argv) {
  CLI::App app("Finds the parts of objects that a robot hand can hold, in point clouds.", "handhold");
  app.allow_extras();
  app.require_subcommand(0, 1);
  bool version = false;
  app.add_flag("--version", version, "Print the version, and whether there is a GPU to search on, and exit");
  std::vector<Subcommand> subcommands = {add_localize(app), add_batch(app),    add_stream(app),
                                         add_plan(app),     add_simulate(app), add_evaluate(app)};
  for (const Subcommand& subcommand : add_experiments(app)) subcommands.push_back(subcommand);

  std::vector<std::string> arguments = join_lists({argv + 1, argv + argc});
  std::vector<std::string> reversed(arguments.rbegin(), arguments.rend());
  const Subcommand* chosen = nullptr;
  try {
    app.parse(reversed);
  } catch (const CLI::CallForHelp&) {
    std::string help = app.help();
    for (const Subcommand& subcommand : subcommands) {
      if (subcommand.app->parsed()) help = subcommand.app->help(full_name(*subcommand.app->get_parent()));
    }
    write_and_flush(stdout, help, "standard output");
    return 0;
  } catch (const CLI::ParseError& error) {
    for (const Subcommand& subcommand : subcommands) refuse_leftovers(*subcommand.app);
    refuse_leftovers(app);
    std::string message = error.what();
    // Every flag of ours that can lack something lacks its one value.
    const std::size_t jargon = message.find(": 1 required");
    if (jargon != std::string::npos) message = message.substr(0, jargon) + " needs a value";
    throw UsageError(message + "; see '--help'");
  }
  for (const Subcommand& subcommand : subcommands) {
    if (!subcommand.app->parsed()) continue;
    chosen = &subcommand;
    refuse_leftovers(*subcommand.app);
  }
  refuse_leftovers(app);
  if (version) {
    write_and_flush(stdout, "handhold " HANDHOLD_VERSION "\n" + device_line(), "standard output");
    return 0;
  }
  if (!chosen)
    throw UsageError("no subcommand given; for example 'handhold localize cloud.pcd', or see 'handhold --help'");
  return chosen->run();
}

/// One line, whatever a library put into its message.
int report(const char* message, int exit_code) {
  std::string line = std::string("handhold: error: ") + message;
  while (!line.empty() && (line.back() == '\n' || line.back() == ' ')) line.pop_back();
  for (char& c : line) {
    if (c == '\n' || c == '\r') c = ' ';
  }
  std::fprintf(stderr, "%s\n", line.c_str());
  return exit_code;
}

}  // namespace
}  // namespace handhold

int main(int argc, char** argv) {
  using namespace handhold;
  try {
    return run(argc, argv);
  } catch (const UsageError& error) {
    return report(error.what(), 2);
  } catch (const OptionError& error) {
    return report(error.what(), 2);
  } catch (const ConfigError& error) {
    return report(error.what(), 2);
  } catch (const std::bad_alloc&) {
    return report("out of memory; use a smaller cloud or fewer samples", 1);
  } catch (const std::exception& error) {
    return report(error.what(), 1);
  }
}
