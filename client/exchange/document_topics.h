#pragma once

// The topics of a document: its notes with their comments, verdicts on clashes, named views and measures, by
// id. Saved states, groups and names are no topics; a name that the session gave a part is used for it.

#include <span>
#include <string>
#include <vector>

#include "assets/document/document.h"
#include "assets/scene/scene.h"
#include "client/exchange/guid.h"
#include "client/exchange/topic.h"

namespace tandem::client {

/// What a document is about.
struct TopicSource {
  const document::Document& document;
  const assets::Scene& scene;
  const PartGuids& guids;               // of the scene
  std::span<const Pose> worldFromPart;  // one a part, as the session has them
  std::string sceneHash;                // hexadecimal digits
};

/// Without pictures. A note and a clash, whose entries hold no camera, get one that looks at them.
std::vector<Topic> topicsOf(const TopicSource& source);

/// The first sentence of a text, or what fits of it into a line.
std::string titleOf(const std::string& text);

}  // namespace tandem::client
