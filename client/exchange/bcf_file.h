#pragma once

// A BCF archive (.bcf, .bcfzip): a zip with a folder for each topic.
//
// 1. An archive is written whole: a temporary file takes its name at the end.
// 2. An archive is read whole or not at all. Sizes are measured while unpacking, not believed; names with ..,
//    names twice and encrypted files refuse it. Pictures are not unpacked.

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "assets/base/result.h"
#include "client/exchange/bcf_parts.h"
#include "client/exchange/topic.h"

namespace tandem::client {

/// `project` is the session's name, and its id is made of `sceneHash`; version 3.0 alone states them.
Status writeBcf(const std::string& path, const std::vector<Topic>& topics, BcfVersion version,
                const std::string& project, const std::string& sceneHash);

/// The error is one line that names the file, the place and the reason.
Result<std::vector<Topic>> readBcf(const std::string& path);
/// The same of an archive's bytes; `source` names them in errors.
Result<std::vector<Topic>> readBcf(std::span<const std::byte> archive, const std::string& source);

}  // namespace tandem::client
