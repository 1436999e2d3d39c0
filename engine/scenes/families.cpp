// The list of families, and objects from it.
#include "handhold/families.h"

#include <cstdio>
#include <stdexcept>

#include "convex_hull.h"
#include "family_makers.h"

namespace handhold::sensor {
namespace {

const std::vector<FamilyMaker>& makers() {
  static const std::vector<FamilyMaker> all = [] {
    std::vector<FamilyMaker> list;
    for (const auto& group : {bottle_families(), kitchen_families(), tool_families(), cleaning_families(),
                              carried_families(), bow_families(), plain_families()}) {
      list.insert(list.end(), group.begin(), group.end());
    }
    return list;
  }();
  return all;
}

const FamilyMaker& maker(const std::string& name) {
  std::string known;
  for (const FamilyMaker& candidate : makers()) {
    if (candidate.family.name == name) return candidate;
    known += (known.empty() ? "" : ", ") + candidate.family.name;
  }
  throw std::invalid_argument("unknown family '" + name + "'; must be one of " + known);
}

std::string metres(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

/// Defaults with the given sizes, all in range.
Sizes complete(const Family& family, const Sizes& given) {
  Sizes sizes;
  for (const SizeRange& range : family.sizes) sizes[range.name] = range.value;
  for (const auto& [name, value] : given) {
    const SizeRange* range = nullptr;
    std::string known;
    for (const SizeRange& candidate : family.sizes) {
      if (candidate.name == name) range = &candidate;
      known += (known.empty() ? "" : ", ") + candidate.name;
    }
    if (!range) {
      throw std::invalid_argument("unknown size '" + name + "' of family '" + family.name + "'; must be one of " +
                                  known);
    }
    if (!(value >= range->low && value <= range->high)) {
      throw std::invalid_argument("size " + name + " of family '" + family.name + "' is " + metres(value) +
                                  " m; must be " + metres(range->low) + " to " + metres(range->high));
    }
    sizes[name] = value;
  }
  return sizes;
}

Shape make_shape(const std::string& name, const Sizes& sizes) {
  const FamilyMaker& m = maker(name);
  return m.make(complete(m.family, sizes));
}

}  // namespace

const std::vector<Family>& families() {
  static const std::vector<Family> all = [] {
    std::vector<Family> list;
    for (const FamilyMaker& m : makers()) list.push_back(m.family);
    return list;
  }();
  return all;
}

const Family& family(const std::string& name) {
  return maker(name).family;
}

Object make_object(const std::string& name, const Sizes& sizes) {
  Shape shape = make_shape(name, sizes);
  Object object;
  object.name = name;
  object.mesh = std::move(shape.mesh);
  object.parts = std::move(shape.parts);
  for (Part& part : object.parts) part.family = name;
  return object;
}

std::vector<Mesh> convex_pieces(const std::string& name, const Sizes& sizes) {
  std::vector<Mesh> pieces;
  for (const auto& points : make_shape(name, sizes).pieces) pieces.push_back(convex_hull(points));
  return pieces;
}

}  // namespace handhold::sensor
