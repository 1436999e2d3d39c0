// handhold experiment: the paper's experiments on simulated scenes.
#include "experiments.h"

#include "kernels.h"
#include "usage_error.h"

namespace handhold {

std::vector<Subcommand> add_experiments(CLI::App& parent) {
  CLI::App* app = parent.add_subcommand("experiment", "Repeat an experiment of the paper on simulated scenes");
  app->allow_extras();
  app->require_subcommand(0, 1);
  const auto nothing_chosen = []() -> int {
    throw UsageError(
        "no experiment given; for example 'handhold experiment fig9', or see 'handhold experiment --help'");
  };
  std::vector<Subcommand> subcommands = {{app, nothing_chosen}};
  for (const Subcommand& experiment :
       {experiments::add_fig8(*app), experiments::add_fig9(*app), experiments::add_axis(*app),
        experiments::add_density(*app), experiments::add_tracking(*app), experiments::add_table1(*app),
        experiments::add_table2(*app)}) {
    subcommands.push_back({experiment.app, [experiment] {
                             if (const char* problem = kernels::isa_error()) throw UsageError(problem);
                             return experiment.run();
                           }});
  }
  return subcommands;
}

}  // namespace handhold
