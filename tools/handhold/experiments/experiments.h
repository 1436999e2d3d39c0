// The experiments of the paper, each a subcommand of `handhold experiment`.
#pragma once

#include "subcommand.h"

namespace handhold::experiments {

/// Run time by stage (Fig. 8).
Subcommand add_fig8(CLI::App& parent);
/// Handles found by sampling strategy (Fig. 9).
Subcommand add_fig9(CLI::App& parent);
/// The quadric's axis against the alternatives of section 3.1.
Subcommand add_axis(CLI::App& parent);
/// What fewer points per area cost.
Subcommand add_density(CLI::App& parent);
/// What a tracker finds with few samples.
Subcommand add_tracking(CLI::App& parent);
/// Single objects grasped in physics (Table 1).
Subcommand add_table1(CLI::App& parent);
/// A table cleared in physics (Table 2).
Subcommand add_table2(CLI::App& parent);

}  // namespace handhold::experiments
