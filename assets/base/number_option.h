#pragma once

// A number on a command line, as both programs check it.

#include <functional>
#include <string>

namespace tandem::assets {

/// A check for a command-line option: empty if its text is a number from `least` to `most`, else what is wrong with it.
/// Never lets nan through, which passes through CLI11's own check.
std::function<std::string(const std::string&)> numberFrom(double least, double most);

}  // namespace tandem::assets
