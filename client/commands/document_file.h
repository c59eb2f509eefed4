#pragma once

// The files to which `tandem document` takes a session's document, by their endings.

#include <functional>
#include <string>
#include <vector>

#include "assets/base/result.h"
#include "client/exchange/bcf_parts.h"
#include "client/exchange/document_topics.h"

namespace tandem::client {

enum class DocumentFormat : std::uint8_t { json, bcf, csv, html };

/// The format of a file by its ending, if it can be written, or read for an import.
Result<DocumentFormat> documentFormat(const std::string& path, bool imports);

struct TopicFile {
  std::string path;
  DocumentFormat format = DocumentFormat::bcf;  // any but JSON, which holds the whole document
  BcfVersion version = BcfVersion::v3_0;
  std::string sceneName, sceneHash;  // of the session
};
Status writeTopics(const TopicFile& file, const std::vector<Topic>& topics);

/// Draws a picture of each topic's view. `progress` is called with the share done.
Status drawTopics(std::vector<Topic>& topics, const TopicSource& source,
                  const std::function<void(double)>& progress);

/// The version that --bcf names.
Result<BcfVersion> parseBcfVersion(const std::string& text);

}  // namespace tandem::client
