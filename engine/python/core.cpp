// handhold._core: the localizer, its options and results, the tracker.
#include <pybind11/pybind11.h>

#include "handhold/config.h"
#include "keywords.h"
#include "localizer.h"
#include "numpy_views.h"
#include "public_names.h"
#include "results.h"

PYBIND11_MODULE(_core, m) {
  namespace py = pybind11;
  using namespace handhold::python;
  py::options docstrings;
  docstrings.disable_function_signatures();  // ours follow Python's own rule for built-in functions

  translate_errors();
  bind_results(m);
  bind_localizer(m);
  bind_tracker(m);
  m.def(
      "to_toml", [](const py::kwargs& keywords) { return handhold::to_toml(to_options(keywords)); },
      ("to_toml(*, " + keyword_signature() +
       ")\n--\n\n"
       "All options as the text of a TOML file, each with its unit and meaning; config=PATH reads it again, as the\n"
       "command line's --config does.")
          .c_str());
  m.attr("__version__") = HANDHOLD_VERSION;
  make_public(m, "handhold");
}
