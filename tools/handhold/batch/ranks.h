// Several processes that share a batch.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace handhold::batch {

/// The processes ("ranks") that one mpirun or srun started. Every member but rank and size is called by all of them, in
/// the same order; one thread of a process at a time.
class Ranks {
 public:
  /// Null when the program was started alone, or was built without MPI.
  static std::unique_ptr<Ranks> join();
  virtual ~Ranks() = default;

  virtual std::size_t rank() const = 0;
  virtual std::size_t size() const = 0;

  /// Each number from 0 on is given to one rank, as soon as it asks. Not a call of all together.
  virtual std::size_t draw() = 0;
  /// The texts of all ranks at rank 0, in their order; nothing at the others. While rank 0 waits it calls
  /// `waiting(rank)`, about ten times a second, with the first rank that has sent none. Should that rank be dead, it
  /// waits until the launcher ends the job, as mpirun does.
  virtual std::vector<std::string> gather(const std::string& text, const std::function<void(std::size_t)>& waiting) = 0;
  /// Does `work` at rank 0 first and, if that throws nothing, at the others. What it throws is thrown on, by ranks
  /// other than 0 as std::runtime_error that names the rank; at all the others the answer is false then.
  virtual bool first_then_others(const std::function<void()>& work) = 0;
};

/// As messages call it.
inline std::string name_of_rank(std::size_t rank) {
  return "rank " + std::to_string(rank);
}

}  // namespace handhold::batch
