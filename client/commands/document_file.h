#pragma once

// The files to which `tandem document` takes a session's document, by their endings.

#include <string>
#include <vector>

#include "assets/base/result.h"
#include "client/exchange/document_topics.h"

namespace tandem::client {

enum class DocumentFormat : std::uint8_t { json, csv, html };

/// The format of a file by its ending, if it can be written, or read for an import.
Result<DocumentFormat> documentFormat(const std::string& path, bool imports);

/// Writes topics in any format but JSON, which holds the whole document.
Status writeTopics(const std::string& path, DocumentFormat format, const std::vector<Topic>& topics,
                   const std::string& sceneName);

}  // namespace tandem::client
