// Which of several explanations of one place stays.
#pragma once

#include <vector>

#include "part_check.h"

namespace handhold {

/// Of parts on the same place the likeliest one stays, of sure ones the longest; pieces of one part become one.
/// `all`: the candidates; their order and what they hold are lost. `continue_parts`: also pieces on one line that
/// clutter or noise parts. `likely`: scratch. `kept`: what stays, best first.
void resolve_parts(std::vector<PartCandidate>& all, bool continue_parts, std::vector<PartCandidate>& likely,
                   std::vector<PartCandidate>& kept);

}  // namespace handhold
