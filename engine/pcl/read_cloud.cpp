#include <pcl/console/print.h>

#include <algorithm>
#include <cctype>
#include <mutex>
#include <new>
#include <string_view>

#include "file.h"
#include "handhold/io.h"
#include "pcd_header.h"
#include "readers.h"

namespace handhold {
namespace io {
namespace {

std::mutex& pcl_mutex() {
  static std::mutex mutex;
  return mutex;
}

Cloud read_known(const std::string& path) {
  const std::size_t size = checked_file_size(path);
  const std::string head = read_bytes(path, std::min<std::size_t>(size, 4096));
  if (looks_like_pcd(head)) return read_pcd(path, size);
  if (head.compare(0, 3, "ply") == 0 && head.size() > 3 && (head[3] == '\n' || head[3] == '\r')) {
    return read_ply(path, size);
  }
  if (head.compare(0, 4, "\x89PNG") == 0) {
    throw IoError("cannot read " + path +
                  " as a cloud: it is a PNG image; as a depth image it needs intrinsics and a unit");
  }
  throw IoError("cannot read " + path +
                ": it begins neither like a PCD nor like a PLY file; convert it to one of them");
}

}  // namespace

QuietPcl::QuietPcl() {
  pcl_mutex().lock();
  previous_ = pcl::console::getVerbosityLevel();
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
}

QuietPcl::~QuietPcl() {
  pcl::console::setVerbosityLevel(static_cast<pcl::console::VERBOSITY_LEVEL>(previous_));
  pcl_mutex().unlock();
}

}  // namespace io

Cloud read_cloud(const std::string& path) {
  try {
    return io::read_known(path);
  } catch (const IoError&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw IoError("not enough memory to read " + path + ": thin the cloud out");
  } catch (const std::exception& error) {
    std::string reason = error.what();
    std::replace_if(
        reason.begin(), reason.end(), [](unsigned char c) { return std::iscntrl(c) != 0; }, ' ');
    throw IoError("cannot read " + path + ": PCL says '" + reason + "'; write the file again");
  }
}

}  // namespace handhold
