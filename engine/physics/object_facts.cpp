// What the paper's objects weigh: the paper does not say.
#include "handhold/physics.h"

namespace handhold::physics {

const std::vector<ObjectFacts>& paper_objects() {
  // Rubber slides on smooth plastic at about 0.8, on rough plastic and on wood at 0.85 to 0.9.
  static const std::vector<ObjectFacts> objects = {
      {"blue_bottle", 0.12, 0.8, "0.05 kg of polyethylene, a 0.8 mm wall, and a little left in a bottle of 0.7 l"},
      {"purex_bottle", 0.15, 0.8, "a laundry detergent bottle of 2.8 l, emptied: a 0.9 mm wall of polyethylene"},
      {"all_bottle", 0.15, 0.8, "a laundry detergent bottle of 2.6 l, emptied: a 0.9 mm wall of polyethylene"},
      {"carrying_case", 0.8, 0.85, "0.5 kg of polypropylene, a 2.5 mm wall, and some small tools; ribbed handle"},
      {"brush_1", 0.12, 0.85, "a dish brush: a solid plastic handle and a head of bristles"},
      {"pot", 0.7, 0.8, "a pot of 18 cm without its lid: 2 mm of aluminium, and two handles of smooth plastic"},
      {"plunger", 0.35, 0.9, "a wooden rod of 0.1 kg and a rubber cup of 0.25 kg; bare wood"},
      {"sprayer", 0.1, 0.8, "a bottle of 0.7 l, emptied: 0.06 kg of bottle and 0.04 kg of trigger"},
      {"dust_pan", 0.2, 0.85, "plastic of 2.5 mm, 20 by 23 cm, with its handle"},
      {"brush_2", 0.2, 0.85, "a counter brush: a wooden block and handle, and long bristles"},
      {"sponge", 0.1, 0.85, "a dish sponge on a hollow handle with some soap in it"},
      {"lint_roller", 0.15, 0.85, "a plastic handle, a wire and a roll of adhesive paper"},
  };
  return objects;
}

}  // namespace handhold::physics
