// Objects that keep the memory they hold from frame to frame.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace handhold {

/// A vector whose elements are not destroyed: what `next` gives may hold what an earlier element left there, and its
/// vectors their memory. The caller fills it anew.
template <class T>
class Recycled {
 public:
  void clear() { size_ = 0; }
  T& next() {
    if (size_ == items_.size()) items_.emplace_back();
    return items_[size_++];
  }
  void drop_last() { --size_; }
  /// Those after it move up.
  void erase(std::size_t i) {
    std::rotate(items_.begin() + static_cast<std::ptrdiff_t>(i), items_.begin() + static_cast<std::ptrdiff_t>(i + 1),
                items_.begin() + static_cast<std::ptrdiff_t>(size_));
    --size_;
  }

  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  T& operator[](std::size_t i) { return items_[i]; }
  const T& operator[](std::size_t i) const { return items_[i]; }
  auto begin() { return items_.begin(); }
  auto end() { return items_.begin() + static_cast<std::ptrdiff_t>(size_); }
  auto begin() const { return items_.begin(); }
  auto end() const { return items_.begin() + static_cast<std::ptrdiff_t>(size_); }

 private:
  std::vector<T> items_;
  std::size_t size_ = 0;
};

/// The elements of vectors that come and go, for the next frame's.
template <class T>
class Spares {
 public:
  /// Keeps a vector's elements from the `first` on; it loses them.
  void take(std::vector<T>& from, std::size_t first = 0) {
    for (std::size_t i = first; i < from.size(); ++i) spares_.push_back(std::move(from[i]));
    from.erase(from.begin() + static_cast<std::ptrdiff_t>(first), from.end());
  }
  /// Appends an element that may hold anything.
  T& add(std::vector<T>& to) {
    if (spares_.empty()) return to.emplace_back();
    to.push_back(std::move(spares_.back()));
    spares_.pop_back();
    return to.back();
  }

 private:
  std::vector<T> spares_;
};

}  // namespace handhold
