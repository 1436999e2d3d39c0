// With MPI: work is handed out by a counter in rank 0's memory that all ranks raise themselves.
#define OMPI_SKIP_MPICXX
#define MPICH_SKIP_MPICXX
#include <mpi.h>

#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <stdexcept>
#include <string>
#include <thread>

#include "ranks.h"

namespace handhold::batch {
namespace {

/// Set by the launchers of Open MPI, MPICH and Slurm's PMI for each process they start.
constexpr const char* kLaunched[] = {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_RANK"};

class MpiRanks : public Ranks {
 public:
  MpiRanks() {
    int provided = 0;
    MPI_Init_thread(nullptr, nullptr, MPI_THREAD_SERIALIZED, &provided);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &size_);
    const MPI_Aint bytes = rank_ == 0 ? static_cast<MPI_Aint>(sizeof *counter_) : 0;
    MPI_Win_allocate(bytes, sizeof *counter_, MPI_INFO_NULL, MPI_COMM_WORLD, &counter_, &window_);
    if (rank_ == 0) {
      MPI_Win_lock(MPI_LOCK_EXCLUSIVE, 0, 0, window_);
      *counter_ = 0;
      MPI_Win_unlock(0, window_);
    }
    MPI_Barrier(MPI_COMM_WORLD);
    MPI_Win_lock_all(0, window_);
  }
  ~MpiRanks() override {
    MPI_Win_unlock_all(window_);
    MPI_Win_free(&window_);
    MPI_Finalize();
  }
  MpiRanks(const MpiRanks&) = delete;
  MpiRanks& operator=(const MpiRanks&) = delete;

  std::size_t rank() const override { return static_cast<std::size_t>(rank_); }
  std::size_t size() const override { return static_cast<std::size_t>(size_); }

  std::size_t draw() override {
    const std::int64_t one = 1;
    std::int64_t drawn = 0;
    MPI_Fetch_and_op(&one, &drawn, MPI_INT64_T, 0, 0, MPI_SUM, window_);
    MPI_Win_flush(0, window_);
    return static_cast<std::size_t>(drawn);
  }

  std::vector<std::string> gather(const std::string& text, const std::function<void(std::size_t)>& waiting) override {
    if (rank_ != 0) {
      MPI_Send(text.data(), static_cast<int>(text.size()), MPI_CHAR, 0, kTag, MPI_COMM_WORLD);
      return {};
    }
    std::vector<std::string> texts = {text};
    for (int other = 1; other < size_; ++other) {
      MPI_Status status;
      int there = 0;
      // MPI_Probe would keep a core busy that the others may need.
      for (int tries = 1;; ++tries) {
        MPI_Iprobe(other, kTag, MPI_COMM_WORLD, &there, &status);
        if (there) break;
        if (tries % 20 == 0) waiting(static_cast<std::size_t>(other));
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
      }
      int length = 0;
      MPI_Get_count(&status, MPI_CHAR, &length);
      std::string theirs(static_cast<std::size_t>(length), '\0');
      MPI_Recv(theirs.data(), length, MPI_CHAR, other, kTag, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
      texts.push_back(std::move(theirs));
    }
    return texts;
  }

  bool first_then_others(const std::function<void()>& work) override {
    std::exception_ptr problem;
    int good = 1;
    const auto attempt = [&] {
      try {
        work();
      } catch (const std::exception& error) {
        problem = rank_ == 0 ? std::current_exception()
                             : std::make_exception_ptr(std::runtime_error(name_of_rank(rank()) + ": " + error.what()));
        good = 0;
      }
    };
    if (rank_ == 0) attempt();
    MPI_Bcast(&good, 1, MPI_INT, 0, MPI_COMM_WORLD);
    if (good && rank_ != 0) attempt();
    int all_good = 0;
    MPI_Allreduce(&good, &all_good, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD);
    if (problem) std::rethrow_exception(problem);
    return all_good != 0;
  }

 private:
  static constexpr int kTag = 1;

  int rank_ = 0, size_ = 1;
  std::int64_t* counter_ = nullptr;  ///< at rank 0
  MPI_Win window_ = MPI_WIN_NULL;
};

}  // namespace

std::unique_ptr<Ranks> Ranks::join() {
  for (const char* name : kLaunched) {
    if (std::getenv(name)) return std::make_unique<MpiRanks>();
  }
  return nullptr;
}

}  // namespace handhold::batch
