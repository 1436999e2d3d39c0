// Without MPI every process is alone.
#include "ranks.h"

namespace handhold::batch {

std::unique_ptr<Ranks> Ranks::join() {
  return nullptr;
}

}  // namespace handhold::batch
