#include "haptics/devices/colocation.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <sstream>

#include <Eigen/Eigenvalues>
#include <glm/geometric.hpp>

#include "assets/base/assert.h"
#include "assets/base/finite.h"
#include "assets/base/json.h"

namespace tandem::haptics {
namespace {

constexpr std::size_t kMaxPairs = 100000, kMaxBytes = 16u << 20;
constexpr double kFlat = 1e-3;   // second extent relative to the first, below which a set is a line
constexpr double kClear = 1e-3;  // gap between the best and second-best rotation, relative to the spread
constexpr double kPoor = 0.05;   // share of the spread that a bad fit leaves unexplained
constexpr const char* kHeader = "dx,dy,dz,vx,vy,vz";

Eigen::Vector3d toEigen(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

struct Moments {
  glm::dvec3 device{0.0, 0.0, 0.0}, view{0.0, 0.0, 0.0};  // centroids
  double deviceSquare = 0.0, viewSquare = 0.0;            // m^2, sums of squared distances from them
  Eigen::Matrix3d cross = Eigen::Matrix3d::Zero();        // m^2, sum of d v^T: Horn's matrix M
};

Moments momentsOf(std::span<const PointPair> pairs) {
  ASSERT(!pairs.empty());
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
    m.cross += toEigen(d) * toEigen(v).transpose();
  }
  return m;
}

/// Whether points lie on a line (or in one place), within a fraction of their extent.
template <typename Get>
bool onALine(std::span<const PointPair> pairs, const glm::dvec3& centre, Get get) {
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const PointPair& pair : pairs) {
    const Eigen::Vector3d d = toEigen(get(pair) - centre);
    spread += d * d.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(spread, Eigen::EigenvaluesOnly);
  const Eigen::Vector3d extents = solver.eigenvalues();  // ascending
  return !(extents[1] > kFlat * kFlat * extents[2]);
}

/// Horn's matrix N of M: its eigenvector of the largest eigenvalue is the rotation's quaternion, w first.
Eigen::Matrix4d hornMatrix(const Eigen::Matrix3d& s) {
  Eigen::Matrix4d n;
  n << s(0, 0) + s(1, 1) + s(2, 2), s(1, 2) - s(2, 1), s(2, 0) - s(0, 2), s(0, 1) - s(1, 0),  //
      s(1, 2) - s(2, 1), s(0, 0) - s(1, 1) - s(2, 2), s(0, 1) + s(1, 0), s(2, 0) + s(0, 2),   //
      s(2, 0) - s(0, 2), s(0, 1) + s(1, 0), s(1, 1) - s(0, 0) - s(2, 2), s(1, 2) + s(2, 1),   //
      s(0, 1) - s(1, 0), s(2, 0) + s(0, 2), s(1, 2) + s(2, 1), s(2, 2) - s(0, 0) - s(1, 1);
  return n;
}

void measure(std::span<const PointPair> pairs, Colocation& result) {
  ASSERT(!pairs.empty() && result.scale > 0.0);
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
    if (text.size() > kMaxBytes) return Error{path + ": too long for a calibration"};
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

  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(hornMatrix(m.cross));
  const Eigen::Vector4d values = solver.eigenvalues();  // ascending
  if (solver.info() != Eigen::Success) return Error{"calibration: coordinates are too large"};
  const double spread = std::sqrt(m.deviceSquare) * std::sqrt(m.viewSquare);
  // The shares of the spread that the best rotation leaves unexplained, and the best rotation of the
  // reflected set, at the best scale.
  const double unexplained = 1.0 - values[3] * values[3] / (spread * spread);
  const double mirrored = 1.0 - values[0] * values[0] / (spread * spread);
  if (unexplained > kPoor && mirrored < 0.25 * unexplained)
    return Error{"calibration: the points of one frame are a mirror image of the other's; check the axes"};
  if (!(values[3] - values[2] > kClear * spread))
    return Error{"calibration: the pairs fit more than one turn equally well"};

  Colocation result;
  Eigen::Vector4d q = solver.eigenvectors().col(3);
  if (q[0] < 0.0) q = -q;  // both signs are the same rotation
  result.viewFromDevice.orientation = glm::normalize(glm::dquat(q[0], q[1], q[2], q[3]));
  // The largest eigenvalue is the sum of v . R d. Umeyama 1991, eq. 42: the scale is that sum over the
  // device's spread.
  if (withScale) result.scale = values[3] / m.deviceSquare;
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
    if (pairs.size() == kMaxPairs) return wrong(number, "too many pairs");
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
