// What every subcommand gives to main.cpp.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <vector>

namespace handhold {

struct Subcommand {
  CLI::App* app = nullptr;   ///< knows the flags; owned by the parent
  std::function<int()> run;  ///< does the work after the flags were parsed; returns the exit code or throws
};

/// `handhold localize`: from a cloud to handles.
Subcommand add_localize(CLI::App& parent);
/// `handhold batch`: the same for many clouds.
Subcommand add_batch(CLI::App& parent);
/// `handhold stream`: frame after frame.
Subcommand add_stream(CLI::App& parent);
/// `handhold plan`: from a cloud to grasps of an arm.
Subcommand add_plan(CLI::App& parent);
/// `handhold simulate`: from scenes to clouds and truth.
Subcommand add_simulate(CLI::App& parent);
/// `handhold evaluate`: results against the truth.
Subcommand add_evaluate(CLI::App& parent);
/// `handhold experiment` and its own subcommands, which come after it.
std::vector<Subcommand> add_experiments(CLI::App& parent);

}  // namespace handhold
