#include "assets/gltf/gltf_cad.h"

#include <cmath>
#include <optional>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include "assets/base/printable.h"
#include "assets/gltf/gltf_error.h"
#include "assets/gltf/gltf_json.h"
#include "assets/scene/value_ranges.h"

namespace tandem::assets {
namespace {

constexpr double kUneven = 1e-6;   // by which a scale may differ between directions
constexpr double kNotUnit = 1e-3;  // by which the length of an axis may be off
constexpr double kLongest = 1e6;   // m, radius or height
constexpr std::size_t kMostFindings = 100, kLongestCode = 60, kLongestMessage = 500;  // bytes
constexpr std::size_t kMostOfNode = 200, kLongestTolerance = 200;  // tolerances; bytes of one

/// How much a map scales all directions alike; nothing if it does not.
std::optional<double> evenScale(const glm::dmat4& map) {
  const glm::dmat3 m(map);
  const double scale = glm::length(m[0]), off = kUneven * scale;
  if (!(scale > 0.0) || std::abs(glm::length(m[1]) - scale) > off ||
      std::abs(glm::length(m[2]) - scale) > off)
    return std::nullopt;
  for (int i = 0; i < 3; ++i)
    if (std::abs(glm::dot(m[i], m[(i + 1) % 3])) > off * scale) return std::nullopt;
  return scale;
}

/// A face in its mesh; nothing of another kind. Throws GltfError where a cylinder lacks something.
std::optional<RoundFace> readFace(const Json& value) {
  const JsonObject face(value, "extras.cad.faces");
  if (face.text("kind", "") != "cylinder") return std::nullopt;
  const auto point = face.vector("point"), axis = face.vector("axis");
  const auto radius = face.number("radius"), from = face.number("from"), to = face.number("to");
  if (!point || !axis || !radius || !from || !to) face.fail("cylinder", "is not complete");
  return RoundFace{*point,
                   *axis,
                   *radius,
                   *from,
                   *to,
                   face.flag("hollow", false),
                   face.number("turn").value_or(2.0 * kPi)};
}

/// Places a face in its part; false if it is not one that contact can use.
bool placeFace(RoundFace& face, const glm::dmat4& partFromMesh, double scale) {
  const double length = glm::length(face.axis);
  if (!(std::abs(length - 1.0) < kNotUnit)) return false;
  face.axis = glm::normalize(glm::dmat3(partFromMesh) * (face.axis / length));
  face.point = glm::dvec3(partFromMesh * glm::dvec4(face.point, 1.0));
  face.radius *= scale;
  face.from *= scale;
  face.to *= scale;
  return nearOrigin(face.point) && face.radius > 0.0 && face.radius < kLongest && face.from < face.to &&
         std::abs(face.from) < kLongest && std::abs(face.to) < kLongest;
}

}  // namespace

RoundFaces readRoundFaces(const GltfDocument& document, const std::vector<MeshPiece>& pieces,
                          std::uint64_t& damaged) {
  RoundFaces found;
  const Json& meshes = document.json.member("meshes");
  for (const MeshPiece& piece : pieces) {
    const Json& faces = meshes.at(piece.mesh).member("extras").member("cad").member("faces");
    if (faces.isAbsent()) continue;
    if (!faces.isArray()) {
      ++damaged;
      continue;
    }
    const std::optional<double> scale = evenScale(piece.partFromMesh);
    for (std::size_t i = 0; i < faces.size(); ++i) {
      try {
        std::optional<RoundFace> face = readFace(faces.at(i));
        if (!face) continue;
        if (scale && placeFace(*face, piece.partFromMesh, *scale)) {
          found.faces.push_back(*face);
        } else {
          ++damaged;
        }
      } catch (const GltfError&) {
        ++damaged;
      }
    }
  }
  return found;
}

std::vector<std::string> readTolerances(const GltfDocument& document, std::size_t gltfNode) {
  std::vector<std::string> stated;
  const Json& list =
      document.json.member("nodes").at(gltfNode).member("extras").member("cad").member("tolerances");
  if (!list.isArray()) return stated;
  for (std::size_t i = 0; i < list.size() && stated.size() < kMostOfNode; ++i) {
    if (!list.at(i).isText()) continue;
    std::string words = printable(list.at(i).text(), kLongestTolerance);
    if (!words.empty()) stated.push_back(std::move(words));
  }
  return stated;
}

std::vector<Finding> readImportFindings(const GltfDocument& document) {
  std::vector<Finding> findings;
  const Json& list = document.json.member("asset").member("extras").member("cad").member("findings");
  if (!list.isArray()) return findings;
  for (std::size_t i = 0; i < list.size() && findings.size() < kMostFindings; ++i) {
    const Json &code = list.at(i).member("code"), &count = list.at(i).member("count"),
               &message = list.at(i).member("message");
    if (!code.isText() || !count.isNatural() || !message.isText()) continue;
    findings.push_back({Finding::Severity::warning, "import-" + printable(code.text(), kLongestCode), "",
                        count.integer(), printable(message.text(), kLongestMessage)});
  }
  return findings;
}

}  // namespace tandem::assets
