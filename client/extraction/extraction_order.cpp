#include "client/extraction/extraction_order.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "assets/base/parallel.h"

namespace tandem::client {

namespace {

double lengthOf(const Extraction& extraction) {
  double length = 0.0;
  for (const ExtractionLeg& leg : extraction.way) length += leg.distance;
  return length;
}

/// Fewer pulls first, then shorter ways.
bool isEasier(const Extraction& a, const Extraction& b) {
  if (a.way.size() != b.way.size()) return a.way.size() < b.way.size();
  return lengthOf(a) < lengthOf(b);
}

}  // namespace

ExtractionOrder extractionOrder(PartExtractor& extractor, std::size_t parts,
                                const std::function<void(double)>& progress) {
  ExtractionOrder result;
  std::vector<Extraction> stuck;  // and how they were so when they were last tried
  for (std::size_t i = 0; i < parts; ++i)
    if (const auto part = static_cast<PartId>(i); extractor.canTake(part)) {
      stuck.push_back({});
      stuck.back().part = part;
    }
  const auto all = static_cast<double>(stuck.size());
  for (bool some = true; some && !stuck.empty();) {
    const auto tryAgain = [&](std::size_t i) {
      const std::vector<PartId>& by = stuck[i].blockedBy;
      const bool changed =
          by.empty() || std::any_of(by.begin(), by.end(), [&](PartId p) { return extractor.isAway(p); });
      // Where nothing has gone of what blocks a part, it is as stuck as before.
      if (changed) stuck[i] = extractor.extract(stuck[i].part);
    };
    const double left = static_cast<double>(stuck.size());
    parallelFor(stuck.size(), tryAgain,
                [&](std::size_t begun) { progress(1.0 - (left - 0.5 * static_cast<double>(begun)) / all); });
    std::vector<Extraction> out;
    std::copy_if(stuck.begin(), stuck.end(), std::back_inserter(out), [](const auto& e) { return e.free; });
    std::erase_if(stuck, [](const Extraction& e) { return e.free; });
    std::stable_sort(out.begin(), out.end(), isEasier);
    some = !out.empty();
    for (Extraction& extraction : out) {
      extractor.takeAway(extraction.part);
      result.order.push_back(extraction.part);
      result.parts.push_back(std::move(extraction));
    }
  }
  std::move(stuck.begin(), stuck.end(), std::back_inserter(result.parts));
  return result;
}

}  // namespace tandem::client
