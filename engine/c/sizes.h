// Structs of the C interface grow at their end: how one of another age than the library is read and written.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>

#include "handhold/handhold.h"

namespace handhold::c {

/// Size of the struct as it was in the first version that had it: up to and with its last field then. Never changes.
template <class T>
constexpr std::size_t first_size();
#define HANDHOLD_FIRST_VERSION_ENDS_WITH(type, field)              \
  template <>                                                      \
  constexpr std::size_t first_size<type>() {                       \
    return offsetof(type, field) + sizeof(decltype(type{}.field)); \
  }
HANDHOLD_FIRST_VERSION_ENDS_WITH(handhold_cloud, viewpoint)
HANDHOLD_FIRST_VERSION_ENDS_WITH(handhold_frame, finite_points)
HANDHOLD_FIRST_VERSION_ENDS_WITH(handhold_handle, affordance_count)
HANDHOLD_FIRST_VERSION_ENDS_WITH(handhold_affordance, reserved)
HANDHOLD_FIRST_VERSION_ENDS_WITH(handhold_funnel, in_handles)
HANDHOLD_FIRST_VERSION_ENDS_WITH(handhold_times, total)
#undef HANDHOLD_FIRST_VERSION_ENDS_WITH

/// Whether `size` may be that of some version of T. No struct will ever come near the upper end: a size beyond it is a
/// number that was not meant as one.
template <class T>
bool plausible_size(std::size_t size) noexcept {
  return size >= first_size<T>() && size <= 4096;
}

/// The caller's struct, missing fields zero. False when its size is none, or it has fields set that are unknown here.
template <class T>
bool read_struct(const T* from, std::size_t size, T& value) noexcept {
  if (!plausible_size<T>(size)) return false;
  const auto* bytes = reinterpret_cast<const unsigned char*>(from);
  if (std::any_of(bytes + std::min(size, sizeof value), bytes + size, [](unsigned char byte) { return byte != 0; })) {
    return false;
  }
  value = {};
  std::memcpy(&value, from, std::min(size, sizeof value));
  return true;
}

/// The index-th element of the caller's array, whose elements have `size` bytes. The size was checked.
template <class T>
void write_struct(const T& value, T* to, std::size_t index, std::size_t size) noexcept {
  unsigned char* bytes = reinterpret_cast<unsigned char*>(to) + index * size;
  const std::size_t known = std::min(size, sizeof value);
  std::memcpy(bytes, &value, known);
  std::memset(bytes + known, 0, size - known);
}

}  // namespace handhold::c
