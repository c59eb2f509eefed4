#pragma once

// What can be measured of one or two places on parts, as the session's document keeps it. The arithmetic is
// that of `tandem check --measure` and `--distance` (client/review); this room only chooses and names.

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "assets/document/entry.h"
#include "client/review/clash_check.h"
#include "client/review/measure.h"

namespace tandem::client {

/// What a figure says. Several are of one kind in the document.
enum class FigureKind : std::uint8_t {
  length,    // of the edge nearest to the first place
  diameter,  // of the cylinder whose side the first place is on
  distance,  // from the first place to the second
  across,    // of two parallel faces, two parallel axes, or of an axis and a face along it
  angle,     // of two faces, two axes, or a face and an axis
  clearance  // of the two parts; negative: how deep they stand in each other
};
inline constexpr std::array<const char*, 6> kFigureNames{"length", "diameter", "distance",
                                                         "across", "angle",    "clearance"};
/// How many places, or parts, it takes.
constexpr std::size_t placesOf(FigureKind kind) { return kind <= FigureKind::diameter ? 1 : 2; }

struct Figure {
  FigureKind kind = FigureKind::distance;
  double value = 0.0;            // m, of an angle rad
  std::vector<glm::dvec3> line;  // m, world: two points that it lies between, or one
  std::vector<PartId> parts;     // of each point of the line
  bool atLeast = false;          // a clearance below 0 of an open shell: at least so deep
};

/// The clearance of two parts in the figure's sign.
Figure clearanceFigure(const Clash& parts);
/// All that one place or two say, world frame; with `parts` their clearance. In the order of FigureKind.
std::vector<Figure> figuresOf(std::span<const MeasuredPlace> places, const std::optional<Clash>& parts);

/// The figure for the document; its anchors are carried by the parts, which stand at these poses. Without a
/// name it gets those of its parts.
document::Measure toMeasure(const Figure& figure, const assets::Scene& scene,
                            std::span<const Pose> worldFromPart, std::string name = {});

/// "30.2000 mm", "1.20000 m", "45.000 deg".
std::string quantityInWords(document::MeasureKind kind, double value);
document::MeasureKind documentKind(FigureKind kind);
/// The place in words: where it is, which way it faces, and the axis of its cylinder.
std::vector<std::string> placeInWords(const MeasuredPlace& place);

}  // namespace tandem::client
