#include "client/findings/figures.h"

#include <array>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "assets/base/assert.h"
#include "assets/base/printable.h"

namespace tandem::client {

namespace {

std::string formatted(const char* pattern, ...) {
  std::array<char, 160> text{};
  std::va_list values;
  va_start(values, pattern);
  std::vsnprintf(text.data(), text.size(), pattern, values);
  va_end(values);
  return text.data();
}

Figure lengthFigure(const MeasuredPlace& place) {
  const MeasuredEdge& edge = *place.edge;
  if (glm::distance(edge.start, edge.end) <= 1e-9 * edge.length)
    return {FigureKind::length, edge.length, {edge.start}, {place.part}};
  return {FigureKind::length, edge.length, {edge.start, edge.end}, {place.part, place.part}};
}

/// Its line goes from the place through the axis to the other side.
Figure diameterFigure(const MeasuredPlace& place) {
  const assets::Cylinder& cylinder = *place.cylinder;
  const glm::dvec3 from = place.point - cylinder.middle;
  const glm::dvec3 centre = cylinder.middle + glm::dot(from, cylinder.axis) * cylinder.axis;
  const double off = glm::distance(place.point, centre);
  const glm::dvec3 out = off > 0.0 ? (place.point - centre) / off : glm::dvec3(0.0);
  return {FigureKind::diameter,
          2.0 * cylinder.radius,
          {centre + cylinder.radius * out, centre - cylinder.radius * out},
          {place.part, place.part}};
}

/// Its line stands upright on the faces or axes.
Figure acrossFigure(const MeasuredPlace& a, const MeasuredPlace& b, double value) {
  const glm::dvec3 from = a.cylinder ? a.cylinder->middle : a.point;
  const glm::dvec3 apart = (b.cylinder ? b.cylinder->middle : b.point) - from;
  glm::dvec3 line(0.0);
  if (a.cylinder && b.cylinder) {
    line = apart - glm::dot(apart, a.cylinder->axis) * a.cylinder->axis;
  } else {
    const glm::dvec3 normal = a.cylinder ? b.normal : a.normal;
    line = glm::dot(apart, normal) * normal;
  }
  return {FigureKind::across, value, {from, from + line}, {a.part, b.part}};
}

}  // namespace

Figure clearanceFigure(const Clash& parts) {
  return {FigureKind::clearance,
          parts.kind == ClashKind::hard ? -parts.depth : parts.distance,
          {parts.onA, parts.onB},
          {parts.a, parts.b},
          parts.open};
}

std::vector<Figure> figuresOf(std::span<const MeasuredPlace> places, const std::optional<Clash>& parts) {
  std::vector<Figure> figures;
  if (places.size() == 1) {
    if (places[0].edge) figures.push_back(lengthFigure(places[0]));
    if (places[0].cylinder) figures.push_back(diameterFigure(places[0]));
  } else if (places.size() == 2) {
    const MeasuredPlace &a = places[0], &b = places[1];
    const MeasuredPair pair = measurePair(a, b);
    const std::vector<glm::dvec3> line{a.point, b.point};
    const std::vector<PartId> of{a.part, b.part};
    figures.push_back({FigureKind::distance, pair.distance, line, of});
    if (pair.across) figures.push_back(acrossFigure(a, b, *pair.across));
    figures.push_back({FigureKind::angle, pair.angle, line, of});
  }
  if (parts) figures.push_back(clearanceFigure(*parts));
  return figures;
}

document::MeasureKind documentKind(FigureKind kind) {
  switch (kind) {
    case FigureKind::length:
      return document::MeasureKind::length;
    case FigureKind::diameter:
      return document::MeasureKind::diameter;
    case FigureKind::angle:
      return document::MeasureKind::angle;
    case FigureKind::clearance:
      return document::MeasureKind::clearance;
    case FigureKind::distance:
    case FigureKind::across:
      break;
  }
  return document::MeasureKind::distance;
}

document::Measure toMeasure(const Figure& figure, const assets::Scene& scene,
                            std::span<const Pose> worldFromPart, std::string name) {
  ASSERT(figure.line.size() == figure.parts.size() && worldFromPart.size() == scene.parts.size());
  document::Measure measure;
  measure.kind = documentKind(figure.kind);
  measure.value = figure.value;
  std::string parts;
  for (std::size_t i = 0; i < figure.line.size(); ++i) {
    const PartId part = figure.parts[i];
    measure.anchors.push_back({part, transformPoint(inverse(worldFromPart[part]), figure.line[i])});
    if (i == 0 || part != figure.parts[0]) parts += (i == 0 ? "" : ", ") + scene.parts[part].name;
  }
  measure.name = name.empty() ? printable(parts, document::kMaxName) : std::move(name);
  return measure;
}

std::string quantityInWords(document::MeasureKind kind, double value) {
  if (kind == document::MeasureKind::angle) return formatted("%.3f deg", glm::degrees(value));
  if (std::abs(value) < 1.0) return formatted("%.4f mm", 1e3 * value);
  return formatted("%.6f m", value);
}

std::vector<std::string> placeInWords(const MeasuredPlace& place) {
  const glm::dvec3 &p = place.point, &n = place.normal;
  std::vector<std::string> words{formatted("at %.3f %.3f %.3f mm", 1e3 * p.x, 1e3 * p.y, 1e3 * p.z),
                                 formatted("faces %.3f %.3f %.3f", n.x, n.y, n.z)};
  if (!place.cylinder) return words;
  const glm::dvec3 &m = place.cylinder->middle, &a = place.cylinder->axis;
  words.push_back(formatted("%s, axis through %.3f %.3f %.3f mm", place.cylinder->hollow ? "bore" : "shaft",
                            1e3 * m.x, 1e3 * m.y, 1e3 * m.z));
  words.push_back(formatted("along %.3f %.3f %.3f", a.x, a.y, a.z));
  return words;
}

}  // namespace tandem::client
