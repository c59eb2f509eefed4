#include "haptics/devices/colocation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <glm/geometric.hpp>
#include <iterator>
#include <sstream>

#include "assets/base/finite.h"
#include "assets/base/json.h"

namespace tandem::haptics {
namespace {

constexpr std::size_t kMostPairs = 100000, kMostBytes = 16u << 20;
constexpr double kFlat = 1e-3;   // second extent relative to the first, below which a set is a line
constexpr double kClear = 1e-3;  // gap between the best and second-best rotation, relative to the spread
constexpr double kPoor = 0.05;   // share of the spread that a bad fit leaves unexplained
constexpr const char* kHeader = "dx,dy,dz,vx,vy,vz";

using Matrix4 = std::array<std::array<double, 4>, 4>;

/// Eigenvalues (descending) and unit eigenvectors (rows) of a symmetric matrix by Jacobi rotations.
template <std::size_t N>
void eigen(std::array<std::array<double, N>, N> a, std::array<double, N>& values,
           std::array<std::array<double, N>, N>& vectors) {
  for (std::size_t i = 0; i < N; ++i)
    for (std::size_t j = 0; j < N; ++j) vectors[i][j] = i == j ? 1.0 : 0.0;
  for (int sweep = 0; sweep < 50; ++sweep) {
    for (std::size_t p = 0; p < N; ++p)
      for (std::size_t q = p + 1; q < N; ++q) {
        if (a[p][q] == 0.0) continue;
        const double theta = 0.5 * std::atan2(2.0 * a[p][q], a[q][q] - a[p][p]);
        const double c = std::cos(theta), s = std::sin(theta);
        for (std::size_t k = 0; k < N; ++k) {
          const double kp = a[k][p], kq = a[k][q];
          a[k][p] = c * kp - s * kq;
          a[k][q] = s * kp + c * kq;
        }
        for (std::size_t k = 0; k < N; ++k) {
          const double pk = a[p][k], qk = a[q][k];
          a[p][k] = c * pk - s * qk;
          a[q][k] = s * pk + c * qk;
          const double vp = vectors[p][k], vq = vectors[q][k];
          vectors[p][k] = c * vp - s * vq;
          vectors[q][k] = s * vp + c * vq;
        }
      }
  }
  std::array<std::size_t, N> order{};
  for (std::size_t i = 0; i < N; ++i) order[i] = i;
  std::ranges::sort(order, [&a](std::size_t i, std::size_t j) { return a[i][i] > a[j][j]; });
  const auto unsorted = vectors;
  for (std::size_t i = 0; i < N; ++i) {
    values[i] = a[order[i]][order[i]];
    vectors[i] = unsorted[order[i]];
  }
}

struct Moments {
  glm::dvec3 device{0.0, 0.0, 0.0}, view{0.0, 0.0, 0.0};  // centroids
  double deviceSquare = 0.0, viewSquare = 0.0;            // sums of squared distances from them
  std::array<std::array<double, 3>, 3> cross{};           // sum of d_i v_j
};

Moments momentsOf(std::span<const PointPair> pairs) {
  Moments m;
  const double share = 1.0 / static_cast<double>(pairs.size());
  for (const PointPair& pair : pairs) {
    m.device += pair.device * share;
    m.view += pair.view * share;
  }
  for (const PointPair& pair : pairs) {
    const glm::dvec3 d = pair.device - m.device, v = pair.view - m.view;
    m.deviceSquare += glm::dot(d, d);
    m.viewSquare += glm::dot(v, v);
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j) m.cross[i][j] += d[static_cast<int>(i)] * v[static_cast<int>(j)];
  }
  return m;
}

/// Whether points lie on a line (or in one place), within a fraction of their extent.
template <typename Get>
bool onALine(std::span<const PointPair> pairs, const glm::dvec3& centre, Get get) {
  std::array<std::array<double, 3>, 3> spread{}, axes{};
  for (const PointPair& pair : pairs) {
    const glm::dvec3 d = get(pair) - centre;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j) spread[i][j] += d[static_cast<int>(i)] * d[static_cast<int>(j)];
  }
  std::array<double, 3> extents{};
  eigen(spread, extents, axes);
  return !(extents[1] > kFlat * kFlat * extents[0]);
}

Matrix4 hornMatrix(const Moments& m) {
  const auto& s = m.cross;
  return {{{s[0][0] + s[1][1] + s[2][2], s[1][2] - s[2][1], s[2][0] - s[0][2], s[0][1] - s[1][0]},
           {s[1][2] - s[2][1], s[0][0] - s[1][1] - s[2][2], s[0][1] + s[1][0], s[2][0] + s[0][2]},
           {s[2][0] - s[0][2], s[0][1] + s[1][0], s[1][1] - s[0][0] - s[2][2], s[1][2] + s[2][1]},
           {s[0][1] - s[1][0], s[2][0] + s[0][2], s[1][2] + s[2][1], s[2][2] - s[0][0] - s[1][1]}}};
}

void measure(std::span<const PointPair> pairs, Colocation& result) {
  double sum = 0.0;
  for (const PointPair& pair : pairs) {
    const double residual = glm::distance(result.toView(pair.device), pair.view);
    sum += residual * residual;
    result.worst = std::max(result.worst, residual);
  }
  result.pairs = pairs.size();
  result.rms = std::sqrt(sum / static_cast<double>(pairs.size()));
}

Result<std::string> readAll(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return Error{path + ": cannot be read"};
  std::string text;
  for (char block[4096]; file.read(block, sizeof block) || file.gcount() > 0;) {
    text.append(block, static_cast<std::size_t>(file.gcount()));
    if (text.size() > kMostBytes) return Error{path + ": too long for a calibration"};
  }
  return text;
}

}  // namespace

Result<Colocation> colocate(std::span<const PointPair> pairs, bool withScale) {
  if (pairs.size() < 3) return Error{"calibration: needs at least three pairs of points"};
  for (const PointPair& pair : pairs)
    if (!isFinite(pair.device) || !isFinite(pair.view))
      return Error{"calibration: a coordinate is not a finite number"};
  const Moments m = momentsOf(pairs);
  if (!std::isfinite(m.deviceSquare) || !std::isfinite(m.viewSquare))
    return Error{"calibration: coordinates are too large"};
  if (onALine(pairs, m.device, [](const PointPair& pair) { return pair.device; }))
    return Error{"calibration: the device's points lie on a line or in one place"};
  if (onALine(pairs, m.view, [](const PointPair& pair) { return pair.view; }))
    return Error{"calibration: the view's points lie on a line or in one place"};

  std::array<double, 4> values{};
  Matrix4 vectors{};
  eigen(hornMatrix(m), values, vectors);
  const double spread = std::sqrt(m.deviceSquare) * std::sqrt(m.viewSquare);
  // What no rotation explains, and what no rotation of the reflected set explains, as fractions of the spread
  // (at best scale).
  const double unexplained = 1.0 - values[0] * values[0] / (spread * spread);
  const double mirrored = 1.0 - values[3] * values[3] / (spread * spread);
  if (unexplained > kPoor && mirrored < 0.25 * unexplained)
    return Error{"calibration: the points of one frame are a mirror image of the other's; check the axes"};
  if (!(values[0] - values[1] > kClear * spread))
    return Error{"calibration: the pairs fit more than one turn equally well"};

  Colocation result;
  const auto& q = vectors[0];
  result.viewFromDevice.orientation = glm::normalize(glm::dquat(q[0], q[1], q[2], q[3]));
  // values[0] is the sum of v . R d.
  if (withScale) result.scale = values[0] / m.deviceSquare;
  if (!(result.scale > 0.0) || !std::isfinite(result.scale))
    return Error{"calibration: the points of the two frames do not belong together"};
  result.viewFromDevice.position = m.view - result.scale * (result.viewFromDevice.orientation * m.device);
  measure(pairs, result);
  // Rejects magnitudes near the limits of a double.
  if (!isValid(result.viewFromDevice) || !std::isfinite(result.rms))
    return Error{"calibration: coordinates are too large or too small"};
  return result;
}

DeviceMapping mappingOf(const Colocation& colocation) {
  return DeviceMapping(colocation.viewFromDevice, colocation.scale);
}

Result<std::vector<PointPair>> parsePairs(const std::string& text, const std::string& name) {
  std::istringstream lines(text);
  std::string line;
  std::vector<PointPair> pairs;
  const auto wrong = [&](std::size_t number, const char* why) {
    return Error{name + ":" + std::to_string(number) + ": " + why};
  };
  for (std::size_t number = 1; std::getline(lines, line); ++number) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (number == 1) {
      if (line != kHeader) return wrong(1, "must begin with dx,dy,dz,vx,vy,vz");
      continue;
    }
    if (line.empty()) continue;
    PointPair p;
    int end = 0;
    const int read = std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf,%lf,%lf%n", &p.device.x, &p.device.y,
                                 &p.device.z, &p.view.x, &p.view.y, &p.view.z, &end);
    if (read != 6 || static_cast<std::size_t>(end) != line.size())
      return wrong(number, "must be six numbers");
    if (!isFinite(p.device) || !isFinite(p.view)) return wrong(number, "a number is not finite");
    if (pairs.size() == kMostPairs) return wrong(number, "too many pairs");
    pairs.push_back(p);
  }
  if (pairs.empty()) return Error{name + ": no pairs (a header " + kHeader + ", then one pair a row, m)"};
  return pairs;
}

std::string toJson(const Colocation& c) {
  const glm::dvec3& p = c.viewFromDevice.position;
  const glm::dquat& q = c.viewFromDevice.orientation;
  Json json;
  json["view_from_device"] = {{"position", {p.x, p.y, p.z}}, {"orientation_wxyz", {q.w, q.x, q.y, q.z}}};
  json["scale"] = c.scale;
  json["residual_rms_m"] = c.rms;
  json["residual_worst_m"] = c.worst;
  json["pairs"] = c.pairs;
  return json.dump(2) + "\n";
}

Result<Colocation> parseColocation(const std::string& text, const std::string& name) {
  const Error wrong{name + ": not a calibration (tandem devices --calibrate PAIRS.csv writes one)"};
  const Result<Json> json = Json::parse(text);
  if (!json) return wrong;
  try {
    Colocation c;
    const Json &pose = json->at("view_from_device"), &p = pose.at("position"),
               &q = pose.at("orientation_wxyz");
    c.viewFromDevice = {{p.at(0).number(), p.at(1).number(), p.at(2).number()},
                        {q.at(0).number(), q.at(1).number(), q.at(2).number(), q.at(3).number()}};
    c.scale = json->at("scale").number();
    if (json->contains("residual_rms_m")) c.rms = json->at("residual_rms_m").number();
    if (json->contains("residual_worst_m")) c.worst = json->at("residual_worst_m").number();
    if (json->contains("pairs")) {
      const Json& pairs = json->at("pairs");
      if (!pairs.isInteger() || pairs.number() < 0.0)
        return Error{name + ": pairs must be a whole number, not negative"};
      c.pairs = static_cast<std::size_t>(pairs.integer());
    }
    if (!isValid(c.viewFromDevice)) return Error{name + ": the pose is not finite or not a unit quaternion"};
    if (!(c.scale >= 1e-6 && c.scale <= 1e6)) return Error{name + ": scale must be between 1e-6 and 1e6"};
    return c;
  } catch (const JsonError&) {
    return wrong;
  }
}

Result<std::vector<PointPair>> loadPairs(const std::string& path) {
  Result<std::string> text = readAll(path);
  if (!text) return text.error();
  return parsePairs(*text, path);
}

Result<Colocation> loadColocation(const std::string& path) {
  Result<std::string> text = readAll(path);
  if (!text) return text.error();
  return parseColocation(*text, path);
}

}  // namespace tandem::haptics
