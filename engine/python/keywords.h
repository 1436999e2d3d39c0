// Options from Python's keyword arguments, by the names of the one table that TOML and the command line have, too.
#pragma once

#include <pybind11/pybind11.h>

#include <string>
#include <vector>

#include "handhold/options.h"

namespace handhold::python {

/// Options of `hand=`, `config=` and options by name: keywords win over the file, which wins over the hand.
/// @param others  keywords that the caller has beside these, for "did you mean"
/// @throws OptionError, also for a file that cannot be read or used
Options to_options(const pybind11::kwargs& keywords, const std::vector<std::string>& others = {});

/// Every option by its name, as Python values; None where the method decides.
pybind11::dict to_dict(const Options& options);

/// "hand=None, config=None, method='default', ...": the keywords of to_options() for a signature.
std::string keyword_signature();
/// A line for every option with its unit and meaning, for a docstring.
std::string keyword_help();

}  // namespace handhold::python
