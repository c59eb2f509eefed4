#include "client/commands/document_file.h"

#include <array>
#include <utility>

#include "assets/base/assert.h"
#include "client/commands/command.h"
#include "client/exchange/topic_csv.h"
#include "client/exchange/topic_page.h"

namespace tandem::client {
namespace {

struct Ending {
  const char* text;
  DocumentFormat format;
  bool read;
};
constexpr std::array<Ending, 3> kEndings{{{".json", DocumentFormat::json, true},
                                          {".csv", DocumentFormat::csv, false},
                                          {".html", DocumentFormat::html, false}}};

}  // namespace

Result<DocumentFormat> documentFormat(const std::string& path, bool imports) {
  std::string possible;
  for (const Ending& ending : kEndings) {
    if (imports && !ending.read) continue;
    if (path.ends_with(ending.text)) return ending.format;
    possible += (possible.empty() ? "" : ", ") + std::string(ending.text);
  }
  return Error{path + ": cannot be " + (imports ? "read" : "written") + " by its ending; possible are " +
               possible};
}

Status writeTopics(const std::string& path, DocumentFormat format, const std::vector<Topic>& topics,
                   const std::string& sceneName) {
  ASSERT(format != DocumentFormat::json);
  if (format == DocumentFormat::csv) return writeFile(path, topicCsv(topics));
  return writeFile(path, topicPage(sceneName.empty() ? "Review" : "Review of " + sceneName, topics));
}

}  // namespace tandem::client
