#pragma once

// Reads the XML files of a BCF archive, which are hostile: limits of depth, no document type, every number
// and text checked. Elements that are not known are passed over, as the format asks for.
//
// An error is the place and the reason, for who knows the file's name.

#include <optional>
#include <string>

#include "assets/base/result.h"
#include "client/exchange/bcf_parts.h"
#include "client/exchange/topic.h"

namespace tandem::client {

Result<BcfVersion> readBcfVersion(const std::string& xml);

struct BcfMarkup {
  Topic topic;
  std::string viewpointFile;  // of its first viewpoint; empty: it has none
};
/// Texts come in one line and without what cannot be shown, cut to what the document takes.
Result<BcfMarkup> readBcfMarkup(const std::string& xml, BcfVersion version);
/// Nothing if it has no camera. An orthogonal camera is read as one in perspective at its place.
Result<std::optional<TopicView>> readBcfViewpoint(const std::string& xml);

}  // namespace tandem::client
