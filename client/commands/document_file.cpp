#include "client/commands/document_file.h"

#include <array>
#include <utility>

#include "assets/base/assert.h"
#include "client/commands/command.h"
#include "client/exchange/bcf_file.h"
#include "client/exchange/topic_csv.h"
#include "client/exchange/topic_page.h"
#include "client/viewer/still_pictures.h"

namespace tandem::client {
namespace {

struct Ending {
  const char* text;
  DocumentFormat format;
  bool read;
};
constexpr std::array<Ending, 5> kEndings{{{".json", DocumentFormat::json, true},
                                          {".bcf", DocumentFormat::bcf, true},
                                          {".bcfzip", DocumentFormat::bcf, true},
                                          {".csv", DocumentFormat::csv, false},
                                          {".html", DocumentFormat::html, false}}};

constexpr int kPictureWidth = 960, kPictureHeight = 600;  // pixels

Still stillOf(const Topic& topic, const PartGuids& guids) {
  const TopicView& view = *topic.view;
  const auto parts = [&](const std::vector<std::string>& wanted) {
    std::vector<PartId> found;
    for (const std::string& guid : wanted)
      if (const PartId part = guids.part(guid); part != kNoPart) found.push_back(part);
    return found;
  };
  Still still;
  still.worldFromEye = view.worldFromCamera;
  still.fieldOfView = view.fieldOfView;
  still.sections = view.sections;
  still.onlyThese = view.onlyThese;
  still.parts = parts(view.exceptions);
  still.marked = parts(view.selected);
  if (topic.kind != TopicKind::view) still.places = topic.places;
  still.lines = view.lines;
  return still;
}

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

Status drawTopics(std::vector<Topic>& topics, const TopicSource& source,
                  const std::function<void(double)>& progress) {
  if (topics.empty()) return {};
  const Result<std::unique_ptr<StillPictures>> pictures =
      StillPictures::open(source.scene, kPictureWidth, kPictureHeight);
  if (!pictures)
    return Error{"pictures cannot be drawn: " + pictures.error().message +
                 " (--no-pictures leaves them out)"};
  for (std::size_t i = 0; i < topics.size(); ++i) {
    progress(static_cast<double>(i) / static_cast<double>(topics.size()));
    if (!topics[i].view) continue;
    topics[i].view->aspect = static_cast<double>(kPictureWidth) / kPictureHeight;
    topics[i].picture = (*pictures)->draw(stillOf(topics[i], source.guids), source.worldFromPart);
  }
  return {};
}

Result<BcfVersion> parseBcfVersion(const std::string& text) {
  if (text == "2.1") return BcfVersion::v2_1;
  if (text == "3.0") return BcfVersion::v3_0;
  return Error{"--bcf " + text + ": is neither 2.1 nor 3.0"};
}

}  // namespace tandem::client
