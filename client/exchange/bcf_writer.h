#pragma once

// The XML files of a BCF archive, valid by the schemas of buildingSMART (github.com/buildingSMART/BCF-XML,
// release_2_1 and release_3_0): elements in their order, with all that must be there.

#include <string>
#include <vector>

#include "client/exchange/bcf_parts.h"
#include "client/exchange/topic.h"

namespace tandem::client {

std::string bcfVersionXml(BcfVersion version);
/// The names of the files that a topic's markup refers to.
inline constexpr const char* kViewpointFile = "viewpoint.bcfv";
inline constexpr const char* kSnapshotFile = "snapshot.png";
std::string bcfMarkupXml(const Topic& topic, BcfVersion version);
/// Version 2.1 allows a field of view from 45 to 60 degrees only; the nearest to the view's is written.
std::string bcfViewpointXml(const TopicView& view, BcfVersion version);
/// Of version 3.0 only: the values that topics have for type, status and people.
std::string bcfExtensionsXml(const std::vector<Topic>& topics);
/// Of version 3.0 only.
std::string bcfProjectXml(const std::string& id, const std::string& name);

}  // namespace tandem::client
