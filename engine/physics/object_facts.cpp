// What the paper's objects weigh: the paper does not say.
#include "handhold/physics.h"

namespace handhold::physics {

const std::vector<ObjectFacts>& paper_objects() {
  // Rubber on smooth plastic slides at about 0.8 to 0.9, on bare wood and soft grips at 0.9, on glazed or wet-look
  // surfaces a little less.
  static const std::vector<ObjectFacts> objects = {
      {"blue_bottle", 0.12, 0.8, "a detergent bottle, emptied: about 0.1 kg of smooth polyethylene and what is left"},
      {"purex_bottle", 0.15, 0.8, "a 1.5 l laundry detergent bottle with its handle, emptied: its walls are thicker"},
      {"all_bottle", 0.15, 0.8, "as the other laundry detergent bottle, emptied"},
      {"carrying_case", 0.8, 0.85, "a hard plastic case with a set of small tools left in it; ribbed handle"},
      {"brush_1", 0.12, 0.85, "a dish brush: a plastic handle and a head of bristles"},
      {"pot", 0.9, 0.8, "a small saucepan of thin steel without its lid; smooth plastic on the handle"},
      {"plunger", 0.35, 0.9, "a wooden rod of 0.1 kg and a rubber cup of 0.25 kg; bare wood"},
      {"sprayer", 0.1, 0.8, "a spray bottle, emptied: 0.06 kg of bottle and 0.04 kg of trigger"},
      {"dust_pan", 0.2, 0.85, "a plastic dust pan of 20 by 23 cm with walls of 2 to 3 mm"},
      {"brush_2", 0.2, 0.85, "a counter brush: a wooden or plastic block, long bristles and a handle"},
      {"sponge", 0.1, 0.85, "a dish sponge on a hollow handle with some soap in it"},
      {"lint_roller", 0.15, 0.85, "a plastic handle, a wire and a roll of adhesive paper"},
  };
  return objects;
}

}  // namespace handhold::physics
