#include "client/commands/document_file.h"

#include <array>
#include <utility>

#include "assets/base/assert.h"
#include "client/commands/command.h"
#include "client/exchange/bcf_file.h"
#include "client/exchange/topic_csv.h"
#include "client/exchange/topic_page.h"

namespace tandem::client {
namespace {

struct Ending {
  const char* text;
  DocumentFormat format;
  bool read;
};
constexpr std::array<Ending, 5> kEndings{{{".json", DocumentFormat::json, true},
                                          {".bcf", DocumentFormat::bcf, false},
                                          {".bcfzip", DocumentFormat::bcf, false},
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

Status writeTopics(const TopicFile& file, const std::vector<Topic>& topics) {
  ASSERT(file.format != DocumentFormat::json);
  const std::string name = file.sceneName.empty() ? "Review" : "Review of " + file.sceneName;
  if (file.format == DocumentFormat::csv) return writeFile(file.path, topicCsv(topics));
  if (file.format == DocumentFormat::html) return writeFile(file.path, topicPage(name, topics));
  return writeBcf(file.path, topics, file.version, name, file.sceneHash);
}

Result<BcfVersion> parseBcfVersion(const std::string& text) {
  if (text == "2.1") return BcfVersion::v2_1;
  if (text == "3.0") return BcfVersion::v3_0;
  return Error{"--bcf " + text + ": is neither 2.1 nor 3.0"};
}

}  // namespace tandem::client
