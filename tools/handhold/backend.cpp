#include "backend.h"

#include <cstdio>

#include "handhold/config.h"
#include "handhold/device.h"
#include "usage_error.h"

namespace handhold {

Localizer make_localizer(const OptionArguments& a, const Options& options) {
  try {
    return Localizer(options);
  } catch (const OptionError& error) {
    // As effective_options(), which does not look for a GPU.
    const auto text = a.texts.find("backend");
    if (text != a.texts.end() && !text->second.empty()) throw UsageError(with_flag("backend", error.what()));
    if (a.config.empty()) throw;
    Options read;
    const ConfigLines lines = apply_toml_file(read, a.config);
    if (!lines.count("backend")) throw;
    throw UsageError(a.config + ", line " + std::to_string(lines.at("backend")) + ": " + error.what());
  }
}

void note_backend(const Localizer& localizer) {
  const std::string& reason = localizer.backend_reason();
  if (!reason.empty()) std::fprintf(stderr, "note: backend = auto: on the CPU: %s\n", reason.c_str());
}

std::string backend_line(const Localizer& localizer) {
  const Backend asked = localizer.options().backend;
  if (asked == Backend::kCpu) return {};
  const std::string option = "(backend = " + std::string(to_string(asked)) + "): ";
  return localizer.backend() == Backend::kCuda ? "searched on the GPU " + option + cuda_device().name + "\n"
                                               : "searched on the CPU " + option + localizer.backend_reason() + "\n";
}

std::string device_line() {
  const CudaDevice device = cuda_device();
  return "cuda: " + (device.available ? device.name : "none: " + device.reason) + "\n";
}

}  // namespace handhold
