#pragma once

// A small scene, and a document with one entry of each kind that is exported as a topic.

#include <string>
#include <vector>

#include "client/exchange/document_topics.h"

namespace tandem::client {

struct TopicSample {
  assets::Scene scene;
  document::Document document;
  std::vector<Pose> worldFromPart;
  std::string sceneHash = std::string(64, 'a');

  TopicSample() {
    for (const char* name : {"Housing", "Shaft", "Impeller"}) {
      assets::Part part;
      part.name = name;
      part.mesh = 0;
      scene.parts.push_back(part);
      worldFromPart.push_back(
          {{0.1 * static_cast<double>(worldFromPart.size()), 0.0, 0.0}, {1.0, 0.0, 0.0, 0.0}});
    }
    scene.name = "Pump <1>";
    scene.meshes.resize(1);
    scene.meshes[0].bounds = {glm::dvec3(-0.05), glm::dvec3(0.05)};
    scene.bounds = {glm::dvec3(-0.05), {0.25, 0.05, 0.05}};
    add(document::Note{"The shaft is too long. Cut it by 2 mm & <check>",
                       1,
                       {0.01, 0.02, 0.03},
                       "Ben",
                       document::NoteStatus::inProgress});
    add(document::Comment{1, "=1+1 is what I measured"}, "Ben", 2000);
    add(document::Comment{1, "\"Done\", says Grüße"}, "Ada", 3000);
    add(document::ClashVerdict{0, 1, document::ClashStatus::reviewed, 0.0012, "Accept"});
    document::NamedView view;
    view.name = "From the left";
    view.worldFromCamera = {{1.0, 2.0, 3.0}, glm::angleAxis(0.7, glm::normalize(glm::dvec3(0.1, 1.0, 0.2)))};
    view.distance = 2.0;
    view.sections = {{{0.0, 0.1, 0.0}, {0.0, 1.0, 0.0}}};
    view.parts = {2};
    add(view);
    add(document::Measure{
        "", document::MeasureKind::distance, 0.1, {{0, {0.0, 0.0, 0.0}}, {1, {0.0, 0.0, 0.0}}}});
    add(document::Group{"no topic", {1}});
  }

  document::EntryId add(document::Body body, const std::string& author = "Ada", std::int64_t time = 1000) {
    document::By by{1, author, ++request_, time};
    const auto outcome = document.apply({0, 0, std::move(body)}, by);
    ASSERT(outcome.refusal == document::Refusal::none);
    return outcome.entry.id;
  }
  std::vector<Topic> topics() const {
    const PartGuids guids(scene);
    return topicsOf({document, scene, guids, worldFromPart, sceneHash});
  }

 private:
  std::uint32_t request_ = 0;
};

}  // namespace tandem::client
