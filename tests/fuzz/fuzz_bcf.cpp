// A BCF archive that somebody else wrote. The first byte chooses: the rest is the archive, or it is the XML
// of a markup, of its viewpoint, of the next markup, ... each ended by a zero, so that mutations reach behind
// the checksums of a zip. What is read becomes sound entries of a session's document, the same again changes
// nothing, and it can be written and read again.

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <map>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "assets/document/entry_check.h"
#include "client/exchange/bcf_file.h"
#include "client/exchange/bcf_reader.h"
#include "client/exchange/bcf_writer.h"
#include "client/exchange/topic_changes.h"
#include "sync/wire/document_codec.h"

namespace {

using namespace tandem;
using namespace tandem::client;

/// A session with an entry of each kind that is a topic.
struct Review {
  assets::Scene scene;
  document::Document document;
  std::vector<Pose> worldFromPart;

  Review() {
    for (const char* name : {"Housing", "Shaft", "Impeller"}) {
      assets::Part part;
      part.name = name;
      scene.parts.push_back(part);
      worldFromPart.push_back({});
    }
    scene.bounds = {glm::dvec3(-0.05), glm::dvec3(0.25, 0.05, 0.05)};
    document::NamedView view;
    view.name = "From the left";
    view.distance = 2.0;
    put(document::Note{"too long", 1, {0.01, 0.02, 0.03}, "Ben", document::NoteStatus::inProgress});
    put(document::Comment{1, "cut it"});
    put(document::ClashVerdict{0, 1, document::ClashStatus::reviewed, 0.0012, "Accept"});
    put(view);
    put(document::Measure{"", document::MeasureKind::distance, 0.1, {{0, {}}, {1, {}}}});
  }

 private:
  void put(document::Body body) {
    const document::By by{1, "Ada", ++request_, 1000};
    if (document.apply({0, 0, std::move(body)}, by).refusal != document::Refusal::none) std::abort();
  }
  std::uint32_t request_ = 0;
};

TopicChanges changesOf(const Review& review, const std::vector<Topic>& topics) {
  static const PartGuids guids(review.scene);
  const TopicSource there{review.document, review.scene, guids, review.worldFromPart, std::string(64, 'a')};
  return client::changesOf(topics, there, "Ben");
}

constexpr std::int64_t kAfterAnyFile = 253402300800;  // Unix time, s: the year 10000

/// GUIDs of entries are made of this time, so that no file has those of the entries that it makes.
std::int64_t timeOf(const std::vector<Topic>& topics) {
  std::uint64_t hash = 0;
  for (const Topic& topic : topics)
    for (const std::string* text : {&topic.guid, &topic.title, &topic.description, &topic.author})
      hash = hash * 31 + std::hash<std::string>()(*text);
  return kAfterAnyFile + static_cast<std::int64_t>(hash % (1u << 30));
}

/// Every change is sound and accepted, and the same topics again change nothing.
void bringIn(const std::vector<Topic>& topics) {
  static const Review before;
  Review review = before;
  std::map<document::EntryId, document::EntryId> made;  // by the id that the changes have
  document::By by{2, "Ben", 0, timeOf(topics)};
  for (const document::Entry& entry : changesOf(review, topics).entries) {
    if (!document::check(entry.body)) std::abort();
    document::Body body = entry.body;
    if (auto* comment = std::get_if<document::Comment>(&body))
      if (const auto note = made.find(comment->note); note != made.end()) comment->note = note->second;
    ++by.request;
    const bool known = entry.revision != 0;
    const auto outcome = review.document.apply({known ? entry.id : 0, entry.revision, body}, by);
    if (outcome.refusal != document::Refusal::none) std::abort();
    if (!known) made[entry.id] = outcome.entry.id;
  }
  for (const document::Entry& entry : changesOf(review, topics).entries) {
    const document::Entry* old = entry.revision == 0 ? nullptr : review.document.find(entry.id);
    if (old == nullptr || sync::encodeBody(old->body) != sync::encodeBody(entry.body)) std::abort();
  }
}

void writeAndReadAgain(const Topic& topic, BcfVersion version) {
  const auto back = readBcfMarkup(bcfMarkupXml(topic, version), version);
  if (!back || back->topic.guid != topic.guid || back->topic.comments.size() != topic.comments.size())
    std::abort();
  if (!topic.view) return;
  const auto view = readBcfViewpoint(bcfViewpointXml(*topic.view, version));
  if (!view || !*view || (*view)->selected != topic.view->selected) std::abort();
}

std::vector<Topic> topicsOf(std::span<const std::uint8_t> texts, BcfVersion version) {
  std::vector<Topic> topics;
  std::set<std::string> guids;  // an archive has none twice
  for (bool isMarkup = true; !texts.empty(); isMarkup = !isMarkup) {
    const auto end = std::find(texts.begin(), texts.end(), std::uint8_t{0});
    const std::string xml(texts.begin(), end);
    texts = texts.subspan(std::min<std::size_t>(xml.size() + 1, texts.size()));
    if (isMarkup) {
      Result<BcfMarkup> markup = readBcfMarkup(xml, version);
      if (!markup || !guids.insert(markup->topic.guid).second) return topics;
      topics.push_back(std::move(markup->topic));
    } else if (auto view = readBcfViewpoint(xml)) {
      topics.back().view = std::move(*view);
    }
  }
  return topics;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::span<const std::uint8_t> rest(data + 1, size - 1);
  const BcfVersion version = data[0] % 3 == 1 ? BcfVersion::v2_1 : BcfVersion::v3_0;
  std::vector<Topic> topics;
  if (data[0] % 3 == 0) {
    if (auto read = readBcf(std::as_bytes(rest), "review.bcf")) topics = std::move(*read);
  } else {
    topics = topicsOf(rest, version);
  }
  for (const Topic& topic : topics) writeAndReadAgain(topic, version);
  bringIn(topics);
  return 0;
}
